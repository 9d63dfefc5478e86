#include "sinew/runtime/robot_machine.h"

#include "sinew/devices/device_kinds.h"
#include "sinew/devices/ideal/ideal_machine.h"
#include "sinew/runtime/simulated_table.h"
#include "sinew/sim/bigrobotarm_machine.h"
#include "sinew/sim/icp_machine.h"
#include "sinew/sim/lsc_machine.h"
#include "sinew/sim/maxarm_machine.h"
#include "sinew/sim/stepper_arm.h"

namespace sinew::runtime {
namespace {

IcpQuirks quirks_of(const IcpFirmware& firmware) {
  IcpQuirks quirks;
  quirks.dialect = {.knows_wake = firmware.knows_wake, .checks_selector = firmware.checks_selector};
  quirks.bit_one_is_plus = firmware.bit_one_is_plus;
  if (firmware.minus_one_is_fffe) quirks.minus_one = -2;
  quirks.silent_without_motor = firmware.silent_without_motor;
  quirks.ack_without_module = firmware.ack_without_module;
  quirks.processing = firmware.processing;
  quirks.boot = firmware.boot;
  if (firmware.idle_shutdown > Duration::zero()) quirks.idle_shutdown = firmware.idle_shutdown;
  return quirks;
}

/// Picks the machine that belongs to the settings.
class MachineMaker {
 public:
  MachineMaker(const RobotModel& robot, const MachineOptions& options, Instant boot)
      : robot_(robot), options_(options), boot_(boot) {}

  RobotMachine operator()(const IdealDevice& /*device*/) const {
    return {std::make_unique<sim::IdealMachine>(robot_, boot_), nullptr};
  }
  RobotMachine operator()(const BigRobotArmDevice& device) const {
    const auto profile = options_.profile == "as-built" ? BigRobotArmProfile::kAsBuilt
                                                        : BigRobotArmProfile::kDocument;
    return {std::make_unique<sim::BigRobotArmMachine>(robot_, profile, device.dialect,
                                                      options_.seed, boot_),
            nullptr};
  }
  RobotMachine operator()(const LscDevice& device) const {
    return {std::make_unique<sim::LscMachine>(robot_, device.profile, options_.seed, boot_),
            nullptr};
  }
  RobotMachine operator()(const MaxArmDevice& device) const {
    return {std::make_unique<sim::MaxArmMachine>(robot_, device.checksum, device.variant,
                                                 options_.seed, boot_),
            nullptr};
  }
  RobotMachine operator()(const IcpDevice& device) const {
    return {
        std::make_unique<sim::IcpMachine>(robot_, quirks_of(device.firmware), options_.seed, boot_),
        nullptr};
  }
  RobotMachine operator()(const AxisRegistersDevice& /*device*/) const {
    if (options_.profile == "as-committed") {
      return stepper_arm(sim::AxisWire::kRegistersAsCommitted);
    }
    return stepper_arm(options_.profile == "as-built" ? sim::AxisWire::kRegistersAsBuilt
                                                      : sim::AxisWire::kRegisters);
  }
  RobotMachine operator()(const AxisLinkDevice& /*device*/) const {
    return stepper_arm(sim::AxisWire::kLink);
  }

 private:
  RobotMachine stepper_arm(sim::AxisWire wire) const {
    sim::StepperArm::Settings settings;
    settings.wire = wire;
    settings.select = options_.soft_select ? sim::SelectKind::kSoft : sim::SelectKind::kHard;
    settings.ready_high = options_.ready_high;
    settings.seed = options_.seed;
    settings.boards = options_.boards;
    return {nullptr, std::make_unique<sim::StepperArm>(robot_, settings, boot_)};
  }

  const RobotModel& robot_;
  const MachineOptions& options_;
  Instant boot_;
};

/// Why this robot's device cannot be simulated; empty where it can.
std::string obstacle(const RobotModel& robot) {
  const auto& settings = robot.device.settings;
  if (settings.is<IdealDevice>()) return {};
  const bool serial = std::holds_alternative<SerialGeometry>(robot.geometry);
  const std::string other = robot.id + ": its device is simulated for ";
  if (settings.is<MaxArmDevice>()) {
    return std::holds_alternative<PalletizerGeometry>(robot.geometry) ? ""
                                                                      : other + "a palletizer only";
  }
  if (settings.is<IcpDevice>()) {
    return std::holds_alternative<HexapodGeometry>(robot.geometry) ? "" : other + "a hexapod only";
  }
  if (!serial) return other + "a serial chain only";
  const bool boards = settings.is<AxisRegistersDevice>() || settings.is<AxisLinkDevice>();
  const std::size_t joints = robot.joints.size();
  if (boards && (robot.dynamics.drives.size() != joints || robot.dynamics.links.size() != joints)) {
    return robot.id +
           ": to simulate it, its file needs a table [drive.<joint>] and a table "
           "[link.<joint>] for every joint";
  }
  return {};
}

}  // namespace

std::expected<RobotMachine, std::string> make_machine(const RobotModel& robot,
                                                      const MachineOptions& options, Instant boot) {
  if (std::string why = obstacle(robot); !why.empty()) return std::unexpected(std::move(why));
  auto machine = visit_kind(MachineMaker{robot, options, boot}, robot.device.settings);
  if (machine.byte && options.table != nullptr) {
    machine.byte = options.table->under(std::move(machine.byte), robot, options.place, boot);
  }
  return machine;
}

}  // namespace sinew::runtime
