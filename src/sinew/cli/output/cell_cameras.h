#pragma once

#include <expected>
#include <optional>
#include <string>

#include "sinew/cli/output/outcome.h"
#include "sinew/runtime/running_cell.h"

namespace sinew::cli {

/// What a cell's file names is looked for beside it.
std::string beside(const std::string& cell_file, const std::string& file);

/// What its `calibration` says. @param path  of that file
/// @error  bad input: a file that cannot be read
std::expected<vision::TableCamera, Outcome> read_calibration(const CellCamera& camera,
                                                             const std::string& path);

/// Why the place of a camera's table says nothing in this cell: it is in the base of another robot.
std::optional<std::string> missing_robot(const Cell& cell, const vision::TableCamera& camera);

/// What `sinew camera hand-eye` has measured of a camera.
struct MeasuredHandEye {
  HandEyeFile file;
  std::optional<runtime::CameraMount> mount;  ///< nothing: it stands beside the arm
};
/// @param path   of its `hand_eye`
/// @param robot  CellCamera::robot, by its number in the cell
/// @error  bad input: a file that cannot be read, or that is of another robot
std::expected<MeasuredHandEye, Outcome> read_hand_eye_of(const CellCamera& camera,
                                                         const std::string& path, std::size_t robot,
                                                         const RobotModel& model);

/// Opens the cameras that the cell's file names.
/// @param file  the cell's
/// @error  bad input: a calibration that cannot be read
std::expected<void, Outcome> open_cameras(runtime::RunningCell& cell, const std::string& file);

}  // namespace sinew::cli
