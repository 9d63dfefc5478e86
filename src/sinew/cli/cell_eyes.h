#pragma once

#include <expected>
#include <string>

#include "sinew/cli/outcome.h"
#include "sinew/runtime/running_cell.h"

namespace sinew::cli {

/// Gives each robot of the cell its calibrated camera, the first that the cell's file names.
/// @param file  the cell's: what it names is looked for beside it
/// @error  bad input: a calibration that cannot be read
std::expected<void, Outcome> open_eyes(runtime::RunningCell& cell, const std::string& file);

}  // namespace sinew::cli
