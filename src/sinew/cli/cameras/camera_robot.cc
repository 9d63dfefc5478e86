#include "sinew/cli/cameras/camera_robot.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "sinew/cli/output/cell_cameras.h"
#include "sinew/cli/output/kinematics_text.h"
#include "sinew/cli/output/robot_argument.h"
#include "sinew/cli/output/table.h"
#include "sinew/config/cell_file.h"
#include "sinew/core/spelling.h"
#include "sinew/core/units.h"
#include "sinew/io/file.h"
#include "sinew/kinematics/palletizer.h"
#include "sinew/kinematics/serial_arm.h"
#include "sinew/model/joint_lookup.h"
#include "sinew/planning/paths/tool_space.h"
#include "sinew/runtime/links/robot_variant.h"

namespace sinew::cli {
namespace {

/// The robot that is meant by a name or, where only one has it, by an id.
const CellRobot* robot_in(const Cell& cell, const std::string& name) {
  const auto by_name = std::ranges::find(cell.robots, name, &CellRobot::name);
  if (by_name != cell.robots.end()) return &*by_name;
  const auto by_id = std::ranges::find(cell.robots, name, &CellRobot::robot);
  if (std::ranges::count(cell.robots, name, &CellRobot::robot) != 1) return nullptr;
  return &*by_id;
}

/// Position and rotation as the keys of a cell's file. Rounded to 0.01 mm and 0.001 deg.
std::array<std::pair<const char*, double>, 6> table_keys(const Vec3& p, const Rotation& R) {
  const auto rounded = [](double value, double step) { return std::round(value / step) * step; };
  const Vec3 rpy = fixed_xyz(R);
  const auto mm = [&](double value) { return rounded(to_mm(value), 0.01); };
  const auto deg = [&](double value) { return rounded(to_deg(value), 0.001); };
  return {{{"x_mm", mm(p.x)},
           {"y_mm", mm(p.y)},
           {"z_mm", mm(p.z)},
           {"rx_deg", deg(rpy.x)},
           {"ry_deg", deg(rpy.y)},
           {"rz_deg", deg(rpy.z)}}};
}

}  // namespace

std::expected<CalibrationRobot, Outcome> calibration_robot(const std::string& robot,
                                                           const std::optional<std::string>& cell) {
  if (!cell) {
    auto file = find_robot(robot);
    if (!file) return std::unexpected(file.error());
    const std::string id = file->model.id;
    return CalibrationRobot{std::move(file->model), id, false, {}};
  }
  const auto text = io::read_file(*cell);
  if (!text) return std::unexpected(bad_input("--cell: " + text.error().sentence));
  const auto read = read_cell(*text, *cell);
  if (!read) return std::unexpected(complaints_outcome(read.error()));
  const CellRobot* place = robot_in(*read, robot);
  if (place == nullptr) {
    std::vector<std::string> names;
    for (const CellRobot& other : read->robots) names.push_back(other.name);
    return std::unexpected(
        bad_input(fmt::format("--robot: {} has no robot '{}', or several; its "
                              "robots are {}",
                              *cell, printable(robot), joined(names, ", "))));
  }
  auto file = find_robot(*place, *cell);
  if (!file) return std::unexpected(file.error());
  auto model = runtime::variant_of(file->model, place->profile, place->wire);
  if (!model) return std::unexpected(bad_input(place->name + ": " + model.error()));
  return CalibrationRobot{std::move(*model), place->name, true, place->X_WB};
}

std::string placed_text(const Vec3& p, const Rotation& R) {
  const Vec3 rpy = fixed_xyz(R);
  return fmt::format(
      "    position {:.1f}, {:.1f}, {:.1f} mm\n"
      "    rotation {:.2f}, {:.2f}, {:.2f} deg about fixed x, y, z\n",
      to_mm(p.x), to_mm(p.y), to_mm(p.z), to_deg(rpy.x), to_deg(rpy.y), to_deg(rpy.z));
}

std::string camera_table_text(const Vec3& p_WT, const Rotation& R_WT) {
  std::string text;
  for (const auto& [key, value] : table_keys(p_WT, R_WT)) {
    text += fmt::format("{} = {}\n", key, number(value));
  }
  return text;
}

Json camera_table_json(const Vec3& p_WT, const Rotation& R_WT) {
  Json json = Json::object();
  for (const auto& [key, value] : table_keys(p_WT, R_WT)) json[key] = value;
  return json;
}

std::string camera_table_title(const CalibrationRobot& robot,
                               const std::optional<std::string>& cell) {
  if (cell) return "  for the [[camera]] table of " + *cell + ":\n";
  return "  for the [[camera]] table of a cell with the base of " + robot.name +
         " at its origin (--cell FILE: for that cell):\n";
}

std::expected<FlangeAt, Outcome> flange_at(const RobotModel& model, const JointVector& q) {
  if (const auto* serial = std::get_if<SerialGeometry>(&model.geometry)) {
    FlangeAt at;
    kinematics::Jacobian J;
    at.X_BF = kinematics::SerialChain(*serial).forward(q, J);
    at.jacobian = J;
    return at;
  }
  const planning::ToolSpace space(model);
  const auto X_BT = space.forward({q.data(), q.size()}, space.home());
  if (!X_BT) return std::unexpected(could_not(error_text(X_BT.error(), model)));
  return FlangeAt{relabel<frame::Base, frame::Flange>(*X_BT), {}};
}

std::string joints_argument(const RobotModel& model, const JointVector& q) {
  std::string text;
  for (std::size_t j = 0; j < q.size(); ++j) {
    text += (text.empty() ? "" : ",") + number(shown_value(q[j], model.joints[j]), 1);
  }
  return text;
}

}  // namespace sinew::cli
