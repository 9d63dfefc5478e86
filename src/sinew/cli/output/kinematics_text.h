#pragma once

#include <span>
#include <string>

#include "sinew/cli/output/outcome.h"
#include "sinew/core/error.h"
#include "sinew/core/pose.h"
#include "sinew/model/joint_value.h"
#include "sinew/model/robot_model.h"

namespace sinew::cli {

/// {"x_mm","y_mm","z_mm","quaternion_wxyz":[..],"rotation_fixed_xyz_deg":[..]}
Json pose_json(const Vec3& p, const Rotation& R);
/// Two lines: position, and rotation about fixed axes.
std::string pose_text(const Vec3& p, const Rotation& R);

/// An error with its numbers in mm and degrees and the sentence that people get.
Json error_json(const Error& error, const RobotModel& model);
std::string error_text(const Error& error, const RobotModel& model);

/// Values of joints (deg) or legs (mm), as JSON numbers and as people read them.
Json joints_json(std::span<const double> q, const RobotModel& model);
std::string joint_text(double q, const Joint& joint);
/// "joints_deg", or "legs_mm" for a platform.
const char* joints_key(const RobotModel& model);
/// "deg", "mm", or "deg or mm" of a SCARA.
const char* joints_unit(const RobotModel& model);
/// The same as a key's ending: "deg", "mm" or "deg_mm".
const char* joints_unit_key(const RobotModel& model);
bool all_slide(const RobotModel& model);

std::vector<std::string> joint_names(const RobotModel& model);

}  // namespace sinew::cli
