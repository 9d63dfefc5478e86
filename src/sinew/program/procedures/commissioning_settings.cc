#include <cmath>
#include <cstdio>
#include <cstdlib>

#include "sinew/core/units.h"
#include "sinew/model/joint_lookup.h"
#include "sinew/program/procedures/step_list.h"

namespace sinew::program {
namespace {

std::optional<double> number_of(const std::string& text) {
  char* end = nullptr;
  const double value = std::strtod(text.c_str(), &end);
  if (end == text.c_str() || *end != 0 || !std::isfinite(value)) return std::nullopt;
  return value;
}

/// The signs that were found the wrong way round.
void find_turns(const Procedure& procedure, FoundSettings& found) {
  for (const Joint& joint : procedure.machine().robot().joints) {
    const auto* one = procedure.result("direction." + joint.name);
    const bool seen = one != nullptr && one->state == StepResult::State::kDone && one->number;
    if (seen && *one->number < 0) found["joint." + joint.name + ".turn"] = "other";
  }
}

}  // namespace

std::string setting_text(double value) {
  char text[40];
  std::snprintf(text, sizeof text, "%.9g", value);
  return text;
}

const StepResult* numbered(const Procedure& procedure, const std::string& step) {
  const auto* one = procedure.result(step);
  const bool is = one != nullptr && one->state == StepResult::State::kDone && one->number;
  return is ? one : nullptr;
}

FoundSettings found_settings(const Procedure& procedure) {
  FoundSettings found;
  const RobotModel& robot = procedure.machine().robot();
  // Boards turn their motors as they are set up themselves.
  if (boards_of(robot.device).empty()) find_turns(procedure, found);
  const FirstDay* day = first_day_of(robot.device);
  if (day != nullptr && day->find != nullptr) day->find(procedure, found);
  if (const auto* jaws = procedure.result("jaws_seen")) {
    const bool open = jaws_tried(robot) > 0;
    if (jaws->answer == (open ? "shut" : "open")) found["jaws_turn"] = "other";
  }
  for (const Joint& joint : robot.joints) {
    if (const auto* id = numbered(procedure, "id." + joint.name)) {
      found["joint." + joint.name + ".servo_id"] = setting_text(*id->number);
    }
    if (const auto* zero = numbered(procedure, "zero." + joint.name)) {
      const std::string key = "joint." + joint.name;
      // It was measured as the joint counted before.
      const double sign = found.contains(key + ".turn") ? -1 : 1;
      found[key + ".trim_rad"] = setting_text(sign * *zero->number);
    }
    if (const auto* trim = numbered(procedure, "trim." + joint.name)) {
      found["joint." + joint.name + ".trim_rad"] = setting_text(*trim->number);
    }
  }
  return found;
}

std::expected<void, std::string> use_settings(RobotModel& robot, const FoundSettings& settings) {
  RobotModel changed = robot;
  // Turns first: a trim counts as the joint then does.
  for (const bool turns : {true, false}) {
    for (const auto& [name, value] : settings) {
      if (name.ends_with(".turn") != turns) continue;
      DeviceSetting setting{.what = name, .value = value, .number = number_of(value)};
      const std::size_t dot = name.rfind('.');
      constexpr std::string_view kJoint = "joint.";
      bool known = true;
      if (name.starts_with(kJoint) && dot >= kJoint.size()) {
        setting.joint = joint_named(robot, name.substr(kJoint.size(), dot - kJoint.size()));
        setting.what = std::string_view(name).substr(dot + 1);
        known = setting.joint.has_value();
      }
      const bool used = known && changed.device.settings->use_setting(setting, changed.device);
      if (!used) {
        return std::unexpected("'" + name + "' = '" + value + "' is no setting of " + robot.id);
      }
    }
  }
  if (std::string why = changed.device.settings->contradiction(changed); !why.empty()) {
    return std::unexpected(std::move(why));
  }
  robot = std::move(changed);
  return {};
}

}  // namespace sinew::program
