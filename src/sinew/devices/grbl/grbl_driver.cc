#include "sinew/devices/grbl/grbl_driver.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "sinew/core/assert.h"
#include "sinew/core/error_code.h"
#include "sinew/driver/send_range.h"

namespace sinew {

using namespace grbl;
using Kind = DriverEvent::Kind;

namespace {

constexpr double kBitsPerByte = 10;
/// Segments beside those that its planner needs to brake in: one under way, three on the wire and
/// in the host's own cycles.
constexpr std::size_t kSpareSegments = 4;

Error joint_error(ErrorCode code, std::size_t joint, double measured = 0, double limit = 0) {
  return {code, static_cast<std::int8_t>(joint), measured, limit};
}

}  // namespace

GrblDriver::GrblDriver(const GrblDevice& device, std::span<const Joint> joints, std::uint32_t baud,
                       const GrblTiming& timing)
    : device_(device),
      joints_(joints),
      timing_(timing),
      line_time_(from_seconds((kLineMax + 1) * kBitsPerByte / baud)),
      known_(device),
      settings_(device, joints),
      motion_(device, joints) {
  SINEW_ASSERT(joints.size() == device.axes.size() && !joints.empty() && baud > 0);
  for (const Joint& joint : joints) {
    braking_ = std::max(braking_, from_seconds(joint.velocity_max / joint.acceleration_max));
  }
  // Braking takes half as far as the same time at full speed.
  const double needed = std::ceil(to_seconds(braking_) / 2 / to_seconds(timing.segment));
  ahead_ = std::min(GrblMotion::kPiecesMax, kSpareSegments + static_cast<std::size_t>(needed));
  positions_.resize(joints.size());
  timing_.reply_timeout += 2 * line_time_;
}

// Opening and closing

void GrblDriver::open(Instant now) {
  if (activity_ != Activity::kClosed) close(now);
  now_ = now;
  fault_.reset();
  told_silent_ = false;
  decoder_.reset();
  blind_ = false;
  begin_steps(Activity::kOpening, Step::kLook, now);
}

void GrblDriver::close(Instant now) {
  now_ = std::max(now_, now);
  if (activity_ == Activity::kClosed) return;
  leave_to_itself();
  end_commands(Kind::kFailed, {ErrorCode::kPortClosed});
  end_stop();
  activity_ = Activity::kClosed;
  output_.clear();
  update_positions(now_);
}

/// The board is not heard any more. What it has it carries out.
void GrblDriver::leave_to_itself() {
  const bool moves = activity_ == Activity::kMoving || activity_ == Activity::kNudging ||
                     activity_ == Activity::kStopping;
  if (moves && ends_at_) goes_on_until_ = std::max(*ends_at_, now_) + braking_;
  if (activity_ == Activity::kHoming) {
    left_searching_ = true;
    goes_on_until_ = lines_since_ + timing_.homing_limit;
  }
  known_.leave(moves ? std::span<const JointInterval>(reach_.data(), reach_.size())
                     : std::span<const JointInterval>());
}

/// What was said is worth nothing from here on: a reset follows, unless nothing moves by it.
void GrblDriver::begin_steps(Activity activity, Step step, Instant now) {
  activity_ = activity;
  step_ = step;
  motion_.clear();
  output_.clear();
  lines_.clear();
  unanswered_ = 0;
  reset_at_.reset();
  asked_at_.reset();
  suspect_.reset();
  unheard_ = 0;
  poll_due_ = now;
  unlocked_ = marked_ = locked_ = listed_again_ = foreign_ = false;
  looks_ = 0;
  offset_.clear();
  stood_.clear();
  alarm_ = 0;
}

DriverState GrblDriver::state() const {
  switch (activity_) {
    case Activity::kClosed:
      return DriverState::kClosed;
    case Activity::kOpening:
      return DriverState::kOpening;
    case Activity::kMoving:
    case Activity::kNudging:
    case Activity::kHoming:
      return DriverState::kMoving;
    case Activity::kStopping:
    case Activity::kAlarm:
      return DriverState::kStopping;
    case Activity::kIdle:
      break;
  }
  return fault_ ? DriverState::kFault : DriverState::kReady;
}

std::optional<Instant> GrblDriver::goes_on_until() const {
  return goes_on_until_ && now_ < *goes_on_until_ ? goes_on_until_ : std::nullopt;
}

// What is asked for

Expected<void> GrblDriver::may_begin() const {
  if (activity_ == Activity::kClosed) return std::unexpected(Error{ErrorCode::kPortClosed});
  if (fault_) return std::unexpected(*fault_);
  if (activity_ != Activity::kIdle) return std::unexpected(Error{ErrorCode::kBusy});
  if (foreign_) return std::unexpected(Error{ErrorCode::kForeignMotion});
  return {};
}

/// Not by a board that wants to find its switches first.
Expected<void> GrblDriver::may_move() const {
  if (const auto may = may_begin(); !may) return may;
  if (locked_) return std::unexpected(Error{ErrorCode::kNotHomed, -1});
  return {};
}

bool GrblDriver::wants_move(Instant now) const {
  if (fault_ || known_.unknown()) return false;
  if (activity_ == Activity::kIdle) return !foreign_;
  if (activity_ != Activity::kMoving || motion_.full()) return false;
  return motion_.empty() || (!motion_.last().rest && motion_.waiting(now) < ahead_);
}

Expected<void> GrblDriver::move(const JointMove& move, Instant now) {
  poll(now);
  const bool follows = activity_ == Activity::kMoving && wants_move(now);
  if (!follows) {
    if (const auto may = may_move(); !may) return may;
    if (const auto joint = known_.unknown()) {
      return std::unexpected(joint_error(ErrorCode::kPositionUnknown, *joint));
    }
    for (std::size_t i = 0; i < move.q_start.size(); ++i) {
      const double here = positions_[i].q;
      if (std::abs(here - move.q_start[i]) <= device_.from_units(i, motion_.tolerance(i))) continue;
      return std::unexpected(joint_error(ErrorCode::kMovedUnasked, i, here, move.q_start[i]));
    }
  }
  if (!follows) motion_.begin(known_.counts());
  const bool first = motion_.empty();
  if (const auto taken = motion_.push(move, known_, now); !taken) return taken;
  if (first) changed_ = now;
  if (!follows) begin_reach();
  for (std::size_t i = 0; i < joints_.size(); ++i) reach_to(i, move.q[i]);
  last_piece_ = now;
  commands_.accept();
  activity_ = Activity::kMoving;
  say_moves(now);
  ends_at_ = now + motion_.left(now);
  look_at_the_end(now);
  return {};
}

Expected<void> GrblDriver::nudge(std::size_t joint, double way, Duration duration, Instant now) {
  poll(now);
  const auto jog = jog_of(joint, way, duration);
  if (!jog) return std::unexpected(jog.error());
  if (!say(*jog, Sent::kOther)) return std::unexpected(Error{ErrorCode::kBusy});
  probes_ = false;
  begin_nudge(*jog, way, now);
  return {};
}

Expected<void> GrblDriver::probe(std::size_t joint, double way, Duration duration, Instant now) {
  poll(now);
  const auto jog = jog_of(joint, way, duration);
  if (!jog) return std::unexpected(jog.error());
  if (const auto may = may_probe(); !may) return may;
  const Probe probe{jog->axis, jog->by, jog->rate};
  if (!say(probe, Sent::kOther)) return std::unexpected(Error{ErrorCode::kBusy});
  modes_ = false;
  say(Modes{}, Sent::kModes);
  facts_.touched.reset();
  probes_ = true;
  begin_nudge(*jog, way, now);
  return {};
}

Expected<void> GrblDriver::may_probe() const {
  const bool closed = facts_.board && facts_.board->what.pins.probe;
  return closed ? Expected<void>(std::unexpected(Error{ErrorCode::kProbeClosed}))
                : Expected<void>();
}

Expected<Jog> GrblDriver::jog_of(std::size_t joint, double way, Duration duration) const {
  SINEW_ASSERT(joint < joints_.size());
  if (const auto may = may_move(); !may) return std::unexpected(may.error());
  Jog jog{joint, std::round(known_.units(joint, way) * 1e3) / 1e3, 0};
  // Written so that NaN is refused too.
  const bool slides = joints_[joint].slides();
  const double most = slides ? GrblDevice::kNudgeMaxSliding : GrblDevice::kNudgeMax;
  const bool inside = std::abs(way) >= device_.resolution(joint) / 2 &&
                      std::abs(way) <= most * (1 + 1e-9) && jog.by != 0;
  if (!inside) return std::unexpected(joint_error(ErrorCode::kNudgeRange, joint, way, most));
  const double rate_max = device_.to_units(joint, joints_[joint].velocity_max);
  const double seconds = std::max(to_seconds(duration), 1e-3);
  jog.rate = 60 * std::min(std::abs(jog.by) / seconds, rate_max);
  return jog;
}

/// The line of it has been said.
void GrblDriver::begin_nudge(const Jog& jog, double way, Instant now) {
  nudge_from_ = nudge_to_ = known_.counts();
  nudge_to_[jog.axis] += jog.by;
  nudge_joint_ = static_cast<std::uint8_t>(jog.axis);
  begin_reach();
  reach_to(jog.axis, positions_[jog.axis].lower + std::min(way, 0.0));
  reach_to(jog.axis, positions_[jog.axis].upper + std::max(way, 0.0));
  commands_.accept();
  activity_ = Activity::kNudging;
  changed_ = now + from_seconds(60 * std::abs(jog.by) / jog.rate);
  ends_at_ = changed_;
  poll_due_ = now + timing_.arrival_poll;
}

Expected<void> GrblDriver::home(Instant now, std::uint8_t /*joints*/) {
  poll(now);
  if (!device_.homes) return std::unexpected(Error{ErrorCode::kNoEndStops});
  if (const auto may = may_begin(); !may) return may;
  if (!say(Home{}, Sent::kOther)) return std::unexpected(Error{ErrorCode::kBusy});
  say(Modes{}, Sent::kModes);  // a board's own startup lines follow
  known_.lose();
  commands_.accept();
  activity_ = Activity::kHoming;
  asked_at_.reset();
  step_ = Step::kPlace;
  update_positions(now_);
  return {};
}

void GrblDriver::stop(Instant now) {
  poll(now);
  if (activity_ == Activity::kClosed) return;
  const bool rests = activity_ == Activity::kIdle;
  if (rests) {
    commands_.tell_stopped();
    return;
  }
  commands_.ask_stop();
  // Opening stops it as well.
  if (activity_ == Activity::kOpening) return;
  if (activity_ != Activity::kStopping && activity_ != Activity::kAlarm) begin_stop(now_);
}

/// It brakes on its path; but in a search for switches only a reset ends it.
void GrblDriver::begin_stop(Instant now) {
  const bool searches = activity_ == Activity::kHoming;
  const bool jogs = activity_ == Activity::kNudging && !probes_;
  begin_steps(Activity::kStopping, searches ? Step::kReset : Step::kLook, now);
  if (searches) {
    reset_board(now);
  } else {
    say_now(jogs ? RealTime::kJogCancel : RealTime::kHold);
  }
}

Expected<void> GrblDriver::clear_fault(Instant now) {
  poll(now);
  if (activity_ == Activity::kClosed) return std::unexpected(Error{ErrorCode::kPortClosed});
  if (!fault_ && activity_ == Activity::kIdle) return {};
  if (activity_ != Activity::kIdle) return std::unexpected(Error{ErrorCode::kBusy});
  fault_.reset();
  clearing_ = true;
  commands_.accept();
  begin_steps(Activity::kOpening, Step::kLook, now_);
  return {};
}

void GrblDriver::declare_positions(std::span<const JointPosition> positions) {
  if (activity_ != Activity::kClosed && activity_ != Activity::kIdle) return;
  known_.declare(positions);
  update_positions(now_);
}

// Events

void GrblDriver::end_commands(Kind kind, const Error& error) {
  commands_.end_all(kind, error);
  motion_.clear();
  clearing_ = false;
}

void GrblDriver::end_stop() {
  if (!commands_.stop_asked()) return;
  commands_.end_stop();
  end_commands(Kind::kStopped);
}

void GrblDriver::fail(const Error& error) {
  fault_ = error;
  // A stop that was asked for is an end of its own.
  if (!commands_.stop_asked()) commands_.fail(error);
  end_commands(Kind::kFailed, error);
}

void GrblDriver::fall_silent(Instant now) {
  const double waited = to_seconds(timing_.tries * timing_.reply_timeout);
  const Error error{ErrorCode::kDeviceSilent, -1, waited, waited};
  if (commands_.open() == 0 && !told_silent_) {
    commands_.tell(activity_ == Activity::kOpening ? Kind::kFailed : Kind::kNotice, error);
  }
  told_silent_ = true;
  leave_to_itself();
  end_commands(Kind::kFailed, error);
  begin_steps(Activity::kOpening, Step::kLook, now);
  end_stop();
  poll_due_ = now + timing_.silent_retry;
}

/// Its power was away, or its reset was pressed.
void GrblDriver::note_restart(Instant now) {
  const Error error{ErrorCode::kDeviceRestarted};
  known_.restart();
  if (activity_ != Activity::kOpening) {
    if (commands_.open() == 0) commands_.tell(Kind::kNotice, error);
    end_commands(Kind::kFailed, error);
    end_stop();
    known_.leave();
    known_.restart();
  }
  const bool clears = clearing_;
  begin_steps(Activity::kOpening, Step::kLook, now);
  clearing_ = clears;
}

// Positions

void GrblDriver::begin_reach() {
  reach_.clear();
  for (const JointPosition& joint : positions_) reach_.push_back({joint.lower, joint.upper});
}

void GrblDriver::reach_to(std::size_t joint, double q) {
  const double slack = device_.resolution(joint);
  reach_[joint].lower = std::min(reach_[joint].lower, q - slack);
  reach_[joint].upper = std::max(reach_[joint].upper, q + slack);
}

void GrblDriver::update_positions(Instant now) {
  const bool stands = activity_ == Activity::kIdle || activity_ == Activity::kClosed;
  const Duration age = now - counted_at_;
  for (std::size_t i = 0; i < joints_.size(); ++i) {
    const double gone = stands ? 0 : to_seconds(age + line_time_) * joints_[i].velocity_max;
    positions_[i] = activity_ == Activity::kMoving
                        ? known_.position(i, gone, motion_.ahead(i, known_.counts()[i]))
                        : known_.position(i, gone);
  }
}

}  // namespace sinew
