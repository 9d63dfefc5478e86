#pragma once

#include <expected>
#include <optional>
#include <string>
#include <vector>

#include "sinew/core/pose.h"
#include "sinew/model/robot_model.h"

namespace sinew::cli {

// Texts of options to values in m and rad; errors are sentences that name the option.

/// "x,y,z,rx,ry,rz": position, then rotation about fixed axes x, y, z.
std::expected<Pose<frame::Base, frame::Tool>, std::string> parse_pose(const std::string& option,
                                                                      const std::string& text);

std::expected<Vec3, std::string> parse_point(const std::string& option, const std::string& text);

/// "x,y,z" without a unit, of any length but 0, made a unit vector.
std::expected<Vec3, std::string> parse_direction(const std::string& option,
                                                 const std::string& text);

/// One value a joint or leg, in the order of the robot's file.
std::expected<JointVector, std::string> parse_joints(const std::string& option,
                                                     const std::string& text,
                                                     const RobotModel& model);

/// Width between the jaws, inside what the gripper can do; nothing where nothing was asked for.
std::expected<std::optional<double>, std::string> parse_jaw_width(
    const std::optional<std::string>& text, const SerialGeometry* geometry);

}  // namespace sinew::cli
