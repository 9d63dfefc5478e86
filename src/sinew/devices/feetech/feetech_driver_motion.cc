#include <algorithm>
#include <cmath>

#include "sinew/core/error_code.h"
#include "sinew/devices/feetech/feetech_driver.h"
#include "sinew/driver/send_range.h"

namespace sinew {

using namespace feetech;
using Kind = DriverEvent::Kind;

namespace {

/// Of the speed that a servo is given: more than its goal needs, so that it is there in time.
constexpr double kSpeedShare = 1.2;
constexpr double kSpeedLeast = 0.3;  // rad/s
/// A goal that is beside the setpoint as a motion begins, by the servo's load, comes to it in this
/// time.
constexpr double kFade = 0.3;  // s
/// rad beside its target at rest, behind corrections: no load, but something in the way. Behind a
/// stop, which corrects nothing, more is a load's.
constexpr double kBlocked = 0.035;
constexpr double kBlockedAtStop = 0.08;
/// A correction that leaves so much of what was missing has not helped.
constexpr double kHelped = 0.7;
/// A host that is later than this, and than a tick, makes the motion longer.
constexpr Duration kLate = std::chrono::milliseconds(20);
/// A joint that is farther off at rest has its goal moved, so often, so far (units, rad).
constexpr double kNearEnough = 4;
constexpr int kCorrections = 2;
/// Units within which jaws are where they were sent, and beside which something is between them.
constexpr double kJawsThere = 12;
constexpr double kJawsBlocked = 40;
/// Thousandths: one less than a servo has behind a loss of power, which shows by it.
constexpr double kTorqueMost = 999;
constexpr std::uint16_t kSpeedMost = 0x7FFF;

}  // namespace

/// Something moves, or may: goals are told and servos asked all the time.
bool FeetechDriver::ticks() const {
  return activity_ != Activity::kClosed && activity_ != Activity::kOpening &&
         activity_ != Activity::kIdle;
}

Duration FeetechDriver::tick() const {
  const Duration wire = bus_.ask_time(servos_.size(), FeetechServos::kStateCount) +
                        bus_.write_time(servos_.size(), 7);
  return std::max(timing_.tick, wire + wire / 4);
}

/// Where a joint shall be.
segments::Setpoint FeetechDriver::setpoint(std::size_t joint, Instant when) const {
  if (activity_ == Activity::kMoving) {
    return queue_.empty() ? target_[joint] : queue_.at(joint, when - lag_);
  }
  const segments::Setpoint& from = target_[joint];
  const Joint& limits = servos_.joint(joint);
  const double brake = std::copysign(limits.acceleration_max, from.qd);
  const double t = std::clamp(to_seconds(when - brake_at_), 0.0, std::abs(from.qd / brake));
  const SendRange range = SendRange(limits).from(from.q);
  const double q = from.q + t * (from.qd - t * brake / 2);
  return {std::clamp(q, range.lower, range.upper), from.qd - t * brake};
}

/// @param speed  units/s
void FeetechDriver::add_goal(SyncWrite& write, std::size_t i, double units, double speed) {
  const std::endian order = servos_.device().byte_order();
  const bool sts = servos_.device().sts();
  const double most = servos_.device().units_max();
  goal_[i] = std::clamp(std::round(units), 0.0, most);
  told_ |= servo_bit(i);
  const double unit = servos_[i].speed_unit;
  const double least = kSpeedLeast * servos_.device().units_per_rad();
  const double words = std::ceil(std::max(speed, least) / unit);
  SyncWrite::Part part{servos_.id(i), {}};
  if (sts) part.data.push_back(0);  // no limit of acceleration
  put_word(part.data, static_cast<std::uint16_t>(goal_[i]), order);
  put_word(part.data, 0, order);
  put_word(part.data, static_cast<std::uint16_t>(std::min<double>(words, kSpeedMost)), order);
  write.parts.push_back(part);
}

/// Where everything that moves shall be a tick from now.
void FeetechDriver::say_goals(Instant now) {
  const Instant when = now + tick();
  // From the last goals on, so that a late host makes nothing faster.
  const double seconds = to_seconds(std::max(tick(), when - told_for_));
  const bool sts = servos_.device().sts();
  SyncWrite write{sts ? Register::kAcceleration : Register::kGoal, {}};
  const auto add = [&](std::size_t i, double units) {
    add_goal(write, i, units, kSpeedShare * std::abs(units - goal_[i]) / seconds);
  };
  const bool joints =
      activity_ == Activity::kMoving || (activity_ == Activity::kStopping && brakes_);
  for (std::size_t i = 0; joints && i < servos_.joints(); ++i) {
    const double fade = std::max(0.0, 1 - to_seconds(when - began_) / kFade);
    const double q = setpoint(i, when).q;
    add(i, servos_.units_of(i, q) + beside_[i] + std::min(1.0, fade) * jump_[i]);
  }
  if (jaws_) {
    const double whole = to_seconds(jaws_->end - jaws_->start);
    const double part =
        whole > 0 ? std::clamp(to_seconds(when - jaws_->start) / whole, 0.0, 1.0) : 1;
    add(servos_.jaws(), jaws_->from + part * (jaws_->to - jaws_->from));
    jaws_->said = jaws_->held;
  }
  if (write.parts.empty()) return;
  bus_.write(write, now);
  told_for_ = when;
}

/// Motors on, each with its goal where it is held or stands; or off.
void FeetechDriver::say_switch(Instant now) {
  const std::endian order = servos_.device().byte_order();
  const bool sts = servos_.device().sts();
  SyncWrite limits{Register::kTorqueLimit, {}};
  SyncWrite goals{sts ? Register::kAcceleration : Register::kGoal, {}};
  SyncWrite off{Register::kTorque, {}};
  SyncWrite on{Register::kTorque, {}};
  for (std::size_t i = 0; i < servos_.size(); ++i) {
    if ((switch_->servos & servo_bit(i)) == 0) continue;
    const std::uint8_t id = servos_.id(i);
    SyncWrite::Part limit{id, {}};
    const double thousandths = std::min(kTorqueMost, std::round(1000 * servos_.torque_limit(i)));
    put_word(limit.data, static_cast<std::uint16_t>(thousandths), order);
    limits.parts.push_back(limit);
    off.parts.push_back({id, {0}});
    on.parts.push_back({id, {1}});
    if (switch_->on) add_goal(goals, i, base_of(i), 0);
  }
  switch_->said = true;
  on_ = static_cast<std::uint8_t>(on_ & ~switch_->servos);
  if (!switch_->on || switch_->anew) bus_.write(off, now);
  if (!switch_->on) return;
  if (sts) bus_.write(limits, now);
  bus_.write(goals, now);
  bus_.write(on, now);
}

/// The first servo that has not heard the switch, by its last reply.
std::optional<std::size_t> FeetechDriver::not_switched() const {
  for (std::size_t i = 0; i < servos_.size(); ++i) {
    if ((switch_->servos & servo_bit(i)) == 0) continue;
    const FeetechServoState& servo = servos_[i];
    const bool heard = servo.torque == switch_->on && (!switch_->on || servo.goal == goal_[i]);
    if (!heard) return i;
  }
  return std::nullopt;
}

/// Behind a whole round of replies: whether the servos have heard it.
void FeetechDriver::step_switch(Instant now) {
  if (const auto unheard = not_switched()) {
    switch_->said = false;
    if (++switch_->tries < timing_.tries) return;
    switch_.reset();
    return fail({ErrorCode::kDeviceRefused, static_cast<std::int8_t>(*unheard)}, now);
  }
  const std::uint8_t servos = switch_->servos;
  if (switch_->on) {
    on_ |= servos;
    set_up_ |= servos;
    for (std::size_t i = 0; i < servos_.size(); ++i) limits_[i] = servos_[i].torque_limit;
  }
  switch_.reset();
  over_at_ = now;
}

/// What falls as its motor comes on swings for a while.
void FeetechDriver::step_switching(Instant now) {
  if (switch_ || (servos_.held() && !settled(now))) return;
  activity_ = Activity::kIdle;
  poll_due_ = now;
  commands_.end_all(Kind::kDone);
}

// What time brings

/// Behind a host that came too late a motion resumes from the last goal, and is not made up for.
void FeetechDriver::wait_for_host(Instant now) {
  if (activity_ != Activity::kMoving || switch_ || queue_.empty()) return;
  const Duration late = now - told_for_;
  if (late <= std::max(tick(), kLate)) return;
  lag_ += late;
  told_for_ = now;
}

void FeetechDriver::step_motion(Instant now) {
  switch (activity_) {
    case Activity::kMoving:
      return queue_.empty() && rests_ ? step_settling(now) : step_moving(now);
    case Activity::kJaws:
      return step_jaws(now);
    case Activity::kSwitching:
      return step_switching(now);
    case Activity::kStopping:
      return step_braking(now);
    default:
      return;
  }
}

void FeetechDriver::step_moving(Instant now) {
  if (switch_ && now >= began_) {
    const std::size_t i = not_switched().value_or(servos_.joints() - 1);
    return fail({ErrorCode::kDeviceRefused, static_cast<std::int8_t>(i)}, now);
  }
  while (!queue_.empty() && now - lag_ >= queue_.front().end) {
    const segments::Segment& over = queue_.front();
    over_at_ = over.end + lag_;
    for (std::size_t i = 0; i < servos_.joints(); ++i) target_[i] = over.pieces[i].end();
    queue_.pop_front();
    // The last one is done when the joints are there.
    if (!queue_.empty() || !rests_) commands_.done();
  }
  if (!queue_.empty() || rests_) return;
  const double waited = to_seconds(now - last_piece_);
  commands_.fail({ErrorCode::kStreamEnded, -1, waited, waited});
  begin_stop(now);
}

/// All joints were seen where they were sent, or do not move any more.
bool FeetechDriver::settled(Instant now) const {
  const bool late = now - over_at_ > timing_.settle_limit;
  for (std::size_t i = 0; i < servos_.joints(); ++i) {
    const FeetechServoState& servo = servos_[i];
    if (servo.missed >= timing_.tries) continue;
    if (servo.at <= over_at_) return false;
    const bool there = std::abs(servo.units - goal_[i]) <= 2;
    if (!there && servo.at - std::max(moved_at_[i], over_at_) < timing_.settle && !late)
      return false;
  }
  return true;
}

/// Units by which a joint is beside where it shall rest.
double FeetechDriver::behind_rest(std::size_t joint) const {
  const Instant rest = std::max(over_at_, told_for_);
  return servos_.units_of(joint, setpoint(joint, rest).q) - servos_[joint].units;
}

/// A servo gives way to its load: at rest its goal is moved by as much, once or twice. Where that
/// does not help something is in its way, and it is taken back. False: nothing was changed.
bool FeetechDriver::correct(Instant now) {
  const double most = kCorrectMost * servos_.device().units_per_rad();
  bool any = false;
  for (std::size_t i = 0; i < servos_.joints(); ++i) {
    const double off = behind_rest(i);
    const bool tried = corrections_ > 0 && off_[i] != 0;
    if (tried && std::abs(off) > kHelped * std::abs(off_[i])) {
      any = any || beside_[i] != before_[i];
      beside_[i] = before_[i];
      stuck_ |= servo_bit(i);
    }
    const bool wants = std::abs(off) > kNearEnough && std::abs(off) <= most;
    off_[i] = 0;
    if (!wants || corrections_ >= kCorrections || (stuck_ & servo_bit(i)) != 0) continue;
    before_[i] = beside_[i];
    off_[i] = off;
    beside_[i] = std::clamp(beside_[i] + off, -most, most);
    any = true;
  }
  if (!any) return false;
  ++corrections_;
  over_at_ = now + tick();
  return true;
}

/// Joints that rest farther than this beside where they shall, rad, shall rest where they are:
/// nothing pushes on. False where there are none.
bool FeetechDriver::relieve(double from, Instant now) {
  bool any = false;
  for (std::size_t i = 0; i < servos_.joints(); ++i) {
    const bool pushes = std::abs(behind_rest(i)) > from * servos_.device().units_per_rad();
    if (!pushes || !servos_[i].known || !servos_[i].torque) continue;
    target_[i] = {servos_.q(i), 0};
    beside_[i] = 0;
    any = true;
  }
  if (any) over_at_ = now + tick();
  return any;
}

void FeetechDriver::step_settling(Instant now) {
  if (!settled(now) || (!missed_ && correct(now))) return;
  for (std::size_t i = 0; i < servos_.joints() && !missed_; ++i) {
    const double off = std::abs(behind_rest(i)) / servos_.device().units_per_rad();
    if (off <= kBlocked) continue;
    missed_ =
        Error{ErrorCode::kMissedTarget, static_cast<std::int8_t>(i), servos_.q(i), target_[i].q};
    if (relieve(kBlocked, now)) return;
  }
  activity_ = Activity::kIdle;
  poll_due_ = now;
  if (missed_) return commands_.end_all(Kind::kFailed, *missed_);
  commands_.end_all(Kind::kDone);
}

void FeetechDriver::step_jaws(Instant now) {
  if (switch_ || !jaws_) return;
  const std::size_t i = servos_.jaws();
  const FeetechServoState& servo = servos_[i];
  const bool late = now - jaws_->end > timing_.jaws_limit;
  const bool there = std::abs(servo.units - jaws_->to) <= kJawsThere && servo.at > jaws_->start;
  if (!there && !jaws_->held) {
    const bool stands =
        servo.at - std::max(moved_at_[i], jaws_->start) >= FeetechDevice::kJawsStand;
    const bool pushes = std::abs(goal_[i] - servo.units) > kJawsBlocked || now >= jaws_->end;
    if (!late && (!stands || !pushes)) return;
    // Something is between them: no more force than holds it.
    const double on = std::copysign(kSqueeze, jaws_->to - servo.units);
    const double beyond = std::abs(jaws_->to - servo.units);
    const double to = servo.units + std::clamp(on, -beyond, beyond);
    jaws_ = Jaws{.from = to, .to = to, .start = now, .end = now, .held = true};
    return;
  }
  if (jaws_->held && !jaws_->said) return;
  health_.jaws_width = servos_.width_of(servo.units);
  jaws_.reset();
  activity_ = Activity::kIdle;
  poll_due_ = now;
  commands_.end_all(Kind::kDone);
}

void FeetechDriver::step_braking(Instant now) {
  if (brakes_ && (told_for_ < over_at_ || !settled(now))) return;
  if (brakes_ && !relieved_ && relieve(kBlockedAtStop, now)) {
    relieved_ = true;
    return;
  }
  if (jaws_ && told_for_ <= over_at_) return;
  jaws_.reset();
  brakes_ = false;
  activity_ = Activity::kIdle;
  poll_due_ = now;
  commands_.end_stop();
}

}  // namespace sinew
