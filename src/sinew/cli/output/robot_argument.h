#pragma once

#include <expected>
#include <string>

#include "sinew/cli/output/outcome.h"
#include "sinew/config/robot_file.h"
#include "sinew/model/cell.h"

namespace sinew::cli {

/// The robot that a user named: an id of a built-in one, or the path of a .toml file. The error is
/// ready to be printed: every complaint of the file, or the ids that there are.
std::expected<RobotFile, Outcome> find_robot(const std::string& argument);
/// The robot of a place in a cell; one of its own file has that beside the cell's.
std::expected<RobotFile, Outcome> find_robot(const CellRobot& place, const std::string& cell_file);

}  // namespace sinew::cli
