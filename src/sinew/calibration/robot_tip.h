#pragma once

#include <optional>

#include "sinew/core/pose.h"
#include "sinew/model/robot_model.h"

/// The tip of a robot's tool, which touches what a camera is calibrated with.
namespace sinew::calibration {

/// What touches.
struct TouchTool {
  double jaws = 0;  ///< m, between a gripper's jaws
  double pin = 0;   ///< m, that something thin stands out of the tool: tools keep clear of tables
};

/// Tip of the tool in base, m; the pin's where there is one. @pre no hexapod
Vec3 tip_at(const RobotModel& model, const JointVector& q, const TouchTool& tool);

/// Joints inside their limits that bring the tip to p_BT, the tool as nearly along approach_B (unit
/// vector) as the robot allows; nothing where there are none.
std::optional<JointVector> joints_for_tip(const RobotModel& model, const TouchTool& tool,
                                          const Vec3& p_BT, const Vec3& approach_B);

}  // namespace sinew::calibration
