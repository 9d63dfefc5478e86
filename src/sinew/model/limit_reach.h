#pragma once

#include <algorithm>
#include <cmath>

#include "sinew/model/robot_model.h"

namespace sinew {

/// How many times a joint's limits a program may ask for by name (`velocity`, `acceleration` rows).
struct LimitReach {
  double velocity = 1;
  double acceleration = 1;
};

/// Above 1 where a firmware's own range goes further than what is proven: the BigRobotArm's file
/// has the limits of power-up, its document's M203 and M201 go to multiplier_max.
inline LimitReach limit_reach(const RobotModel& robot, std::size_t joint) {
  const auto* device = std::get_if<BigRobotArmDevice>(&robot.device.settings);
  if (device == nullptr) return {};
  const BigRobotArmJoint& motor = device->joints[joint];
  const double most = device->multiplier_max * (motor.steps_per_motor_rev / 100) /
                      std::abs(motor.steps_per_rad);  // rad/s, and rad/s^2
  return {std::max(1.0, most / robot.joints[joint].velocity_max),
          std::max(1.0, most / robot.joints[joint].acceleration_max)};
}

}  // namespace sinew
