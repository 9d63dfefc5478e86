#pragma once

#include <expected>
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

/// Opens the cameras that the cell's file names.
/// @param file  the cell's
/// @error  bad input: a calibration that cannot be read
std::expected<void, Outcome> open_cameras(runtime::RunningCell& cell, const std::string& file);

}  // namespace sinew::cli
