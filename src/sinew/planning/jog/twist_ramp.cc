#include "sinew/planning/jog/twist_ramp.h"

#include <algorithm>
#include <cmath>

#include "sinew/motion/velocity_change.h"

namespace sinew::planning {

void TwistRamp::begin(const TaskArray& velocity, const TaskArray& acceleration) {
  velocity_ = velocity;
  acceleration_ = acceleration;
}

/// What is still to go, and what goes on by itself for as long as an acceleration takes to end.
TaskArray TwistRamp::direction(const TaskArray& target, double acceleration, double jerk) const {
  const double time = acceleration / jerk;
  TaskArray along{};
  double squares = 0;
  for (std::size_t k = 0; k < kTasksMax; ++k) {
    const double way = target[k] - velocity_[k];
    const double size = std::abs(way) + time * std::abs(acceleration_[k]);
    along[k] = std::copysign(size, way);
    squares += size * size;
  }
  if (!(squares > 0)) return {};
  const double scale = 1 / std::sqrt(squares);
  for (double& number : along) number *= scale;
  return along;
}

void TwistRamp::step(const TaskArray& target, double acceleration, double jerk, double dt) {
  const TaskArray along = direction(target, acceleration, jerk);
  constexpr double kNothing = 1e-12;
  for (std::size_t k = 0; k < kTasksMax; ++k) {
    const double share = std::abs(along[k]);
    if (share < kNothing) {
      velocity_[k] = target[k];
      acceleration_[k] = 0;
      continue;
    }
    // Limits that have just become narrower must not send it beyond its target.
    const double way = target[k] - velocity_[k];
    const double now = std::abs(acceleration_[k]);
    const bool nearing = way * acceleration_[k] > 0;
    const motion::ProfileBounds bounds(
        {1, std::max(share * acceleration, now),
         std::max(share * jerk, nearing ? now * now / (2 * std::abs(way)) : 0.0)});
    const motion::VelocityChange change({0, velocity_[k], acceleration_[k]}, target[k], bounds);
    change.profile(profile_);
    const motion::AxisState next = profile_.at(dt);
    velocity_[k] = next.qd;
    acceleration_[k] = next.qdd;
  }
}

void TwistRamp::shrink(double share) {
  for (double& number : velocity_) number *= share;
  for (double& number : acceleration_) number *= share;
}

}  // namespace sinew::planning
