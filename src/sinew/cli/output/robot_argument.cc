#include "sinew/cli/output/robot_argument.h"

#include <fmt/format.h>

#include <vector>

#include "sinew/cli/output/cell_cameras.h"
#include "sinew/cli/output/table.h"
#include "sinew/config/builtin_robots.h"
#include "sinew/core/spelling.h"
#include "sinew/io/file.h"

namespace sinew::cli {
namespace {

std::expected<RobotFile, Outcome> read(std::string_view text, std::string_view file_name) {
  auto file = read_robot_file(text, file_name);
  if (!file) return std::unexpected(complaints_outcome(file.error()));
  return std::move(*file);
}

}  // namespace

std::expected<RobotFile, Outcome> find_robot(const std::string& argument) {
  if (argument.ends_with(".toml")) {
    const auto text = io::read_file(argument);
    if (!text) return std::unexpected(bad_input(text.error().sentence));
    return read(*text, argument);
  }
  std::vector<std::string_view> ids;
  for (const BuiltinRobot& robot : builtin_robots()) {
    if (robot.id == argument) return read(robot.text, robot.file_name);
    ids.push_back(robot.id);
  }
  const std::string_view meant = nearest_spelling(argument, ids);
  return std::unexpected(bad_input(fmt::format(
      "there is no robot '{}'{}; known: {}; a file of your own ends in .toml", printable(argument),
      meant.empty() ? "" : fmt::format(", did you mean '{}'?", meant), joined(ids, ", "))));
}

std::expected<RobotFile, Outcome> find_robot(const CellRobot& place, const std::string& cell_file) {
  const bool own = place.robot.ends_with(".toml");
  return find_robot(own ? beside(cell_file, place.robot) : place.robot);
}

}  // namespace sinew::cli
