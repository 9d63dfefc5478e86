#pragma once

#include <optional>

#include "sinew/core/pose.h"
#include "sinew/model/robot_model.h"

/// The tip of a robot's tool, which touches what a camera is calibrated with.
namespace sinew::calibration {

/// Tip of the tool in base, m. @pre no hexapod
/// @param jaw_width  m, between a gripper's jaws
Vec3 tip_at(const RobotModel& model, const JointVector& q, double jaw_width);

/// Joints inside their limits that bring the tip to p_BT, the tool as nearly along approach_B (unit
/// vector) as the robot allows; nothing where there are none.
std::optional<JointVector> joints_for_tip(const RobotModel& model, double jaw_width,
                                          const Vec3& p_BT, const Vec3& approach_B);

}  // namespace sinew::calibration
