#include <cmath>
#include <cstdio>
#include <cstdlib>

#include "sinew/core/units.h"
#include "sinew/devices/device_kinds.h"
#include "sinew/model/joint_lookup.h"
#include "sinew/program/procedures.h"

namespace sinew::program {
namespace {

std::string number_text(double value) {
  char text[40];
  std::snprintf(text, sizeof text, "%.9g", value);
  return text;
}

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

const StepResult* done(const Procedure& procedure, const std::string& id) {
  const auto* one = procedure.result(id);
  const bool is = one != nullptr && one->state == StepResult::State::kDone && one->number;
  return is ? one : nullptr;
}

/// The kit whose jaws go the other way: a bus servo's ends change places, pulses lie on the other
/// side of where both kits meet.
bool use_jaws(RobotModel& robot) {
  auto* device = robot.device.settings.as<LscDevice>();
  if (device == nullptr) return false;
  std::swap(device->gripper.open, device->gripper.closed);
  if (device->profile == LscProfile::kBus) return true;
  device->gripper.open = 2 * kJawsMiddle - device->gripper.open;
  device->gripper.closed = 2 * kJawsMiddle - device->gripper.closed;
  return true;
}

struct Setter {
  const std::string& what;
  const std::string& value;
  std::size_t joint;

  bool turn() const { return what == "turn" && value == "other"; }
  bool operator()(IcpDevice& device) const {
    if (turn()) device.legs[joint].invert = !device.legs[joint].invert;
    return turn();
  }
  bool operator()(BigRobotArmDevice& device) const {
    if (turn()) device.joints[joint].steps_per_rad *= -1;
    return turn();
  }
  bool operator()(MaxArmDevice& device) const {
    MaxArmServo& servo = device.servos[joint];
    constexpr double kPulsesMax = 1000;
    if (turn()) {
      // Its pulses run the other way over the same range.
      servo.offset = kPulsesMax - servo.offset;
      servo.pulses_per_rad *= -1;
    }
    return turn();
  }
  bool operator()(LscDevice& device) const {
    LscServo& servo = device.servos[joint];
    const auto number = number_of(value);
    constexpr double kIdMax = 253;
    if (turn()) {
      servo.units_per_rad *= -1;
      servo.trim *= -1;
    } else if (what == "trim_rad" && number && std::abs(*number) <= kTrimMax) {
      servo.trim += *number * servo.units_per_rad;
    } else if (what == "servo_id" && number && *number >= 1 && *number <= kIdMax) {
      servo.id = static_cast<std::uint8_t>(*number);
    } else {
      return false;
    }
    return true;
  }
  template <class Other>
  bool operator()(Other& /*device*/) const {
    return false;
  }
};

bool use_platform_setting(RobotModel& robot, const std::string& name, const std::string& value) {
  auto* device = robot.device.settings.as<IcpDevice>();
  const auto number = number_of(value);
  if (device == nullptr || !number) return false;
  constexpr double kFactorMax = 20;
  if (name == "units_per_down" && (*number == 1 || *number == 2)) {
    device->units_per_down = *number;
    return true;
  }
  if (name == "way_factor" && *number >= 1 / kFactorMax && *number <= kFactorMax) {
    device->units_per_m /= *number;
    robot.device.capability.shared_velocity *= *number;
    return true;
  }
  return false;
}

}  // namespace

namespace {

/// Two servos of one number would both go where one of them is sent.
std::expected<void, std::string> check_servo_ids(const RobotModel& robot) {
  const auto* device = robot.device.settings.as<LscDevice>();
  for (std::size_t j = 0; device != nullptr && j < device->servos.size(); ++j) {
    const int id = device->servos[j].id;
    std::string whose = id == device->gripper.id ? "the gripper" : "";
    for (std::size_t k = 0; k < j; ++k) {
      if (device->servos[k].id == id) whose = robot.joints[k].name;
    }
    if (whose.empty()) continue;
    return std::unexpected("servo " + std::to_string(id) + " would be " + robot.joints[j].name +
                           "'s and " + whose + "'s");
  }
  return {};
}

}  // namespace

FoundSettings found_settings(const Procedure& procedure) {
  FoundSettings found;
  const RobotModel& robot = procedure.machine().robot();
  const bool boards =
      robot.device.settings.is<AxisRegistersDevice>() || robot.device.settings.is<AxisLinkDevice>();
  // Boards turn their motors as they are set up themselves.
  if (!boards) find_turns(procedure, found);
  if (const auto* icp = robot.device.settings.as<IcpDevice>()) {
    const auto* down = done(procedure, "minus_one");
    if (down != nullptr && *down->number != icp->units_per_down) {
      found["units_per_down"] = number_text(*down->number);
    }
    const auto* sent = done(procedure, "go_far");
    const auto* went = done(procedure, "went");
    if (sent != nullptr && went != nullptr) {
      found["way_factor"] = number_text(*went->number / std::abs(*sent->number));
    }
  }
  if (const auto* jaws = procedure.result("jaws_seen")) {
    const bool open = jaws_tried(robot) > 0;
    if (jaws->answer == (open ? "shut" : "open")) found["jaws_turn"] = "other";
  }
  for (const Joint& joint : robot.joints) {
    if (const auto* id = done(procedure, "id." + joint.name)) {
      found["joint." + joint.name + ".servo_id"] = number_text(*id->number);
    }
    if (const auto* trim = done(procedure, "trim." + joint.name)) {
      found["joint." + joint.name + ".trim_rad"] = number_text(*trim->number);
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
      bool used = false;
      const std::size_t dot = name.rfind('.');
      constexpr std::string_view kJoint = "joint.";
      if (name.starts_with(kJoint) && dot >= kJoint.size()) {
        const auto joint = joint_named(robot, name.substr(kJoint.size(), dot - kJoint.size()));
        const std::string what = name.substr(dot + 1);
        used = joint && visit_kind(Setter{what, value, *joint}, changed.device.settings);
      } else if (name == "jaws_turn") {
        used = value == "other" && use_jaws(changed);
      } else {
        used = use_platform_setting(changed, name, value);
      }
      if (!used) {
        return std::unexpected("'" + name + "' = '" + value + "' is no setting of " + robot.id);
      }
    }
  }
  if (auto once = check_servo_ids(changed); !once) return once;
  robot = std::move(changed);
  return {};
}

}  // namespace sinew::program
