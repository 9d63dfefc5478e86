#include "sinew/devices/lsc/lsc_settings.h"

#include <cmath>
#include <numbers>
#include <utility>

#include "sinew/model/robot_model.h"

namespace sinew {
namespace {

constexpr double kBusUnitsMax = 1000;

/// Bus servos count 1000 units over 240 degrees, their middle is 500, an arm joint has 125..875.
void use_bus_units(LscDevice& device) {
  constexpr double kUnitsPerRad = kBusUnitsMax / (240 * std::numbers::pi / 180);
  for (LscServo& servo : device.servos) {
    const double trim_rad = servo.units_per_rad != 0 ? servo.trim / servo.units_per_rad : 0;
    servo.units_per_rad = std::copysign(kUnitsPerRad, servo.units_per_rad);
    servo.trim = trim_rad * servo.units_per_rad;
    servo.centre = 500;
    servo.lower = 125;
    servo.upper = 875;
  }
  device.gripper.open = 200;
  device.gripper.closed = 700;
}

}  // namespace

std::vector<std::string> LscDevice::profiles() const {
  constexpr const char* kNames[] = {"lsc6", "bus", "esp32"};
  std::vector<std::string> names{kNames[static_cast<int>(profile)]};
  for (const char* name : kNames) {
    if (name != names[0]) names.emplace_back(name);
  }
  return names;
}

void LscDevice::use_profile(const std::string& name, Device& device) {
  const bool was_bus = profile == LscProfile::kBus || servos[0].upper <= kBusUnitsMax;
  if (name == "bus") {
    profile = LscProfile::kBus;
    if (!was_bus) use_bus_units(*this);
    device.capability.feedback = PositionFeedback::kMeasured;
  } else if (name == "esp32") {
    profile = LscProfile::kEsp32;
    // The ESP32 kit's gripper turns the other way and is stopped at 1500.
    gripper.open = 500;
    gripper.closed = 1500;
    device.capability.feedback = PositionFeedback::kCommanded;
  } else {
    profile = LscProfile::kLsc6;
    device.capability.feedback = PositionFeedback::kNone;
  }
  device.capability.free_drive = profile == LscProfile::kBus;
}

bool LscDevice::use_setting(const DeviceSetting& setting, Device& /*device*/) {
  constexpr double kIdMax = 253;
  const auto& number = setting.number;
  if (!setting.joint) {
    if (setting.what != "jaws_turn" || setting.value != "other") return false;
    // The kit whose jaws go the other way: a bus servo's ends change places, pulses lie on the
    // other side of where both kits meet.
    std::swap(gripper.open, gripper.closed);
    if (profile == LscProfile::kBus) return true;
    gripper.open = 2 * kJawsMiddle - gripper.open;
    gripper.closed = 2 * kJawsMiddle - gripper.closed;
    return true;
  }
  LscServo& servo = servos[*setting.joint];
  if (setting.turns_joint()) {
    servo.units_per_rad *= -1;
    servo.trim *= -1;
  } else if (setting.what == "trim_rad" && number && std::abs(*number) <= kTrimMax) {
    servo.trim += *number * servo.units_per_rad;
  } else if (setting.what == "servo_id" && number && *number >= 1 && *number <= kIdMax) {
    servo.id = static_cast<std::uint8_t>(*number);
  } else {
    return false;
  }
  return true;
}

std::string LscDevice::contradiction(const RobotModel& robot) const {
  for (std::size_t j = 0; j < servos.size(); ++j) {
    const int id = servos[j].id;
    std::string whose = id == gripper.id ? "the gripper" : "";
    for (std::size_t k = 0; k < j; ++k) {
      if (servos[k].id == id) whose = robot.joints[k].name;
    }
    if (whose.empty()) continue;
    return "servo " + std::to_string(id) + " would be " + robot.joints[j].name + "'s and " + whose +
           "'s";
  }
  return {};
}

}  // namespace sinew
