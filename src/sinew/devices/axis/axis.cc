#include <fmt/format.h>

#include "sinew/core/error_code.h"
#include "sinew/core/units.h"
#include "sinew/devices/axis/axis_device_settings.h"
#include "sinew/devices/axis/axis_file.h"
#include "sinew/devices/axis/axis_listener.h"
#include "sinew/devices/axis/axis_machine.h"
#include "sinew/devices/axis/axis_search.h"
#include "sinew/devices/axis_link/axis_link_driver.h"
#include "sinew/devices/axis_link/axis_link_view.h"
#include "sinew/devices/axis_registers/axis_registers_driver.h"
#include "sinew/devices/axis_registers/axis_registers_view.h"
#include "sinew/devices/kind.h"
#include "sinew/model/error_sentence.h"

namespace sinew {
namespace {

RobotDriver registers_driver(const RobotModel& robot, double /*patience*/) {
  return {nullptr, std::make_unique<AxisRegistersDriver>(
                       robot.device.settings.get<AxisRegistersDevice>(), robot.joints)};
}

RobotDriver link_driver(const RobotModel& robot, double /*patience*/) {
  return {nullptr, std::make_unique<AxisLinkDriver>(robot.device.settings.get<AxisLinkDevice>(),
                                                    robot.joints)};
}

std::expected<RobotMachine, std::string> stepper_arm(const RobotModel& robot,
                                                     const MachineVariant& variant, Instant boot,
                                                     sim::AxisWire wire) {
  if (!std::holds_alternative<SerialGeometry>(robot.geometry)) {
    return simulated_for(robot, "a serial chain");
  }
  const std::size_t joints = robot.joints.size();
  if (robot.dynamics.drives.size() != joints || robot.dynamics.links.size() != joints) {
    return std::unexpected(robot.id +
                           ": to simulate it, its file needs a table [drive.<joint>] and a table "
                           "[link.<joint>] for every joint");
  }
  sim::StepperArm::Settings settings;
  settings.wire = wire;
  settings.select = variant.soft_select ? sim::SelectKind::kSoft : sim::SelectKind::kHard;
  settings.ready_high = variant.ready_high;
  settings.seed = variant.seed;
  settings.boards = variant.boards;
  return RobotMachine{nullptr, std::make_unique<sim::StepperArm>(robot, settings, boot)};
}

std::expected<RobotMachine, std::string> registers_machine(const RobotModel& robot,
                                                           const MachineVariant& variant,
                                                           Instant boot) {
  using enum sim::AxisWire;
  const auto wire = variant.profile == "as-committed" ? kRegistersAsCommitted
                    : variant.profile == "as-built"   ? kRegistersAsBuilt
                                                      : kRegisters;
  return stepper_arm(robot, variant, boot, wire);
}

std::expected<RobotMachine, std::string> link_machine(const RobotModel& robot,
                                                      const MachineVariant& variant, Instant boot) {
  return stepper_arm(robot, variant, boot, sim::AxisWire::kLink);
}

std::unique_ptr<WireReader> registers_listener(const Device& device, const DeviceFacts& /*facts*/) {
  return wires::axis_registers_reader(device.settings.get<AxisRegistersDevice>());
}

std::unique_ptr<WireReader> link_listener(const Device& /*device*/, const DeviceFacts& /*facts*/) {
  return wires::axis_link_reader();
}

/// Why a board is out, or that it is not.
template <class AxisDriver>
void state_axes(const Driver& driver, const RobotModel& robot, DeviceStatements& statements) {
  for (std::size_t j = 0; j < robot.joints.size(); ++j) {
    const auto fault = driver_as<AxisDriver>(driver).axis_fault(j);
    statements.say("axis", fault ? sentence_of(*fault, robot) : "fine", j);
  }
}

void state_link(const Driver& driver, const RobotModel& robot, DeviceStatements& statements) {
  state_axes<AxisLinkDriver>(driver, robot, statements);
  for (std::size_t j = 0; j < robot.joints.size(); ++j) {
    const auto health = driver_as<AxisLinkDriver>(driver).axis_health(j);
    if (!health) continue;
    statements.say("motor_magnet", std::string(magnet_word(health->motor_magnet)), j);
    statements.say("joint_magnet", std::string(magnet_word(health->joint_magnet)), j);
  }
  statements.say("shows_zero_shift", "yes");
  for (std::size_t j = 0; j < robot.joints.size(); ++j) {
    const auto shift = driver_as<AxisLinkDriver>(driver).zero_shift(j);
    if (!shift) continue;
    const double steps = *shift * axis_settings(robot, j).steps_per_rad();
    statements.say("zero_shift_steps", fmt::format("{:.3f}", steps), j);
    statements.say("zero_shift_deg", fmt::format("{:.3f}", to_deg(*shift)), j);
  }
}

/// The boards that are silent while others answer, for people; empty where there are none.
template <class BoardDriver>
std::string silent_boards(const BoardDriver& driver) {
  std::string names;
  std::size_t silent = 0;
  const std::size_t joints = driver.positions().size();
  for (std::size_t i = 0; i < joints; ++i) {
    const auto fault = driver.axis_fault(i);
    if (!fault || fault->code != ErrorCode::kDeviceSilent) continue;
    names += (silent++ == 0 ? "J" : ", J") + std::to_string(i + 1);
  }
  if (silent == 0 || silent == joints) return {};
  const std::string many = std::to_string(silent) + " of " + std::to_string(joints) + " boards";
  std::string list = "[";
  for (std::size_t i = 0; i < joints; ++i) {
    const auto fault = driver.axis_fault(i);
    if (!fault || fault->code != ErrorCode::kDeviceSilent) continue;
    list += (list.size() > 1 ? ", \"J" : "\"J") + std::to_string(i + 1) + "\"";
  }
  std::string option = names;
  std::erase(option, ' ');
  return many + (silent == 1 ? " does" : " do") + " not answer: " + names +
         "; to use the others: --without " + option +
         " of run, commission, doctor or device, in a cell's file without = " + list + "]";
}

std::string registers_suspicion(const Driver& driver) {
  const auto& boards = driver_as<AxisRegistersDriver>(driver);
  if (const std::string silent = silent_boards(boards); !silent.empty()) return silent;
  if (!boards.statuses_are_blank()) return {};
  return "the status of every board reads zero: looks like boards with the first firmware; "
         "try --profile as-built";
}

/// A board that is another axis, of another robot, or none yet: it answers, and not as it should.
std::string link_suspicion(const Driver& driver) {
  const auto& boards = driver_as<AxisLinkDriver>(driver);
  for (std::size_t i = 0; i < boards.positions().size(); ++i) {
    const auto fault = boards.axis_fault(i);
    const bool other = fault && (fault->code == ErrorCode::kModelMismatch ||
                                 fault->code == ErrorCode::kUnexpectedReply);
    if (other) {
      return "the board of J" + std::to_string(i + 1) +
             " is set up for another axis or robot, or for none: sinew device ROBOT setup --port "
             "DEVICE writes what this robot's file says into all of them";
    }
  }
  for (std::size_t i = 0; i < boards.positions().size(); ++i) {
    const axis_link::Health health = boards.axis_health(i).value_or(axis_link::Health{});
    for (const auto& [magnet, shaft] :
         {std::pair(health.motor_magnet, "motor"), std::pair(health.joint_magnet, "joint")}) {
      if (!needs_attention(magnet)) continue;
      return fmt::format("J{}: magnet on the {}'s shaft: {}{}", i + 1, shaft, magnet_word(magnet),
                         magnet == Magnet::kNoReply
                             ? "; check the cable of its AS5600"
                             : "; it sits centred, 0.5 to 3 mm above the chip");
    }
  }
  return silent_boards(boards);
}

}  // namespace

extern const DeviceKind kAxisRegistersKind;
const DeviceKind kAxisRegistersKind{
    .table = {.protocol = "axis_registers", .segment_ms_max = 1000},
    .read = read_axis_registers,
    .check = check_axis_boards,
    .has = has_settings<AxisRegistersDevice>,
    .driver = registers_driver,
    .machine = registers_machine,
    .listener = registers_listener,
    .view = axis_registers_view,
    .search = axis_search,
    .state = state_axes<AxisRegistersDriver>,
    .suspicion = registers_suspicion,
};

extern const DeviceKind kAxisLinkKind;
const DeviceKind kAxisLinkKind{
    .table = {.protocol = "axis_link", .segment_ms_max = 100},
    .read = read_axis_link,
    .check = check_axis_boards,
    .has = has_settings<AxisLinkDevice>,
    .driver = link_driver,
    .machine = link_machine,
    .listener = link_listener,
    .view = axis_link_view,
    .search = axis_search,
    .state = state_link,
    .suspicion = link_suspicion,
};

}  // namespace sinew
