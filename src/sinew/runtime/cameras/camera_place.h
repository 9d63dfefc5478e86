#pragma once

#include <cstddef>
#include <expected>
#include <optional>
#include <string>

#include "sinew/config/hand_eye_file.h"
#include "sinew/model/cell.h"
#include "sinew/render/robot_body.h"
#include "sinew/vision/table_camera.h"

namespace sinew::runtime {

/// A camera on the arm of a cell's robot.
struct CameraMount {
  std::size_t robot = 0;  ///< of the cell's
  Pose<frame::Flange, frame::Camera> X_FC;
  JointVector zeros;  ///< rad, to add to its joints
};

/// Of what was measured on a robot of this model.
/// @return  nothing: the camera stands beside the arm
/// @error  a sentence: the file is of another robot
std::expected<std::optional<CameraMount>, std::string> mount_of(const HandEyeFile& file,
                                                                std::size_t robot,
                                                                const RobotModel& model);

/// Where the camera is while its robot stands so; nothing where its legs have no pose.
std::optional<Pose<frame::World, frame::Camera>> pose_on(const CameraMount& mount,
                                                         render::ViewedRobot robot);

/// Gives a camera that stands beside an arm its table by a hand-eye calibration, unless marks were
/// touched.
/// @param robot  its name in the cell
void place_beside(const HandEyeFile& file, const std::string& robot, vision::TableCamera& camera);

/// Where the table of a camera is in its cell: as a robot has measured it, else as the cell's file
/// says.
/// @param calibration  null: none
Pose<frame::World, frame::Table> table_of(const Cell& cell, const CellCamera& camera,
                                          const vision::TableCamera* calibration);

}  // namespace sinew::runtime
