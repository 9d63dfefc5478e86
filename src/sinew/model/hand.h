#pragma once

#include <variant>

#include "sinew/model/robot_model.h"

/// What a robot takes things with.
namespace sinew {

/// The jaws that its device opens and closes; nullptr of a robot without. @rt
inline const JawGripper* jaws_of(const RobotModel& robot) {
  const auto* arm = std::get_if<SerialGeometry>(&robot.geometry);
  const bool driven = robot.device.capability.hand == HandDrive::kJaws;
  return arm != nullptr && arm->gripper && driven ? &*arm->gripper : nullptr;
}

}  // namespace sinew
