#include "sinew/devices/axis/axis_device_controller.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "sinew/core/assert.h"

namespace sinew {
namespace {

using motion::AxisState;
using motion::OnlineProfile;
using motion::ProfileBounds;

constexpr double kSettleTime = 0.05;      // s: some periods of a rotor that snapped to its place
constexpr double kElectricalTurn = 4;     // full steps
constexpr double kStateTolerance = 1e-8;  // of a limit
constexpr double kMovingSpeed = 1e-3;     // rad/s, measured; a count a tick shows as less
/// Measured beyond a limit by this much, and going on: the joint does not do what it is told.
constexpr double kLimitSlack = from_deg(0.5);
/// What encoder and wire leave between where an axis is and where its host says that it is.
constexpr double kHostSlack = from_deg(0.2);
/// With the switch closed no way into it may be longer: a stop from homing's slow speed is shorter.
constexpr double kIntoSwitch = from_deg(0.5);
/// An end stop that closes within this of its place says nothing about the position.
constexpr double kEndStopTolerance = from_deg(1);

/// Nothing is known of the position after these.
bool loses_position(AxisFault fault) {
  return fault == AxisFault::kEncodersDisagree || fault == AxisFault::kJointEncoder ||
         fault == AxisFault::kMotorEncoder || fault == AxisFault::kHomingTimeout ||
         fault == AxisFault::kEndStopStuck;
}

/// More steps would do harm, or nothing at all.
bool freezes(AxisFault fault) {
  return fault == AxisFault::kStalled || fault == AxisFault::kEndStop;
}

}  // namespace

AxisController::AxisController(const AxisSettings& settings)
    : settings_(settings),
      steps_per_rad_(settings.steps_per_rad()),
      encoders_(settings.encoders),
      end_stop_(to_seconds(settings.homing.debounce)),
      homing_(settings.homing, settings.limits),
      step_check_(2 * kPi / settings.full_steps_per_turn),
      cascade_(settings.cascade),
      follower_({settings.limits.velocity, settings.limits.acceleration, settings.tracking_jerk},
                {settings.lower, settings.upper}) {
  SINEW_ASSERT(settings.lower < settings.upper && steps_per_rad_ > 0);
  SINEW_ASSERT(settings.limits.velocity > 0 && settings.limits.acceleration > 0);
  SINEW_ASSERT(settings.limits.jerk > 0 && settings.tracking_jerk >= settings.limits.jerk);
  SINEW_ASSERT(settings.cascade.rate_max >= settings.limits.velocity);
}

AxisOutputs AxisController::tick(const AxisInputs& inputs, Instant now) {
  SINEW_ASSERT(!last_tick_ || now >= *last_tick_);
  const double since = last_tick_ ? to_seconds(now - *last_tick_) : 0;
  last_tick_ = now;
  inputs_ = inputs;
  encoders_.read(inputs, since);
  const double dt = std::min(since, kTickMax);
  if (inputs.stop_line) emergency_stop();
  // Also where it was released since: what was not made is not made up for.
  if (std::exchange(cut_, false)) steps_ = static_cast<double>(outputs_.steps = inputs.steps);
  end_stop_.read(inputs.end_stop, dt);
  power(dt);
  supervise(dt);
  if (dt > 0 && ready() && !frozen()) {
    move_reference(dt);
    make_steps(dt);
  } else if (dt > 0) {
    reference_ = {encoders_.q(), 0, 0};
  }
  // Without current a pulse turns nothing.
  outputs_.frozen = frozen() || !outputs_.enabled;
  if (outputs_.frozen) steps_ = static_cast<double>(outputs_.steps = inputs.steps);
  return outputs_;
}

// --- power and supervision ---------------------------------------------------------------------

void AxisController::power(double dt) {
  const AxisSupervision& limits = settings_.supervision;
  const bool good = inputs_.supply_volts >= limits.supply_off && !inputs_.driver_fault;
  supply_good_for_ = good ? supply_good_for_ + dt : 0;
  const bool cut = emergency_ && settings_.emergency_stop == EmergencyStopAction::kPowerOff;
  const bool on = supply_good_for_ >= to_seconds(limits.supply_time) && !cut;
  if (on && !outputs_.enabled) settle_left_ = kSettleTime;
  if (!on && ready() && !cut)
    fail(inputs_.driver_fault ? AxisFault::kStalled : AxisFault::kSupplyLow);
  outputs_.enabled = on;
  const bool tests = mode_ == Mode::kSelfTest;
  if (!good && (homing_.running() || tests)) fail(AxisFault::kSupplyLow);
  if (!on || settle_left_ <= 0) return;
  settle_left_ -= dt;
  if (settle_left_ > 0) return;
  // The rotor found a place of its own: that is where field and rotor are in step.
  slip_ = field_angle() - encoders_.motor_angle();
  begin_hold();
  if (homing_.running()) mode_ = Mode::kHoming;
  if (tests) self_test();
}

double AxisController::field_angle() const {
  return static_cast<double>(inputs_.steps) * 2 * kPi /
         (settings_.full_steps_per_turn * settings_.microsteps);
}

/// Slips are whole electrical turns; what is left is the angle by which the load bends the field.
void AxisController::forget_slip() {
  const double electrical = kElectricalTurn * 2 * kPi / settings_.full_steps_per_turn;
  const double apart = field_angle() - encoders_.motor_angle() - slip_;
  slip_ += std::round(apart / electrical) * electrical;
  stalled_for_ = 0;
}

void AxisController::supervise(double dt) {
  const AxisSupervision& limits = settings_.supervision;
  if (encoders_.motor_lost()) fail(AxisFault::kMotorEncoder);
  if (encoders_.joint_lost()) fail(AxisFault::kJointEncoder);
  if (std::abs(encoders_.disagreement()) > limits.disagreement) fail(AxisFault::kEncodersDisagree);
  supervise_end_stop();
  if (!ready()) return;
  supply_low_for_ = inputs_.supply_volts < limits.supply_min ? supply_low_for_ + dt : 0;
  if (supply_low_for_ > to_seconds(limits.supply_time)) fail(AxisFault::kSupplyLow);
  if (!(inputs_.temperature_c <= limits.temperature_max)) fail(AxisFault::kTooHot);
  if (!frozen() && !encoders_.motor_lost()) supervise_motion(dt);
}

void AxisController::supervise_motion(double dt) {
  const AxisSupervision& limits = settings_.supervision;
  const double apart = field_angle() - encoders_.motor_angle() - slip_;
  const bool slipped = encoders_.motor_good() && std::abs(apart) > limits.stall_angle;
  stalled_for_ = slipped ? stalled_for_ + dt : 0;
  if (stalled_for_ > to_seconds(limits.stall_time)) return fail(AxisFault::kStalled);

  // Of what it is told by its reference, and the reference of what a stream tells.
  const double astray = mode_ == Mode::kTracking ? std::abs(follower_.astray(reference_)) : 0;
  const double behind = std::max(std::abs(reference_.q - encoders_.q()), astray);
  following_for_ = behind > limits.following_error ? following_for_ + dt : 0;
  const double q = encoders_.q();
  const double qd = encoders_.qd();
  const bool above =
      q > settings_.upper + kLimitSlack && qd > kMovingSpeed && reference_.q <= settings_.upper;
  const bool below =
      q < settings_.lower - kLimitSlack && qd < -kMovingSpeed && reference_.q >= settings_.lower;
  const bool leaving = homed_ && mode_ != Mode::kHoming && mode_ != Mode::kHold && (above || below);
  if (leaving || following_for_ > to_seconds(limits.following_time)) {
    following_for_ = 0;
    fail(AxisFault::kFollowingError);
  }
}

void AxisController::supervise_end_stop() {
  const bool closed = end_stop_.closed();
  const bool closes = closed && !was_closed_;
  was_closed_ = closed;
  // Without a home the only motions are a search and the way out of one.
  if (!homed_ || mode_ == Mode::kHoming || !closed) return;
  const bool into_it = (target_ - reference_.q) * settings_.homing.direction > kIntoSwitch;
  if (!closes && !into_it) return;
  // It closes where it should not: then the joint is not where the encoders say.
  const double off = std::abs(encoders_.q() - settings_.homing.end_stop_angle);
  fail(AxisFault::kEndStop);
  if (off > kEndStopTolerance) homed_ = false;
}

void AxisController::fail(AxisFault why) {
  if (loses_position(why)) homed_ = false;
  const bool first = fault_ == AxisFault::kNone;
  if (first) fault_ = why;
  if (!first && !(freezes(why) && !fault_frozen_ && mode_ != Mode::kHold)) return;
  homing_.cancel();
  step_check_.cancel();
  if (freezes(why)) return freeze();
  if (mode_ == Mode::kHold || frozen() || !ready()) return begin_hold();
  if (why == AxisFault::kFollowingError) {
    // Where it is and how it moves, not where it should be: the joint must not be driven on.
    const double most = settings_.limits.velocity;
    reference_ = {encoders_.q(), std::clamp(encoders_.qd(), -most, most), 0};
    cascade_.reset();
  }
  begin_profile(way_to_rest());
}

void AxisController::freeze() {
  fault_frozen_ = true;
  begin_hold();
}

void AxisController::begin_hold() {
  mode_ = Mode::kHold;
  streamed_ = false;
  reference_ = {encoders_.q(), 0, 0};
  target_ = reference_.q;
  following_for_ = 0;
  cascade_.reset();
}

// --- motion ------------------------------------------------------------------------------------

/// Does a profile with the joint's own jerk keep its limits from here? track() may have brought the
/// axis to where only a higher jerk stops it in time.
bool AxisController::keeps_limits(const OnlineProfile& profile) const {
  if (!homed_) return true;
  const double released =
      reference_.qd + reference_.qdd * std::abs(reference_.qdd) / (2 * settings_.limits.jerk);
  const motion::PositionRange range = profile.range();
  return std::abs(released) <= settings_.limits.velocity * (1 + kStateTolerance) &&
         range.lower >= std::min(settings_.lower, reference_.q) - kJointLimitTolerance &&
         range.upper <= std::max(settings_.upper, reference_.q) + kJointLimitTolerance;
}

/// A stream brakes and speeds up with the tracking jerk. The joint's own needs longer to take such
/// an acceleration back: an axis that had nearly stopped would turn round and run degrees the other
/// way before it stands.
bool AxisController::swings_back() const {
  if (!streamed_) return false;
  const auto way = OnlineProfile::stop(reference_, ProfileBounds(settings_.limits));
  const motion::PositionRange range = way.range();
  const double back = reference_.qd < 0 ? way.target() - range.lower : range.upper - way.target();
  return back > motion::SetpointFollower::kBeyond;
}

OnlineProfile AxisController::way_to(double q, double speed) const {
  motion::AxisLimits limits = settings_.limits;
  limits.velocity = std::min(limits.velocity, speed);
  const auto way = OnlineProfile::to(reference_, q, ProfileBounds(limits));
  if (keeps_limits(way) && !swings_back()) return way;
  limits.jerk = settings_.tracking_jerk;
  return OnlineProfile::to(reference_, q, ProfileBounds(limits));
}

OnlineProfile AxisController::way_to_rest() const {
  motion::AxisLimits limits = settings_.limits;
  const auto way = OnlineProfile::stop(reference_, ProfileBounds(limits));
  if (keeps_limits(way) && !swings_back()) return way;
  limits.jerk = settings_.tracking_jerk;
  return OnlineProfile::stop(reference_, ProfileBounds(limits));
}

void AxisController::begin_profile(const OnlineProfile& profile) {
  profile_ = profile;
  profile_time_ = 0;
  target_ = profile.target();
  mode_ = homing_.running() ? Mode::kHoming : Mode::kProfile;
}

void AxisController::move_reference(double dt) {
  switch (mode_) {
    case Mode::kHold:
      streamed_ = false;
      break;
    case Mode::kHoming:
      run_homing(dt);
      [[fallthrough]];
    case Mode::kProfile:
      profile_time_ += dt;
      reference_ = profile_.at(profile_time_);
      if (mode_ == Mode::kProfile && profile_time_ >= profile_.duration()) mode_ = Mode::kHold;
      break;
    case Mode::kTracking:
      reference_ = follower_.step(reference_, dt);
      if (follower_.silent() && reference_.qd == 0 && reference_.qdd == 0) mode_ = Mode::kHold;
      break;
    case Mode::kSelfTest: {
      const auto result = step_check_.tick(encoders_.motor_angle(), dt);
      if (!result) break;
      mode_ = Mode::kHold;
      if (!*result) fail(AxisFault::kSelfTest);
      break;
    }
  }
}

void AxisController::run_homing(double dt) {
  const bool arrived = profile_time_ >= profile_.duration();
  const Homing::Wish wish = homing_.tick(end_stop_, reference_.q, arrived, dt);
  using Kind = Homing::Wish::Kind;
  switch (wish.kind) {
    case Kind::kNone:
      break;
    case Kind::kMoveTo:
      begin_profile(way_to(wish.q, wish.speed));
      break;
    case Kind::kStop:
      begin_profile(way_to_rest());
      break;
    case Kind::kMark:
      encoders_.mark();
      break;
    case Kind::kNameMark:
      // The flank on which it came leads by half the play: so zero is in the middle of it, and q
      // is off by half the play at most, whichever flank carries.
      reference_.q +=
          encoders_.name_mark(wish.q, wish.q + settings_.homing.direction * settings_.backlash / 2);
      begin_profile(way_to_rest());
      homed_ = true;
      break;
    case Kind::kDone:
      mode_ = Mode::kProfile;
      break;
    case Kind::kFail:
      fail(wish.fault);
      break;
  }
}

void AxisController::make_steps(double dt) {
  if (frozen()) return;
  double rate = reference_.qd;
  const bool closed_loop = !encoders_.motor_lost() && mode_ != Mode::kSelfTest;
  if (closed_loop) {
    rate = cascade_.rate(reference_.q, reference_.qd, encoders_.q(), encoders_.qd(), dt);
  }
  const double most = settings_.cascade.rate_max;
  steps_ += std::clamp(rate, -most, most) * dt * steps_per_rad_;
  const double test =
      step_check_.turn() / (2 * kPi) * settings_.full_steps_per_turn * settings_.microsteps;
  outputs_.steps = std::llround(steps_ + test);
}

// --- requests ----------------------------------------------------------------------------------

std::optional<AxisVerdict> AxisController::refusal() const {
  if (emergency_) return AxisVerdict::kEmergencyStopped;
  if (fault_ != AxisFault::kNone) return AxisVerdict::kFaulted;
  if (mode_ == Mode::kSelfTest) return AxisVerdict::kBusy;
  return std::nullopt;
}

AxisVerdict AxisController::home() {
  if (const auto no = refusal()) return *no;
  // Right after power-up the current comes within 0.1 s; without a supply it may never, and a
  // search that begins by itself minutes later is a surprise.
  if (!ready() && last_tick_ && inputs_.supply_volts < settings_.supervision.supply_min) {
    return AxisVerdict::kBusy;
  }
  homed_ = false;
  homing_.start();
  profile_ = way_to_rest();
  profile_time_ = 0;
  mode_ = Mode::kHoming;
  return AxisVerdict::kAccepted;
}

void AxisController::cancel_homing() {
  if (mode_ != Mode::kHoming) return;
  homing_.cancel();
  begin_profile(way_to_rest());
}

/// A target inside the limits; from beyond one of them (sagged, pushed by hand while its motor was
/// off) also on the way back, and where the axis is, as nearly as its host knows. Nothing for all
/// others and for a NaN.
std::optional<double> AxisController::allowed(double q) const {
  const double lower = std::min({settings_.lower, reference_.q, encoders_.q()});
  const double upper = std::max({settings_.upper, reference_.q, encoders_.q()});
  const double below = lower < settings_.lower ? kHostSlack : kJointLimitTolerance;
  const double above = upper > settings_.upper ? kHostSlack : kJointLimitTolerance;
  if (!(q >= lower - below && q <= upper + above)) return std::nullopt;
  return lower < settings_.lower || upper > settings_.upper ? std::clamp(q, lower, upper) : q;
}

AxisVerdict AxisController::move_to(double q) {
  if (const auto no = refusal()) return *no;
  if (busy() || !ready()) return AxisVerdict::kBusy;
  if (!homed_) return AxisVerdict::kNotHomed;
  const auto target = allowed(q);
  if (!target) return AxisVerdict::kOutOfLimits;
  begin_profile(way_to(*target, settings_.limits.velocity));
  return AxisVerdict::kAccepted;
}

AxisVerdict AxisController::track(double q, double qd) {
  if (const auto no = refusal()) return *no;
  if (busy() || !ready()) return AxisVerdict::kBusy;
  if (!homed_) return AxisVerdict::kNotHomed;
  const auto target = allowed(q);
  if (!target || !std::isfinite(qd)) return AxisVerdict::kOutOfLimits;
  if (mode_ != Mode::kTracking) follower_.begin(reference_);
  mode_ = Mode::kTracking;
  streamed_ = true;
  target_ = *target;
  follower_.setpoint(*target, qd);
  return AxisVerdict::kAccepted;
}

void AxisController::stop(AxisFault why) {
  if (why != AxisFault::kNone) return fail(why);
  homing_.cancel();
  if (mode_ == Mode::kSelfTest) {
    step_check_.cancel();
    begin_hold();
  }
  if (mode_ != Mode::kHold) begin_profile(way_to_rest());
}

void AxisController::emergency_stop() {
  emergency_ = cut_ = true;
  homing_.cancel();
  step_check_.cancel();
  begin_hold();
}

void AxisController::release_emergency_stop() {
  if (!emergency_) return;
  emergency_ = false;
  steps_ = static_cast<double>(outputs_.steps);
  begin_hold();
  forget_slip();
}

void AxisController::clear_faults() {
  if (fault_ == AxisFault::kNone) return;
  const bool disagreed = fault_ == AxisFault::kEncodersDisagree;
  fault_ = AxisFault::kNone;
  supply_low_for_ = 0;
  // Without a home the two encoders may start again from where they stand.
  if (disagreed || encoders_.motor_lost() || encoders_.joint_lost()) {
    encoders_.restart();
    slip_ = field_angle() - encoders_.motor_angle();
  }
  if (mode_ == Mode::kHold) begin_hold();
  if (!fault_frozen_) return;
  fault_frozen_ = false;
  steps_ = static_cast<double>(outputs_.steps);
  forget_slip();
}

void AxisController::self_test() {
  if (refusal() || mode_ != Mode::kHold) return;
  if (outputs_.enabled && !ready()) {
    mode_ = Mode::kSelfTest;  // begins once the rotor is at rest
    return;
  }
  const AxisSupervision& limits = settings_.supervision;
  const bool well = ready() && encoders_.good() && !inputs_.driver_fault &&
                    inputs_.supply_volts >= limits.supply_min &&
                    inputs_.temperature_c <= limits.temperature_max;
  // A homed axis knows whether its switch should be closed.
  const double inside =
      (encoders_.q() - settings_.homing.end_stop_angle) * settings_.homing.direction;
  const bool plausible = !homed_ || !end_stop_.closed() || inside > -settings_.homing.back_off_max;
  if (!well || !plausible) return fail(AxisFault::kSelfTest);
  if (!homed_) return;
  step_check_.start(encoders_.motor_angle());
  mode_ = Mode::kSelfTest;
}

AxisStatus AxisController::status() const {
  AxisStatus status;
  status.q = encoders_.q();
  status.qd = encoders_.qd();
  status.q_target = target_;
  const bool motor_fault = fault_ == AxisFault::kStalled || fault_ == AxisFault::kFollowingError ||
                           fault_ == AxisFault::kSupplyLow || fault_ == AxisFault::kTooHot ||
                           fault_ == AxisFault::kSelfTest;
  status.motor_ok = !motor_fault && outputs_.enabled && !inputs_.driver_fault;
  status.sensor_ok = encoders_.good() && fault_ != AxisFault::kJointEncoder &&
                     fault_ != AxisFault::kMotorEncoder && fault_ != AxisFault::kEncodersDisagree &&
                     fault_ != AxisFault::kEndStopStuck;
  status.communication_ok = fault_ != AxisFault::kLinkSilent;
  status.homed = homed_;
  status.position_ok = homed_ && !encoders_.motor_lost() && !encoders_.joint_lost();
  status.homing = mode_ == Mode::kHoming;
  const bool settling =
      ready() && !frozen() && std::abs(reference_.q - encoders_.q()) > settings_.position_tolerance;
  const bool tracking_at_rest = mode_ == Mode::kTracking &&
                                std::abs(reference_.qd) < kMovingSpeed &&
                                std::abs(target_ - reference_.q) < settings_.position_tolerance;
  status.moving = (mode_ != Mode::kHold && !tracking_at_rest) || settling;
  status.end_stop = end_stop_.closed();
  status.emergency_stopped = emergency_;
  status.fault = fault_;
  if (inputs_.has_meters) {
    status.supply_volts = inputs_.supply_volts;
    status.temperature_c = inputs_.temperature_c;
  }
  status.motor_magnet = inputs_.motor_magnet;
  status.joint_magnet = inputs_.joint_magnet;
  return status;
}

}  // namespace sinew
