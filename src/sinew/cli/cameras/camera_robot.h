#pragma once

#include <expected>
#include <optional>
#include <string>

#include "sinew/cli/output/outcome.h"
#include "sinew/core/pose.h"
#include "sinew/kinematics/serial_chain.h"
#include "sinew/model/robot_model.h"

namespace sinew::cli {

/// A robot that a camera or its sheet is measured with.
struct CalibrationRobot {
  RobotModel model;
  std::string name;  ///< in the cell; else its id
  bool in_cell = false;
  Pose<frame::World, frame::Base> X_WB;  ///< in the cell; the base is the cell's frame without one
};

/// @param robot  an id or a .toml file; with `cell` the robot's name there, or an id that only one
///               robot there has
/// @param cell   the cell's file
/// @error  a file that cannot be read; no such robot, with those that there are
std::expected<CalibrationRobot, Outcome> calibration_robot(const std::string& robot,
                                                           const std::optional<std::string>& cell);

/// "position 230.4, 0.1, 1.8 mm; rotation 0, 0, -90 deg": two lines.
std::string placed_text(const Vec3& p, const Rotation& R);

/// "LINES" of the cell's [[camera]] table for a sheet at X_WT, a key each. mm and deg
std::string camera_table_text(const Vec3& p_WT, const Rotation& R_WT);
Json camera_table_json(const Vec3& p_WT, const Rotation& R_WT);
/// The heading above them: which file, or whose frame.
std::string camera_table_title(const CalibrationRobot& robot,
                               const std::optional<std::string>& cell);

/// The flange of a serial arm in base, and how each joint moves it; of other robots their tool,
/// which no joint zero is known for.
struct FlangeAt {
  Pose<frame::Base, frame::Flange> X_BF;
  std::optional<kinematics::Jacobian> jacobian;
};
/// @error  legs that have no pose
std::expected<FlangeAt, Outcome> flange_at(const RobotModel& model, const JointVector& q);

/// "10,20.5,-30": as --joints-deg takes them.
std::string joints_argument(const RobotModel& model, const JointVector& q);

}  // namespace sinew::cli
