#pragma once

#include <expected>
#include <optional>
#include <string>

#include "sinew/cli/outcome.h"
#include "sinew/runtime/running_cell.h"

namespace sinew::cli {

/// What a cell's file names is looked for beside it.
std::string beside(const std::string& cell_file, const std::string& file);

/// What its `calibration` says. @param path  of that file
/// @error  bad input: a file that cannot be read, or that names a robot which the cell has not
std::expected<vision::TableCamera, Outcome> read_calibration(const Cell& cell,
                                                             const CellCamera& camera,
                                                             const std::string& path);

/// What its `hand_eye` says of a calibrated camera: it is on the arm, or beside it.
/// @param path   of that file
/// @param robot  CellCamera::robot, by its number in the cell
/// @return  where it is mounted; nothing: the calibration says now where its table is
/// @error  bad input: a file that cannot be read, or that is of another robot
std::expected<std::optional<runtime::CameraMount>, Outcome> read_hand_eye_of(
    const CellCamera& camera, const std::string& path, std::size_t robot, const RobotModel& model,
    vision::TableCamera& calibration);

/// Opens the cameras that the cell's file names.
/// @param file  the cell's
/// @error  bad input: a calibration that cannot be read
std::expected<void, Outcome> open_cameras(runtime::RunningCell& cell, const std::string& file);

}  // namespace sinew::cli
