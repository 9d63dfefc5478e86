#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "sinew/model/robot_model.h"
#include "sinew/model/taught_points.h"

namespace sinew {

/// All joints where the robot's file calls them home.
inline JointVector home_joints(const RobotModel& model) {
  JointVector q;
  for (const Joint& joint : model.joints) q.push_back(joint.home);
  return q;
}

/// Joints that slide, a bit each.
inline std::uint8_t prismatic_joints(const RobotModel& model) {
  unsigned bits = 0;
  for (std::size_t i = 0; i < model.joints.size(); ++i) {
    if (model.joints[i].slides()) bits |= 1U << i;
  }
  return static_cast<std::uint8_t>(bits);
}

/// Of an arm's joint, as its lift; a platform's leg is none.
inline bool slides_in_arm(const RobotModel& model, std::size_t joint) {
  return model.joints[joint].slides() && std::holds_alternative<SerialGeometry>(model.geometry);
}

/// How far this joint may be moved at a time while its place is not known, rad or m; 0: not at all.
inline double nudge_max(const RobotModel& model, std::size_t joint) {
  const DeviceCapability& device = model.device.capability;
  return slides_in_arm(model, joint) ? device.nudge_slide_max : device.nudge_max;
}

/// Why the joints of a point are not this robot's, a sentence; empty where they are, or it has
/// none.
std::string misfit_of_joints(const TaughtPoint& point, const RobotModel& model);

/// The joint of that name, or of a number as in J2; nothing where there is none.
inline std::optional<std::size_t> joint_named(const RobotModel& model, std::string_view name) {
  for (std::size_t i = 0; i < model.joints.size(); ++i) {
    if (model.joints[i].name == name) return i;
  }
  for (std::size_t i = 0; i < model.joints.size(); ++i) {
    if ("J" + std::to_string(i + 1) == name) return i;
  }
  return std::nullopt;
}

}  // namespace sinew
