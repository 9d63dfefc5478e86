#include <fmt/format.h>

#include "sinew/devices/icp/icp_driver.h"
#include "sinew/devices/icp/icp_file.h"
#include "sinew/devices/icp/icp_listener.h"
#include "sinew/devices/icp/icp_machine.h"
#include "sinew/devices/icp/icp_view.h"
#include "sinew/devices/kind.h"

namespace sinew {
namespace {

RobotDriver driver(const RobotModel& robot, double patience) {
  auto device = robot.device.settings.get<IcpDevice>();
  device.reply_timeout = stretched(device.reply_timeout, patience);
  return {std::make_unique<IcpDriver>(device, robot.joints), nullptr};
}

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

std::expected<RobotMachine, std::string> machine(const RobotModel& robot,
                                                 const MachineVariant& variant, Instant boot) {
  if (!std::holds_alternative<HexapodGeometry>(robot.geometry)) {
    return simulated_for(robot, "a hexapod");
  }
  const auto quirks = quirks_of(robot.device.settings.get<IcpDevice>().firmware);
  return RobotMachine{std::make_unique<sim::IcpMachine>(robot, quirks, variant.seed, boot),
                      nullptr};
}

std::unique_ptr<WireReader> listener(const Device& device, const DeviceFacts& /*facts*/) {
  return wires::icp_reader(device.settings.get<IcpDevice>());
}

/// What a module's last step down left in its target position.
void state(const Driver& driver, const RobotModel& /*robot*/, DeviceStatements& statements) {
  for (std::size_t leg = 0; leg < kLegs; ++leg) {
    const auto& status = driver_as<IcpDriver>(driver).status(leg);
    if (!status || status->two.target >= 0) continue;
    const auto target = static_cast<std::uint16_t>(status->two.target);
    return statements.say("minus_one", fmt::format("{:04X}", target));
  }
}

std::string silence_hint(const RobotModel& robot, const Error& /*trouble*/,
                         const DriverHealth& health) {
  return common_silence_hint(
      robot, health,
      " Try once more: on a busy computer a reply may come too late. A controller that was told to "
      "shut down, or was idle for long, replies only after it was switched off and on");
}

}  // namespace

extern const DeviceKind kIcpKind;
const DeviceKind kIcpKind{
    .table = {.protocol = "icp", .serial_port = true, .joints = kLegs, .segment_ms_max = 1000},
    .read = read_icp,
    .has = has_settings<IcpDevice>,
    .driver = driver,
    .machine = machine,
    .listener = listener,
    .view = icp_view,
    .state = state,
    .silence_hint = silence_hint,
};

}  // namespace sinew
