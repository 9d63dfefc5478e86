#include "sinew/devices/feetech/feetech_driver.h"

#include <algorithm>
#include <cmath>

#include "sinew/core/assert.h"
#include "sinew/core/error_code.h"

namespace sinew {

using namespace feetech;
using Kind = DriverEvent::Kind;

namespace {

/// rad that a joint may be from where a motion was planned to begin: servos give way under load.
constexpr double kElsewhere = 0.09;
constexpr double kFreeAcceleration = 150;  // rad/s^2, by gravity or a hand
/// Of a joint's highest speed: a goal that was damaged on its way is gone to as fast as a servo
/// can.
constexpr double kFastShare = 1.8;
constexpr double kSpeedShare = 1.2;  // of the speed that a servo reports

}  // namespace

FeetechDriver::FeetechDriver(const FeetechDevice& device, std::span<const Joint> joints,
                             const std::optional<JawGripper>& gripper, const FeetechTiming& timing)
    : servos_(device, joints, gripper), timing_(timing), bus_(timing.bus) {
  positions_.resize(joints.size());
}

// Opening and closing

void FeetechDriver::open(Instant now) {
  if (activity_ != Activity::kClosed) close(now);
  now_ = now;
  fault_.reset();
  told_silent_ = false;
  goes_on_until_.reset();
  begin_anew({}, now);
}

/// Asks each servo what it is; what was known of them is worth nothing.
void FeetechDriver::begin_anew(const Error& why, Instant now) {
  commands_.end_all(Kind::kFailed, why);
  activity_ = Activity::kOpening;
  clearing_ = cycled_ = false;
  servos_.forget();
  bus_.reset(now);
  queue_.clear();
  switch_.reset();
  jaws_.reset();
  health_.jaws_width.reset();
  opening_ = 0;
  round_.clear();
  round_open_ = one_by_one_ = false;
  broken_rounds_ = 0;
  beside_.fill(0);
  stuck_ = 0;
  told_ = on_ = set_up_ = 0;
  poll_due_ = opened_at_ = now;
  for (JointPosition& joint : positions_) joint = {};
}

void FeetechDriver::close(Instant now) {
  now_ = std::max(now_, now);
  if (activity_ == Activity::kClosed) return;
  begin_anew({ErrorCode::kPortClosed}, now_);
  commands_.end_stop();
  activity_ = Activity::kClosed;
}

DriverState FeetechDriver::state() const {
  switch (activity_) {
    case Activity::kClosed:
      return DriverState::kClosed;
    case Activity::kOpening:
      return DriverState::kOpening;
    case Activity::kMoving:
    case Activity::kJaws:
    case Activity::kSwitching:
      return DriverState::kMoving;
    case Activity::kStopping:
      return DriverState::kStopping;
    case Activity::kIdle:
      break;
  }
  return fault_ ? DriverState::kFault : DriverState::kReady;
}

std::optional<Instant> FeetechDriver::goes_on_until() const {
  return goes_on_until_ && now_ < *goes_on_until_ ? goes_on_until_ : std::nullopt;
}

DeviceFacts FeetechDriver::facts() const {
  FeetechFacts facts;
  facts.count = servos_.size();
  for (std::size_t i = 0; i < facts.count; ++i) facts.servos[i] = servos_[i];
  return DeviceFacts(facts);
}

bool FeetechDriver::free() const {
  const bool open = activity_ != Activity::kClosed && activity_ != Activity::kOpening;
  return open && !servos_.held();
}

// What is asked for

Expected<void> FeetechDriver::may_begin() const {
  if (activity_ == Activity::kClosed) return std::unexpected(Error{ErrorCode::kPortClosed});
  if (fault_) return std::unexpected(*fault_);
  if (activity_ != Activity::kIdle) return std::unexpected(Error{ErrorCode::kBusy});
  return {};
}

bool FeetechDriver::wants_move(Instant /*now*/) const {
  if (fault_) return false;
  if (activity_ == Activity::kIdle) return true;
  return activity_ == Activity::kMoving && !queue_.full() && !rests_;
}

Expected<void> FeetechDriver::check_start(const JointMove& move) const {
  for (std::size_t i = 0; i < move.q_start.size() && i < servos_.joints(); ++i) {
    const double here = servos_.q(i);
    if (std::abs(here - move.q_start[i]) <= kElsewhere) continue;
    return std::unexpected(
        Error{ErrorCode::kMovedUnasked, static_cast<std::int8_t>(i), here, move.q_start[i]});
  }
  return {};
}

/// What its servo is held at, where that is near where it is: units.
double FeetechDriver::base_of(std::size_t i) const {
  const FeetechServoState& servo = servos_[i];
  if (!servo.torque) return servo.units;
  const double goal = (told_ & servo_bit(i)) != 0 ? goal_[i] : servo.goal;
  const double near = 2 * kElsewhere * servos_.device().units_per_rad();
  return std::abs(goal - servo.units) <= near ? goal : servo.units;
}

Expected<void> FeetechDriver::move(const JointMove& move, Instant now) {
  poll(now);
  const bool follows = activity_ == Activity::kMoving && wants_move(now);
  if (!follows) {
    if (const auto may = may_begin(); !may) return may;
    if (const auto start = check_start(move); !start) return start;
  }
  const std::size_t joints = servos_.joints();
  std::array<segments::Setpoint, kMaxJoints> start{};
  for (std::size_t i = 0; i < joints; ++i) {
    const bool given = i < move.q_start.size();
    start[i] = follows ? target_[i] : segments::Setpoint{given ? move.q_start[i] : servos_.q(i), 0};
  }
  const std::uint8_t all = joints_mask();
  const bool switches = !follows && (!servos_.held() || (set_up_ & all) != all);
  if (switches) {
    if (const auto beyond = servos_.beyond_turn(all)) return std::unexpected(*beyond);
  }
  const Duration lead = switches ? std::max(timing_.lead, 4 * tick()) : Duration{};
  const Instant begins = now_ + lead - (follows ? lag_ : Duration{});
  const auto pushed = queue_.push(move, servos_.limits(), {start.data(), joints}, begins);
  if (!pushed) return pushed;
  rests_ = queue_.back().ends_at_rest;
  commands_.accept();
  last_piece_ = now_;
  if (follows) return {};
  lag_ = {};
  missed_.reset();
  began_ = told_for_ = begins;
  tick_due_ = now_;
  behind_.fill(0);
  corrections_ = 0;
  goes_on_until_.reset();
  for (std::size_t i = 0; i < joints; ++i) {
    // What its load has taken is seen as it rests, where nothing was in its way.
    const double most = kCorrectMost * servos_.device().units_per_rad();
    const double seen = std::clamp(base_of(i) - servos_[i].units, -most, most);
    if ((stuck_ & servo_bit(i)) == 0) beside_[i] = seen;
    jump_[i] = base_of(i) - servos_.units_of(i, start[i].q) - beside_[i];
    goal_[i] = base_of(i);
  }
  stuck_ = 0;
  if (switches) switch_ = Switch{.servos = all};
  activity_ = Activity::kMoving;
  poll(now);
  return {};
}

Expected<void> FeetechDriver::tool(const ToolAction& action, Instant now) {
  poll(now);
  const auto* to = std::get_if<JawsTo>(&action);
  if (to == nullptr || !servos_.has_jaws())
    return std::unexpected(Error{ErrorCode::kToolNotFitted});
  const double most = *servos_.width_max();
  if (!(to->width >= 0 && to->width <= most + 1e-6)) {
    return std::unexpected(Error{ErrorCode::kJawWidth, -1, to->width, most});
  }
  if (const auto may = may_begin(); !may) return may;
  const std::size_t i = servos_.jaws();
  if (const auto beyond = servos_.beyond_turn(servo_bit(i))) return std::unexpected(*beyond);
  const FeetechDevice::Gripper& gripper = servos_.device().gripper;
  const double units = servos_.units_of_width(to->width);
  const double from = base_of(i);
  const double share = std::abs(units - from) / std::abs(gripper.open - gripper.closed);
  jaws_ = Jaws{.from = from, .to = units, .start = now_, .end = {}};
  jaws_->end = now_ + from_seconds(share * to_seconds(FeetechDevice::kJawsStroke));
  goal_[i] = from;
  moved_at_[i] = tick_due_ = told_for_ = now_;
  if (!servos_[i].torque || (set_up_ & servo_bit(i)) == 0) switch_ = Switch{.servos = servo_bit(i)};
  health_.jaws_width.reset();
  commands_.accept();
  activity_ = Activity::kJaws;
  poll(now);
  return {};
}

Expected<void> FeetechDriver::service(DeviceService what, Instant now) {
  poll(now);
  if (what != DeviceService::kFree && what != DeviceService::kHold) {
    return std::unexpected(Error{ErrorCode::kNoSuchService});
  }
  if (const auto may = may_begin(); !may) return may;
  const bool holds = what == DeviceService::kHold;
  const auto beyond = servos_.beyond_turn(joints_mask());
  if (holds && beyond) return std::unexpected(*beyond);
  switch_ = Switch{.servos = joints_mask(), .on = holds};
  // A joint that was held stays at its goal, beside which its load has it.
  for (std::size_t i = 0; i < servos_.joints(); ++i) goal_[i] = base_of(i);
  commands_.accept();
  tick_due_ = now_;
  activity_ = Activity::kSwitching;
  poll(now);
  return {};
}

void FeetechDriver::stop(Instant now) {
  poll(now);
  if (activity_ == Activity::kClosed) return;
  commands_.ask_stop();
  if (activity_ == Activity::kOpening || activity_ == Activity::kStopping) return;
  begin_stop(now_);
  poll(now);
}

/// Each joint brakes from the goal that it was told last.
void FeetechDriver::begin_stop(Instant now) {
  const bool braking = activity_ == Activity::kMoving && !switch_;
  const Instant from = std::max(now, told_for_);
  over_at_ = now;
  for (std::size_t i = 0; braking && i < servos_.joints(); ++i) {
    target_[i] = setpoint(i, from);
    const double time = std::abs(target_[i].qd) / servos_.joint(i).acceleration_max;
    over_at_ = std::max(over_at_, from + from_seconds(time));
  }
  told_for_ = braking ? from : now;
  const bool jaws = activity_ == Activity::kJaws && !switch_;
  if (jaws) {
    // What they have taken hold of they keep.
    const double here = servos_[servos_.jaws()].units;
    const double on = std::clamp(goal_[servos_.jaws()] - here, -kSqueeze, kSqueeze);
    jaws_ = Jaws{.from = here + on, .to = here + on, .start = now, .end = now};
  } else {
    jaws_.reset();
  }
  // Nothing tells what a switching that was broken off has come to.
  if (switch_) set_up_ = static_cast<std::uint8_t>(set_up_ & ~switch_->servos);
  switch_.reset();
  brakes_ = braking;
  relieved_ = false;
  brake_at_ = from;
  queue_.clear();
  rests_ = true;
  activity_ = Activity::kStopping;
  tick_due_ = now;
}

Expected<void> FeetechDriver::clear_fault(Instant now) {
  poll(now);
  if (activity_ == Activity::kClosed) return std::unexpected(Error{ErrorCode::kPortClosed});
  if (activity_ != Activity::kIdle) return std::unexpected(Error{ErrorCode::kBusy});
  if (!fault_) return {};
  begin_anew({}, now_);
  fault_.reset();
  clearing_ = true;
  commands_.accept();
  return {};
}

std::uint8_t FeetechDriver::joints_mask() const {
  return static_cast<std::uint8_t>(servo_bit(servos_.joints()) - 1U);
}

void FeetechDriver::fail(const Error& error, Instant now) {
  fault_ = error;
  clearing_ = false;
  commands_.fail(error);
  const bool opening = activity_ == Activity::kOpening;
  if (opening || activity_ == Activity::kIdle) {
    activity_ = Activity::kIdle;
    if (opening) commands_.end_stop();
    return;
  }
  if (activity_ != Activity::kStopping) begin_stop(now);
}

/// Its servos hold the goals that they heard last.
void FeetechDriver::fall_silent(Instant now) {
  const double waited = to_seconds(now - std::max(opened_at_, servos_[0].at));
  const Error error{ErrorCode::kDeviceSilent, -1, waited, waited};
  const bool opening = activity_ == Activity::kOpening;
  if (commands_.open() == 0 && !told_silent_) {
    commands_.tell(opening ? Kind::kFailed : Kind::kNotice, error);
  }
  told_silent_ = true;
  if (ticks()) goes_on_until_ = now + 2 * tick();
  begin_anew(error, now);
  commands_.end_stop();
  poll_due_ = now + timing_.silent_retry;
}

void FeetechDriver::update_positions(Instant now) {
  if (activity_ == Activity::kClosed) return;
  const double step = 1 / servos_.device().units_per_rad();
  for (std::size_t i = 0; i < servos_.joints(); ++i) {
    const FeetechServoState& servo = servos_[i];
    positions_[i] = {};
    const bool silent = !servo.known || servo.missed >= timing_.tries;
    if (silent || activity_ == Activity::kOpening) continue;
    const bool rests = servo.torque && !ticks();
    const bool falls = !servo.torque || (rests && servo.missed > 0);
    double age = to_seconds(now - servo.at);
    const double seen = std::abs(servo.speed) * step;
    double gone = step;
    if (falls) {
      gone += age * (kSpeedShare * seen + age * kFreeAcceleration);
    } else if (rests) {
      gone += 2 * step + age * 2 * seen;
    } else {
      // Of one width for all of a motion, as it is recorded.
      age = std::max(age, to_seconds(2 * tick()));
      gone += age * std::max(kFastShare * servos_.joint(i).velocity_max, seen);
    }
    const double q = servos_.q(i);
    const double other = servo.suspect ? servos_.device().q_of(i, *servo.suspect) : q;
    positions_[i] = {PositionQuality::kMeasured, q, std::min(q - gone, other - step),
                     std::max(q + gone, other + step)};
  }
}

// Time and bytes

void FeetechDriver::poll(Instant now) {
  now_ = std::max(now_, now);
  if (activity_ == Activity::kClosed) return;
  wait_for_host(now_);
  if (const Ids missing = bus_.give_up(now_); !missing.empty()) take_miss(missing, now_);
  step_motion(now_);
  ask_what_is_due(now_);
  update_positions(now_);
}

std::optional<Instant> FeetechDriver::next_deadline() const {
  if (activity_ == Activity::kClosed) return std::nullopt;
  Instant due = Instant::max();
  const auto at_least = [&](Instant instant) { due = std::min(due, instant); };
  if (const auto reply = bus_.deadline()) at_least(*reply);
  const Instant asks = std::max(bus_.wire_free(), bus_.late_until());
  if (!bus_.asking()) at_least(std::max(round_open_ ? now_ : poll_due_, asks));
  if (ticks()) at_least(std::max(tick_due_, bus_.wire_free()));
  if (!queue_.empty()) at_least(queue_.front().end + lag_);
  return std::max(due, now_ + std::chrono::microseconds(100));
}

void FeetechDriver::receive(std::span<const std::uint8_t> bytes, Instant now) {
  now_ = std::max(now_, now);
  wait_for_host(now_);
  for (const std::uint8_t byte : bytes) {
    if (activity_ == Activity::kClosed) return;
    if (const auto reply = bus_.receive(byte, now_, health_)) take(*reply, now_);
  }
  poll(now);
}

}  // namespace sinew
