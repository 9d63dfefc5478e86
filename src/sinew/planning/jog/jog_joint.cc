#include "sinew/planning/jog/jog_joint.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "sinew/motion/velocity_change.h"

namespace sinew::planning {
namespace {

using motion::AxisState;
using motion::OnlineProfile;
using motion::PositionRange;
using motion::ProfileBounds;

/// Of the acceleration limit, how much a reference may claim for its own change: beside it a joint
/// can always still catch up.
constexpr double kRateShare = 0.9;
/// Of a limit: what is rounding.
constexpr double kRounding = 1e-12;

double clamped(double x, double most) {
  return std::clamp(x, -most, most);
}

}  // namespace

/// With the acceleration taken back at once, the velocity still grows by a^2 / 2j.
bool JogJoint::keeps_velocity(const AxisState& state) const {
  const double natural = state.qd + state.qdd * std::abs(state.qdd) / (2 * limits_.jerk);
  const double most = limits_.velocity * (1 + kRounding);
  return std::abs(state.qd) <= most && std::abs(natural) <= most;
}

bool JogJoint::rests_inside(const AxisState& state, const PositionRange& range) const {
  // Never more than this: the acceleration first has to be taken back.
  const double ramp = limits_.acceleration / limits_.jerk;
  const double speed = std::abs(state.qd) + limits_.acceleration * ramp / 2;
  const double way = speed * (speed / (2 * limits_.acceleration) + 1.5 * ramp);
  if (state.q + way <= range.upper && state.q - way >= range.lower) return true;
  const PositionRange passed = stop(state).range();
  return passed.upper <= range.upper && passed.lower >= range.lower;
}

PositionRange JogJoint::range_from(const AxisState& state) const {
  if (rests_inside(state, range_)) return range_;
  const PositionRange passed = stop(state).range();
  return {std::min(range_.lower, passed.lower), std::max(range_.upper, passed.upper)};
}

/// Seen from the reference, it is a velocity to be brought to 0, with what the reference's own
/// change leaves of the acceleration.
AxisState JogJoint::towards_velocity(const AxisState& state, const JointReference& reference,
                                     double dt) {
  const auto& [velocity, rate] = reference;
  const double start = velocity - rate * dt;
  ProfileBounds bounds = bounds_;
  bounds.acceleration_lower -= rate;
  bounds.acceleration_upper -= rate;
  const motion::VelocityChange change({0, state.qd - start, state.qdd - rate}, 0, bounds);
  change.profile(profile_);
  const AxisState seen = profile_.at(dt);
  return {state.q + seen.q + dt * (start + dt * rate / 2), seen.qd + velocity, seen.qdd + rate};
}

AxisState JogJoint::follow(const AxisState& state, const JointReference& reference, double dt) {
  const JointReference wanted{clamped(reference.velocity, limits_.velocity),
                              clamped(reference.rate, kRateShare * limits_.acceleration)};
  AxisState next = towards_velocity(state, wanted, dt);
  if (!keeps_velocity(next)) next = towards_velocity(state, {wanted.velocity, 0}, dt);
  const PositionRange range = range_from(state);
  if (rests_inside(next, range)) return next;
  // It would be too late to brake afterwards: a motion that ends at the limit itself.
  const bool upwards = stop(next).range().upper > range.upper;
  ProfileBounds bounds = bounds_;
  const double speed = std::max(std::abs(wanted.velocity), std::abs(state.qd));
  bounds.velocity_upper = std::clamp(speed, kRounding * limits_.velocity, limits_.velocity);
  bounds.velocity_lower = -bounds.velocity_upper;
  const double limit = upwards ? range.upper : range.lower;
  next = OnlineProfile::to(state, limit, bounds).at(dt);
  if (keeps_velocity(next)) return next;
  return stop(state).at(dt);
}

double JogJoint::approach_speed(double q, bool upwards, double share) const {
  const double way = upwards ? range_.upper - q : q - range_.lower;
  if (!(way > 0)) return 0;
  // From speed v: v sqrt(v/j) where the limit of acceleration is not come to, else
  // v (v/a + a/j) / 2.
  const double a = share * limits_.acceleration;
  const double j = share * limits_.jerk;
  const double without = std::cbrt(way * way * j);
  if (without <= a * a / j) return without;
  const double ramp = a * a / (2 * j);
  return std::sqrt(ramp * ramp + 2 * a * way) - ramp;
}

}  // namespace sinew::planning
