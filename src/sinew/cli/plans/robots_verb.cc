#include "sinew/cli/plans/robots_verb.h"

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <map>
#include <memory>

#include "sinew/cli/output/kinematics_text.h"
#include "sinew/cli/output/robot_argument.h"
#include "sinew/cli/output/table.h"
#include "sinew/config/builtin_robots.h"
#include "sinew/core/units.h"
#include "sinew/kinematics/serial_arm.h"

namespace sinew::cli {
namespace {

using Solver = kinematics::SerialArm::Solver;

std::string kinematics_name(const RobotModel& model) {
  if (std::holds_alternative<HexapodGeometry>(model.geometry)) return "6-UPS platform";
  if (std::holds_alternative<PalletizerGeometry>(model.geometry)) return "palletizer";
  const auto& geometry = std::get<SerialGeometry>(model.geometry);
  const kinematics::SerialArm arm(geometry, model.joints, kinematics::tool_pose(geometry));
  switch (arm.solver()) {
    case Solver::kSixR:
      return "6R, spherical wrist";
    case Solver::kFiveRPitch:
      return "5R, pitch and roll";
    case Solver::kFiveRRoll:
      return "5R, rolling forearm";
    case Solver::kScara:
      return "SCARA";
    case Solver::kNumeric:
      break;
  }
  return fmt::format("{} joints, numeric inverse", model.joints.size());
}

const char* motion_name(const Device& device) {
  return device.capability.motion == MotionKind::kStream ? "host" : "device";
}

/// What collision checks know of its body, in words.
std::string body_text(const Collision& collision) {
  if (collision.shapes.empty()) return "no collision shapes";
  const std::string table =
      collision.table_height
          ? fmt::format("table at {} mm", number(to_mm(*collision.table_height), 4))
          : "no table";
  return fmt::format("{} collision shapes, {}, margin {} mm", collision.shapes.size(), table,
                     number(to_mm(collision.margin), 4));
}

Json body(const Collision& collision) {
  Json json{{"shapes", collision.shapes.size()}, {"margin_mm", to_mm(collision.margin)}};
  if (collision.table_height) json["table_height_mm"] = to_mm(*collision.table_height);
  return json;
}

Json summary(const RobotModel& model) {
  return {{"id", model.id},
          {"title", model.title},
          {"kinematics", kinematics_name(model)},
          {"joints", joint_names(model)},
          {"protocol", model.device.protocol},
          {"motion_made_by", motion_name(model.device)}};
}

}  // namespace

Outcome list_robots() {
  Outcome outcome;
  outcome.json["robots"] = Json::array();
  Table table({"id", "robot", "kinematics", "joints", "wire", "motion by"});
  table.left(1).left(2).left(4).left(5);
  for (const BuiltinRobot& builtin : builtin_robots()) {
    const auto file = find_robot(std::string(builtin.id));
    if (!file) return file.error();
    const RobotModel& model = file->model;
    outcome.json["robots"].push_back(summary(model));
    table.add({model.id, model.title, kinematics_name(model),
               fmt::format("{}", model.joints.size()), model.device.protocol,
               motion_name(model.device)});
  }
  outcome.text =
      table.text() + "\n  sinew robots ROBOT shows one of them; ROBOT may also be a .toml file.\n";
  return outcome;
}

Outcome show_robot(const std::string& argument) {
  const auto file = find_robot(argument);
  if (!file) return file.error();
  const RobotModel& model = file->model;
  Outcome outcome;
  outcome.json = summary(model);
  outcome.json["collision"] = body(model.collision);
  outcome.json["limits"] = Json::array();
  Table table({"joint", "from", "to", "home", "speed max", "acceleration max", "jerk max", "unit"});
  table.left(7);
  for (const Joint& joint : model.joints) {
    const char* unit = shown_unit(joint);
    const double factor = shown_value(1, joint);
    table.add({joint.name, joint_text(joint.lower, joint), joint_text(joint.upper, joint),
               joint_text(joint.home, joint), number(joint.velocity_max * factor, 4),
               number(joint.acceleration_max * factor, 4), number(joint.jerk_max * factor, 4),
               unit});
    Json limits{{"joint", joint.name}};
    const std::map<std::string, double> values{{"lower_{}", joint.lower},
                                               {"upper_{}", joint.upper},
                                               {"home_{}", joint.home},
                                               {"velocity_{}_s_max", joint.velocity_max},
                                               {"acceleration_{}_s2_max", joint.acceleration_max},
                                               {"jerk_{}_s3_max", joint.jerk_max}};
    for (const auto& [key, value] : values) {
      limits[fmt::format(fmt::runtime(key), unit)] = value * factor;
    }
    outcome.json["limits"].push_back(limits);
  }
  Table sources({"constant", "line", "where it comes from"});
  sources.left(2);
  outcome.json["sources"] = Json::array();
  for (const Provenance& source : file->sources) {
    sources.add({source.key, fmt::format("{}", source.line), source.source});
    outcome.json["sources"].push_back(
        {{"key", source.key}, {"line", source.line}, {"source", source.source}});
  }
  outcome.text = fmt::format("  {}: {}\n  {}; wire {}, motion made by the {}\n  {}\n\n{}\n{}",
                             model.id, model.title, kinematics_name(model), model.device.protocol,
                             motion_name(model.device), body_text(model.collision), table.text(),
                             sources.text());
  return outcome;
}

void add_robots(CLI::App& app, ChosenVerb& call) {
  const auto robot = std::make_shared<std::string>();
  CLI::App* verb = add_verb(app, call, "robots", "the robots that Sinew knows, or all about one",
                            "sinew robots learm");
  verb->add_option("ROBOT", *robot, "id or .toml file; all built-in ones where left out");
  verb->callback([&call, robot] {
    call.verb = [robot] { return robot->empty() ? list_robots() : show_robot(*robot); };
  });
}

}  // namespace sinew::cli
