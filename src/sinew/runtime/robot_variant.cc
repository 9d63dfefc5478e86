#include "sinew/runtime/robot_variant.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "sinew/core/spelling.h"
#include "sinew/devices/axis/axis_link_settings.h"
#include "sinew/devices/axis/axis_registers_settings.h"
#include "sinew/devices/bigrobotarm/bigrobotarm_settings.h"
#include "sinew/devices/icp/icp_settings.h"
#include "sinew/devices/lsc/lsc_settings.h"
#include "sinew/devices/maxarm/maxarm_settings.h"
#include "sinew/model/joint_lookup.h"
#include "sinew/model/left_out.h"

namespace sinew::runtime {
namespace {

using Names = std::vector<std::string>;

std::string list_of(const Names& names) {
  std::string list;
  for (const std::string& name : names) list += (list.empty() ? "" : ", ") + name;
  return list;
}

std::expected<void, std::string> check(const char* option, const std::optional<std::string>& name,
                                       const Names& known, const RobotModel& robot) {
  if (!name || std::ranges::find(known, *name) != known.end()) return {};
  const std::string what = std::string(option) + ": '" + printable(*name) + "' ";
  if (known.empty()) return std::unexpected(what + "is unknown: " + robot.id + " has but one");
  return std::unexpected(what + "is none of " + list_of(known));
}

/// Bus servos count 1000 units over 240 degrees, their middle is 500, an arm joint has 125..875.
void use_bus_units(LscDevice& device) {
  constexpr double kUnitsPerRad = 1000 / (240 * std::numbers::pi / 180);
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

void set_profile(RobotModel& robot, LscDevice& device, const std::string& profile) {
  constexpr double kBusUnitsMax = 1000;
  const bool was_bus = device.profile == LscProfile::kBus || device.servos[0].upper <= kBusUnitsMax;
  if (profile == "bus") {
    device.profile = LscProfile::kBus;
    if (!was_bus) use_bus_units(device);
    robot.device.capability.feedback = PositionFeedback::kMeasured;
  } else if (profile == "esp32") {
    device.profile = LscProfile::kEsp32;
    // The ESP32 kit's gripper turns the other way and is stopped at 1500.
    device.gripper.open = 500;
    device.gripper.closed = 1500;
    robot.device.capability.feedback = PositionFeedback::kCommanded;
  } else {
    device.profile = LscProfile::kLsc6;
  }
}

/// What a profile names comes on top of what the robot's file says.
void set_profile(IcpDevice& device, const std::string& profile) {
  IcpFirmware& firmware = device.firmware;
  if (profile == "section4") firmware.knows_wake = false;
  if (profile == "slow") firmware.processing = std::chrono::milliseconds(5);
  if (profile == "idle-shutdown") firmware.idle_shutdown = std::chrono::minutes(10);
  if (profile != "fffe") return;
  firmware.minus_one_is_fffe = true;
  device.units_per_down = 2;
}

void use_axis_link(RobotModel& robot) {
  AxisLinkDevice link;
  link.boards = robot.device.settings.get<AxisRegistersDevice>().boards;
  robot.device.settings = link;
  robot.device.protocol = "axis_link";
  robot.device.capability = {MotionKind::kStream, PositionFeedback::kMeasured,
                             std::chrono::milliseconds(50), 0.8};
}

void set_wire(RobotModel& robot, BigRobotArmDevice& device, const std::string& wire) {
  static_cast<void>(robot);
  device.probe_wire = wire == "probe";
  device.wire = wire.starts_with("text") ? BigRobotArmWire::kText : BigRobotArmWire::kByte;
  device.dialect = wire == "text2026" ? BigRobotArmDialect::k2026 : BigRobotArmDialect::k2021;
}

AxisBoards* boards_in(Device& device) {
  if (auto* registers = device.settings.as<AxisRegistersDevice>()) {
    return &registers->boards;
  }
  if (auto* link = device.settings.as<AxisLinkDevice>()) return &link->boards;
  return nullptr;
}

std::expected<void, std::string> leave_out(RobotModel& robot, std::span<const std::string> names) {
  AxisBoards* boards = boards_in(robot.device);
  if (boards == nullptr) {
    return std::unexpected("--without: " + robot.id +
                           " has one controller for all joints; no joint can be left out");
  }
  for (const std::string& name : names) {
    const auto joint = joint_named(robot, name);
    if (!joint) {
      Names known;
      for (const Joint& one : robot.joints) known.push_back(one.name);
      return std::unexpected("--without: '" + printable(name) + "' is no joint of " + robot.id +
                             "; its joints: " + list_of(known) + ", or J1 to J" +
                             std::to_string(known.size()));
    }
    (*boards)[*joint].homing_place = kLeftOut;
  }
  const bool none = std::ranges::all_of(
      *boards, [](const AxisBoard& board) { return board.homing_place == kLeftOut; });
  if (none) return std::unexpected("--without: all joints are left out; at least one must stay");
  return {};
}

}  // namespace

std::vector<std::string> profiles_of(const RobotModel& robot) {
  const auto& settings = robot.device.settings;
  if (settings.is<BigRobotArmDevice>()) return {"document", "as-built"};
  if (settings.is<AxisRegistersDevice>()) {
    return {"document", "as-built", "as-committed"};
  }
  if (const auto* lsc = settings.as<LscDevice>()) {
    constexpr const char* kNames[] = {"lsc6", "bus", "esp32"};
    Names names{kNames[static_cast<int>(lsc->profile)]};
    for (const char* name : kNames) {
      if (name != names[0]) names.emplace_back(name);
    }
    return names;
  }
  if (settings.is<MaxArmDevice>()) {
    return {"arduino", "micropython", "arduino-with-header", "micropython-spec"};
  }
  if (settings.is<IcpDevice>()) {
    return {"table1", "section4", "fffe", "slow", "idle-shutdown"};
  }
  return {};
}

std::vector<std::string> wires_of(const RobotModel& robot) {
  const auto& settings = robot.device.settings;
  if (const auto* arm = settings.as<BigRobotArmDevice>()) {
    Names names{"byte", "text", "text2026", "probe"};
    const bool text = arm->wire == BigRobotArmWire::kText;
    std::size_t own = 0;
    if (text) own = arm->dialect == BigRobotArmDialect::k2026 ? 2 : 1;
    if (arm->probe_wire) own = 3;
    std::rotate(names.begin(), names.begin() + static_cast<std::ptrdiff_t>(own),
                names.begin() + static_cast<std::ptrdiff_t>(own) + 1);
    return names;
  }
  if (settings.is<AxisRegistersDevice>()) return {"registers", "link"};
  if (settings.is<AxisLinkDevice>()) return {"link"};
  return {};
}

std::expected<RobotModel, std::string> variant_of(const RobotModel& robot,
                                                  const std::optional<std::string>& profile,
                                                  const std::optional<std::string>& wire,
                                                  std::span<const std::string> without) {
  if (const auto fine = check("--wire", wire, wires_of(robot), robot); !fine) {
    return std::unexpected(fine.error());
  }
  RobotModel variant = robot;
  auto& settings = variant.device.settings;
  if (wire) {
    if (auto* arm = settings.as<BigRobotArmDevice>()) set_wire(variant, *arm, *wire);
    if (*wire == "link" && settings.is<AxisRegistersDevice>()) {
      use_axis_link(variant);
    }
  }
  if (const auto fine = check("--profile", profile, profiles_of(variant), variant); !fine) {
    return std::unexpected(fine.error());
  }
  if (profile) {
    if (auto* lsc = settings.as<LscDevice>()) set_profile(variant, *lsc, *profile);
    if (auto* arm = settings.as<MaxArmDevice>()) {
      const bool arduino = profile->starts_with("arduino");
      arm->variant = arduino ? MaxArmVariant::kArduino : MaxArmVariant::kMicroPython;
      const bool header = *profile == "micropython" || *profile == "arduino-with-header";
      arm->checksum = header ? MaxArmChecksum::kWithHeader : MaxArmChecksum::kSpec;
    }
    if (auto* boards = settings.as<AxisRegistersDevice>()) {
      // The first firmware's DIAG_STATUS is always 0.
      boards->reports_status = *profile == "document";
    }
    if (auto* icp = settings.as<IcpDevice>()) set_profile(*icp, *profile);
  }
  if (!without.empty()) {
    if (const auto fine = leave_out(variant, without); !fine) return std::unexpected(fine.error());
  }
  return variant;
}

}  // namespace sinew::runtime
