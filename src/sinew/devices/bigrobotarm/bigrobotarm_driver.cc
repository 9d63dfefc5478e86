#include "sinew/devices/bigrobotarm/bigrobotarm_driver.h"

#include <algorithm>
#include <cmath>

#include "sinew/core/assert.h"
#include "sinew/core/error_code.h"
#include "sinew/core/units.h"

namespace sinew {

using namespace bigrobotarm;

namespace {

/// The firmware cuts what it echoes; a marked value differs by more.
constexpr std::int32_t kEchoTolerance = 1;
/// Limits in a file are rounded; so much above one is still it.
constexpr double kLimitRounding = 1.001;
/// A motion of this process takes so many times what its joints can: it may have been a slow one.
constexpr double kLeftBehind = 4;

std::int32_t multiplier_of(double per_second, const BigRobotArmJoint& joint, std::int32_t most) {
  const double steps = per_second * std::abs(joint.steps_per_rad);
  const double multiplier = steps / (joint.steps_per_motor_rev / 100) * kLimitRounding;
  return static_cast<std::int32_t>(std::clamp(multiplier, 1.0, 1.0 * most));
}

/// The first joint in which they differ by more than the tolerance.
std::optional<std::size_t> difference(const Words& a, const Words& b, std::int32_t tolerance) {
  for (std::size_t i = 0; i < kJoints; ++i) {
    if (std::abs(std::int64_t{a[i]} - b[i]) > tolerance) return i;
  }
  return std::nullopt;
}

bool same(const BigRobotArmMultipliers& a, const Status& status) {
  return !difference(a.speeds, status.speeds, kEchoTolerance) &&
         !difference(a.accelerations, status.accelerations, kEchoTolerance);
}

}  // namespace

BigRobotArmDriver::BigRobotArmDriver(const BigRobotArmDevice& device, std::span<const Joint> joints,
                                     const BigRobotArmTiming& timing)
    : device_(device),
      timing_(timing),
      channel_(device, timing.wire),
      probe_(timing.wire),
      belief_(device.joints) {
  SINEW_ASSERT(joints.size() == kJoints);
  for (std::size_t i = 0; i < kJoints; ++i) {
    const BigRobotArmJoint& own = device.joints[i];
    SINEW_ASSERT(own.steps_per_motor_rev > 0);
    limits_[i] = {joints[i], multiplier_of(joints[i].velocity_max, own, device.multiplier_max),
                  multiplier_of(joints[i].acceleration_max, own, device.multiplier_max)};
  }
}

DriverHealth BigRobotArmDriver::health() const {
  DriverHealth health = health_;
  health.unexpected += channel_.unexpected() + probe_.unexpected();
  return health;
}

DeviceFacts BigRobotArmDriver::facts() const {
  return DeviceFacts(BigRobotArmFacts{
      .wire = device_.wire,
      .dialect = device_.dialect,
      .status = heard_,
      .looks_like_boot = heard_ && channel_.start_in(heard_->what) == BigRobotArmStart::kAnew,
      .wants_declaration = wants_declaration()});
}

// Opening, closing, and what happens in between.

void BigRobotArmDriver::open(Instant now) {
  if (state_ != DriverState::kClosed) close(now);
  state_ = DriverState::kOpening;
  opening_ = true;
  belief_.reopen();
  const Duration left = left_behind();
  if (left > Duration::zero()) deaf_until_ = now + left;
  limit_ = now + timing_.opening_limit + left;
  const double allowed = to_seconds(timing_.opening_limit + left);
  trouble_ = {ErrorCode::kDeviceSilent, -1, allowed, allowed};
  if (device_.probe_wire) {
    step_ = Step::kProbe;
    probe_.open(now);
  } else {
    step_ = Step::kRecover;
    channel_.open(now);
  }
}

void BigRobotArmDriver::close(Instant now) {
  if (state_ == DriverState::kClosed) return;
  channel_.close();
  while (channel_.take_event()) {
  }
  // A stop has no better end than a port from which nothing can leave any more.
  if (stop_wanted_ && !command_) tell(DriverEvent::Kind::kStopped);
  if (command_ || opening_) tell(DriverEvent::Kind::kFailed, {ErrorCode::kPortClosed});
  command_ = opening_ = stop_wanted_ = false;
  state_ = DriverState::kClosed;
  step_ = Step::kNone;
  fault_.reset();
  limit_.reset();
  deaf_until_.reset();
  show(now);
}

/// How long a motion may still take in which the process before has died: it may have been as slow
/// as this wire can ask for.
Duration BigRobotArmDriver::left_behind() const {
  const bool died = memory_.ended_in_motion;
  double longest = 0;
  for (std::size_t i = 0; i < kJoints; ++i) {
    const JointPosition& joint = shown_[i];
    if (joint.quality != PositionQuality::kUncertain) continue;
    const BigRobotArmJoint& own = device_.joints[i];
    const double steps = (joint.upper - joint.lower) * std::abs(own.steps_per_rad);
    longest = std::max(longest, motion_time(own, steps, died ? 1 : limits_[i].speed_max,
                                            died ? 1 : limits_[i].acceleration_max));
  }
  if (died) return std::max(from_seconds(longest) - memory_.since, Duration::zero());
  return from_seconds(kLeftBehind * longest);
}

std::optional<Instant> BigRobotArmDriver::goes_on_until() const {
  if (state_ == DriverState::kOpening && deaf_until_) return deaf_until_;
  const bool ending = state_ == DriverState::kStopping || state_ == DriverState::kOpening;
  if (!ending || !belief_.going()) return std::nullopt;
  const Duration own = from_seconds(to_seconds(expected_) * timing_.wire.move_factor);
  return going_since_ + own + timing_.wire.move_margin;
}

std::optional<JointInterval> BigRobotArmDriver::counted(std::size_t joint) const {
  return belief_.counted(joint);
}

void BigRobotArmDriver::poll(Instant now) {
  if (state_ == DriverState::kClosed) return;
  if (step_ == Step::kProbe) {
    probe_.poll(now);
  } else {
    channel_.poll(now);
  }
  pump(now);
  if (limit_ && now >= *limit_) {
    limit_.reset();
    const bool failed = opening_ || stop_wanted_;
    if (step_ == Step::kProbe && probe_.unexpected() > 0) {
      trouble_ = {ErrorCode::kUnaskedReply, -1, 1.0 * probe_.last_byte()};
    }
    tell(failed ? DriverEvent::Kind::kFailed : DriverEvent::Kind::kNotice, trouble_);
    opening_ = stop_wanted_ = false;
  }
  show(now);
}

void BigRobotArmDriver::receive(std::span<const std::uint8_t> bytes, Instant now) {
  if (state_ == DriverState::kClosed) return;
  if (step_ == Step::kProbe) {
    probe_.receive(bytes, now);
    if (const auto found = probe_.found()) {
      device_.wire = found->wire;
      device_.dialect = found->dialect;
      health_.unexpected += channel_.unexpected();
      channel_ = BigRobotArmChannel(device_, timing_.wire);
      channel_.set_offset(belief_.offset());
      channel_.open(now);
      step_ = Step::kRecover;
    }
  } else {
    channel_.receive(bytes, now);
  }
  pump(now);
  show(now);
}

std::size_t BigRobotArmDriver::take_output(std::span<std::uint8_t> out) {
  return step_ == Step::kProbe ? probe_.take_output(out) : channel_.take_output(out);
}

std::optional<Instant> BigRobotArmDriver::next_deadline() const {
  auto next = step_ == Step::kProbe ? probe_.next_deadline() : channel_.next_deadline();
  if (limit_ && (!next || *limit_ < *next)) next = limit_;
  return next;
}

void BigRobotArmDriver::pump(Instant now) {
  while (const auto event = channel_.take_event()) {
    if (const auto* read = std::get_if<BigRobotArmChannel::StatusRead>(&*event)) {
      take(*read, now);
    } else if (std::holds_alternative<BigRobotArmChannel::Done>(*event)) {
      take_done(now);
    } else if (const auto* failed = std::get_if<BigRobotArmChannel::Failed>(&*event)) {
      doubt(failed->error, now);
    }
  }
}

void BigRobotArmDriver::take(const BigRobotArmChannel::StatusRead& read, Instant now) {
  heard_ = {read.status, now};
  was_deaf_ = was_deaf_ || read.was_deaf;
  if (read.after_doubt) {
    return confirm(read.status, Step::kRecover, now);
  }
  if (step_ == Step::kConfirm) {
    alike_ = last_read_ == read.status ? alike_ + 1 : 1;
    last_read_ = read.status;
    if (alike_ >= (is_familiar(read.status) ? 2 : 3)) return settle(read.status, now);
    if (++readings_ < kReadingsMax) return go_on(Step::kConfirm, now);
    // A line like that is no line; start again from quiet.
    trouble_ = {ErrorCode::kChecksum, -1, 1.0 * readings_};
    ++health_.unexpected;
    channel_.open(now);
    return doubt(trouble_, now);
  }
  if (as_expected(read.status)) return go_on_after(step_, now);
  confirm(read.status, step_, now);
}

void BigRobotArmDriver::confirm(const std::optional<Status>& first, Step resume, Instant now) {
  readings_ = alike_ = first ? 1 : 0;
  last_read_ = first;
  resume_ = resume;
  go_on(Step::kConfirm, now);
}

/// Where we left it, or sent it: one flipped bit twice does not look like that.
bool BigRobotArmDriver::is_familiar(const Status& status) const {
  return status.positions == belief_.steps() || (belief_.going() && status.positions == target_);
}

bool BigRobotArmDriver::as_expected(const Status& status) const {
  const bool after = step_ == Step::kAfter;
  return !status.sync && status.positions == (after ? target_ : belief_.steps()) &&
         same(after ? wanted_ : multipliers_, status);
}

/// A damaged goto that was sent beyond a joint's limits may have ended at its mechanical end.
bool BigRobotArmDriver::is_outside(const Words& steps) const {
  for (std::size_t i = 0; i < kJoints; ++i) {
    const double q = belief_.offset()[i] + steps[i] / device_.joints[i].steps_per_rad;
    const SendRange& range = limits_[i].range;
    if (q < range.lower || q > range.upper) return true;
  }
  return false;
}

/// Longer deaf than our own motion explains: noise has ordered one, and perhaps a reset as well,
/// so that its counters tell nothing.
bool BigRobotArmDriver::may_have_wandered(Instant now) const {
  if (!was_deaf_) return false;
  const Duration own = from_seconds(to_seconds(expected_) * timing_.wire.move_factor);
  return !belief_.going() || now > going_since_ + own + timing_.wire.move_margin;
}

void BigRobotArmDriver::settle(const Status& status, Instant now) {
  const Step answered = resume_;
  step_ = answered;
  last_read_.reset();
  const bool wandered = may_have_wandered(now);
  was_deaf_ = false;
  if (answered != Step::kRecover && as_expected(status)) return go_on_after(answered, now);
  const auto joint = difference(status.positions, belief_.going() ? target_ : belief_.steps(), 0);
  const bool strayed = !is_familiar(status);
  belief_.judge(status, channel_.start_in(status));
  if (wandered || (strayed && is_outside(status.positions))) belief_.lose();
  channel_.set_offset(belief_.offset());
  multipliers_ = {status.speeds, status.accelerations};
  deaf_until_.reset();
  memory_ = {};
  if (const auto counted = belief_.take_contradiction()) tell(DriverEvent::Kind::kNotice, *counted);
  if (command_) {
    Error error{ErrorCode::kReplyMismatch};
    if (joint) error.index = static_cast<std::int8_t>(*joint);
    end_command(DriverEvent::Kind::kFailed, error);
  }
  step_ = Step::kNone;
  limit_.reset();
  state_ = DriverState::kReady;
  if (status.sync) {
    state_ = DriverState::kFault;
    fault_ = Error{ErrorCode::kDeviceSync};
  }
  if (status.sync && opening_) {
    tell(DriverEvent::Kind::kFailed, *fault_);
  } else {
    tell(DriverEvent::Kind::kReady);
  }
  opening_ = false;
  if (stop_wanted_) tell(DriverEvent::Kind::kStopped);
  stop_wanted_ = false;
}

void BigRobotArmDriver::take_done(Instant now) {
  if (step_ == Step::kSpeeds) multipliers_.speeds = wanted_.speeds;
  if (step_ == Step::kRamps) multipliers_.accelerations = wanted_.accelerations;
  if (step_ == Step::kSyncOff) {
    return confirm(std::nullopt, Step::kRecover, now);
  }
  go_on_after(step_, now);
}

void BigRobotArmDriver::doubt(const Error& error, Instant now) {
  health_.timeouts += error.code == ErrorCode::kDeviceSilent ? 1 : 0;
  if (command_) {
    end_command(DriverEvent::Kind::kFailed, error);
  } else if (state_ == DriverState::kReady || state_ == DriverState::kFault) {
    tell(DriverEvent::Kind::kNotice, error);
  } else if (error.code != ErrorCode::kDeviceSilent) {
    trouble_ = error;
  }
  if (state_ != DriverState::kOpening) {
    trouble_ = error;
    limit_ = now + timing_.opening_limit;
  }
  belief_.doubt();
  state_ = DriverState::kOpening;
  fault_.reset();
  step_ = Step::kRecover;
}

// The dialogue.

void BigRobotArmDriver::go_on_after(Step done, Instant now) {
  switch (done) {
    case Step::kBefore:
      if (multipliers_.speeds != wanted_.speeds) return go_on(Step::kSpeeds, now);
      [[fallthrough]];
    case Step::kSpeeds:
      if (multipliers_.accelerations != wanted_.accelerations) return go_on(Step::kRamps, now);
      [[fallthrough]];
    case Step::kRamps:
      return go_on(Step::kGoto, now);
    case Step::kGoto:
      return go_on(Step::kAfter, now);
    case Step::kAfter:
      belief_.arrive();
      break;
    case Step::kZero:
      belief_.zero();
      break;
    default:
      break;
  }
  step_ = Step::kNone;
  state_ = DriverState::kReady;
  const bool stopped = stop_wanted_;
  stop_wanted_ = false;
  end_command(stopped ? DriverEvent::Kind::kStopped : DriverEvent::Kind::kDone, {});
}

void BigRobotArmDriver::go_on(Step step, Instant now) {
  const bool harmless = step == Step::kConfirm || step == Step::kAfter;
  if (stop_wanted_ && command_ && !harmless) return go_on_after(Step::kNone, now);
  if (const auto asked = ask(step, now); !asked) {
    // Every value was looked at before the first byte left.
    SINEW_ASSERT(asked.error().code == ErrorCode::kBusy);
    doubt(asked.error(), now);
  }
}

Expected<void> BigRobotArmDriver::ask(Step step, Instant now) {
  Expected<void> asked;
  switch (step) {
    case Step::kSpeeds:
      asked = channel_.set_speeds(wanted_.speeds, now);
      break;
    case Step::kRamps:
      asked = channel_.set_accelerations(wanted_.accelerations, now);
      break;
    case Step::kGoto:
      asked = channel_.move_to(q_target_, expected_, now);
      if (asked) belief_.go(target_);
      going_since_ = now;
      break;
    case Step::kGripper:
      asked = channel_.set_gripper(gripper_enabled_, gripper_.value_or(0), now);
      break;
    case Step::kZero:
      asked = channel_.reset_positions(now);
      break;
    case Step::kSyncOff:
      asked = channel_.leave_sync(now);
      break;
    default:
      asked = channel_.read_status(now);
      break;
  }
  if (!asked) return asked;
  step_ = step;
  ++health_.requests;
  health_.retries += step == Step::kConfirm ? 1 : 0;
  return {};
}

Expected<void> BigRobotArmDriver::check_ready() const {
  if (state_ == DriverState::kReady) return {};
  if (state_ == DriverState::kFault) return std::unexpected(*fault_);
  const bool closed = state_ == DriverState::kClosed;
  return std::unexpected(Error{closed ? ErrorCode::kPortClosed : ErrorCode::kBusy});
}

Expected<void> BigRobotArmDriver::check_move(const JointMove& move) const {
  SINEW_ASSERT(move.q.size() == kJoints);
  if (const auto unknown = belief_.unknown()) {
    return std::unexpected(Error{ErrorCode::kPositionUnknown, static_cast<std::int8_t>(*unknown)});
  }
  for (std::size_t i = 0; i < kJoints; ++i) {
    const auto joint = static_cast<std::int8_t>(i);
    const SendRange& limit = limits_[i].range;
    if (!limit.from(shown_[i]).holds(move.q[i])) {
      const bool low = move.q[i] < limit.lower;
      return std::unexpected(
          Error{ErrorCode::kJointLimit, joint, move.q[i], low ? limit.lower : limit.upper});
    }
    if (i < move.qd.size() && !(move.qd[i] == 0)) {
      return std::unexpected(Error{ErrorCode::kTaskNotSupported, joint});
    }
  }
  return {};
}

Expected<void> BigRobotArmDriver::move(const JointMove& move, Instant now) {
  if (const auto ready = check_ready(); !ready) return ready;
  if (const auto fine = check_move(move); !fine) return fine;
  std::copy(move.q.begin(), move.q.end(), q_target_.begin());
  return begin_move(move.duration, now);
}

Expected<void> BigRobotArmDriver::nudge(std::size_t joint, double way, Duration duration,
                                        Instant now) {
  SINEW_ASSERT(joint < kJoints);
  if (const auto ready = check_ready(); !ready) return ready;
  const double steps = way * device_.joints[joint].steps_per_rad;
  // Written so that NaN is refused too.
  if (!(std::abs(steps) >= 0.5 && std::abs(way) <= BigRobotArmDevice::kNudgeMax)) {
    return std::unexpected(Error{ErrorCode::kNudgeRange, static_cast<std::int8_t>(joint), way,
                                 BigRobotArmDevice::kNudgeMax});
  }
  for (std::size_t i = 0; i < kJoints; ++i) {
    q_target_[i] = belief_.offset()[i] + belief_.steps()[i] / device_.joints[i].steps_per_rad;
  }
  q_target_[joint] += std::round(steps) / device_.joints[joint].steps_per_rad;
  return begin_move(duration, now);
}

/// To q_target_.
Expected<void> BigRobotArmDriver::begin_move(Duration at_least, Instant now) {
  const auto target = channel_.steps_of(q_target_);
  if (!target) return std::unexpected(target.error());
  Words deltas = *target;
  for (std::size_t i = 0; i < kJoints; ++i) deltas[i] -= belief_.steps()[i];
  const auto chosen = multipliers_for(deltas, at_least);
  if (!chosen) return std::unexpected(chosen.error());
  const auto asked = ask(Step::kBefore, now);
  if (!asked) return asked;
  wanted_ = *chosen;
  target_ = *target;
  expected_ = duration_of(deltas);
  state_ = DriverState::kMoving;
  command_ = true;
  return {};
}

/// Never those of power-up, so that a board that was reset shows it.
Expected<BigRobotArmMultipliers> BigRobotArmDriver::multipliers_for(const Words& deltas,
                                                                    Duration at_least) const {
  BigRobotArmMultipliers base;
  Words boot{};
  for (std::size_t i = 0; i < kJoints; ++i) {
    base.speeds[i] = limits_[i].speed_max;
    base.accelerations[i] = limits_[i].acceleration_max;
    boot[i] = device_.joints[i].multiplier_boot;
  }
  base = raised(device_, deltas, base, to_seconds(at_least));
  auto chosen = synchronised_multipliers(device_, deltas, base, to_seconds(at_least));
  if (!chosen) return chosen;
  if (!difference(chosen->speeds, boot, kEchoTolerance) &&
      !difference(chosen->accelerations, boot, kEchoTolerance)) {
    std::int32_t& marked = chosen->accelerations[0];
    marked = std::max(1, marked - 1 - 2 * kEchoTolerance);
    while (marked > 1 && !byte::sendable(marked)) --marked;
  }
  return chosen;
}

Duration BigRobotArmDriver::duration_of(const Words& deltas) const {
  double longest = 0;
  for (std::size_t i = 0; i < kJoints; ++i) {
    longest = std::max(longest, motion_time(device_.joints[i], deltas[i], wanted_.speeds[i],
                                            wanted_.accelerations[i]));
  }
  return from_seconds(longest);
}

/// Where its servo was told to be last, by this host or, as the byte wire says, by another one.
std::optional<std::int32_t> BigRobotArmDriver::known_gripper() const {
  if (gripper_) return gripper_;
  if (heard_ && heard_->what.gripper) return heard_->what.gripper->position;
  return std::nullopt;
}

Expected<void> BigRobotArmDriver::tool(const ToolAction& action, Instant now) {
  const auto* gripper = std::get_if<GripperTo>(&action);
  if (gripper == nullptr) return std::unexpected(Error{ErrorCode::kToolNotFitted});
  if (const auto ready = check_ready(); !ready) return ready;
  const auto known = known_gripper();
  if (gripper->enabled && !gripper->angle && !known) {
    return std::unexpected(Error{ErrorCode::kNotMeasured});
  }
  const double degrees = gripper->angle ? std::round(to_deg(*gripper->angle)) : known.value_or(0);
  if (!(degrees >= 0 && degrees <= device_.gripper_max)) {
    return std::unexpected(Error{ErrorCode::kGripperRange, -1, degrees, 1.0 * device_.gripper_max});
  }
  if (gripper->angle || known) gripper_ = static_cast<std::int32_t>(degrees);
  gripper_enabled_ = gripper->enabled;
  const auto asked = ask(Step::kGripper, now);
  if (!asked) return asked;
  state_ = DriverState::kMoving;
  command_ = true;
  return {};
}

void BigRobotArmDriver::stop(Instant now) {
  if (state_ == DriverState::kOpening) {
    stop_wanted_ = true;
    if (!limit_) limit_ = now + timing_.opening_limit;
  } else if (state_ != DriverState::kMoving && state_ != DriverState::kStopping) {
    tell(DriverEvent::Kind::kStopped);
  } else {
    stop_wanted_ = true;
    state_ = DriverState::kStopping;
    if (channel_.withdraw()) {
      belief_.stay();
      go_on_after(Step::kNone, now);
    }
  }
  show(now);
}

Expected<void> BigRobotArmDriver::clear_fault(Instant now) {
  if (state_ == DriverState::kMoving || state_ == DriverState::kStopping) {
    return std::unexpected(Error{ErrorCode::kBusy});
  }
  if (state_ != DriverState::kFault) return {};
  if (const auto asked = ask(Step::kSyncOff, now); !asked) return asked;
  fault_.reset();
  state_ = DriverState::kOpening;
  limit_ = now + timing_.opening_limit;
  return {};
}

void BigRobotArmDriver::declare_positions(std::span<const JointPosition> positions) {
  const bool moving = state_ == DriverState::kMoving || state_ == DriverState::kStopping;
  if (moving) return;
  belief_.declare(positions);
  channel_.set_offset(belief_.offset());
  belief_.show(0, shown_);
}

Expected<void> BigRobotArmDriver::zero_counters(Instant now) {
  if (const auto ready = check_ready(); !ready) return ready;
  const auto asked = ask(Step::kZero, now);
  if (!asked) return asked;
  state_ = DriverState::kMoving;
  command_ = true;
  return {};
}

void BigRobotArmDriver::show(Instant now) {
  const double whole = to_seconds(expected_);
  if (!(whole > 0)) return belief_.show(1, shown_);
  // The joints arrive together: all as far as the one that takes longest by its own ramps.
  double longest = 0;
  std::size_t slowest = 0;
  Words way{};
  for (std::size_t i = 0; i < kJoints; ++i) {
    way[i] = target_[i] - belief_.steps()[i];
    const double time =
        motion_time(device_.joints[i], way[i], wanted_.speeds[i], wanted_.accelerations[i]);
    if (time > longest) slowest = i;
    longest = std::max(longest, time);
  }
  // The board may take longer than its ramps: so much slower goes all of it.
  const double t = to_seconds(now - going_since_) * longest / whole;
  belief_.show(longest > 0
                   ? motion_share(device_.joints[slowest], way[slowest], wanted_.speeds[slowest],
                                  wanted_.accelerations[slowest], t)
                   : 1,
               shown_);
}

void BigRobotArmDriver::end_command(DriverEvent::Kind kind, const Error& error) {
  if (command_) tell(kind, error);
  command_ = false;
}

void BigRobotArmDriver::tell(DriverEvent::Kind kind, const Error& error) {
  // Who stops again and again without listening has been told already.
  if (kind == DriverEvent::Kind::kStopped && !events_.empty() && events_.back().kind == kind) {
    return;
  }
  if (events_.full() && kind == DriverEvent::Kind::kNotice) return;
  SINEW_ASSERT(!events_.full());
  events_.push_back({kind, error});
}

std::optional<DriverEvent> BigRobotArmDriver::take_event() {
  return events_.take_front();
}

}  // namespace sinew
