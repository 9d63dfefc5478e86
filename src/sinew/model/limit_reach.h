#pragma once

#include <algorithm>

#include "sinew/model/robot_model.h"

namespace sinew {

/// How many times a joint's limits a program may ask for by name (`velocity`, `acceleration` rows).
struct LimitReach {
  double velocity = 1;
  double acceleration = 1;
};

/// Above 1 where a firmware's own range goes further than what is proven.
inline LimitReach limit_reach(const RobotModel& robot, std::size_t joint) {
  const double most = robot.device.settings->firmware_reach(joint);
  return {std::max(1.0, most / robot.joints[joint].velocity_max),
          std::max(1.0, most / robot.joints[joint].acceleration_max)};
}

}  // namespace sinew
