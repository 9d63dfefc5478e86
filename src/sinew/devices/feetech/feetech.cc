#include <fmt/format.h>

#include "sinew/devices/feetech/feetech_driver.h"
#include "sinew/devices/feetech/feetech_file.h"
#include "sinew/devices/feetech/feetech_listener.h"
#include "sinew/devices/feetech/feetech_machine.h"
#include "sinew/devices/feetech/feetech_view.h"
#include "sinew/devices/kind.h"
#include "sinew/model/hand.h"

namespace sinew {
namespace {

RobotDriver driver(const RobotModel& robot, double patience) {
  FeetechTiming timing;
  timing.bus.baud = robot.device.baud;
  timing.bus.reply_timeout = stretched(timing.bus.reply_timeout, patience);
  const auto& geometry = std::get<SerialGeometry>(robot.geometry);
  const bool jaws = jaws_of(robot) != nullptr;
  return {std::make_unique<FeetechDriver>(robot.device.settings.get<FeetechDevice>(), robot.joints,
                                          jaws ? geometry.gripper : std::nullopt, timing),
          nullptr};
}

std::expected<RobotMachine, std::string> machine(const RobotModel& robot,
                                                 const MachineVariant& variant, Instant boot) {
  return RobotMachine{std::make_unique<sim::FeetechMachine>(robot, variant.seed, boot), nullptr};
}

std::unique_ptr<WireReader> listener(const Device& device, const DeviceFacts& /*facts*/) {
  return wires::feetech_reader(device.settings.get<FeetechDevice>());
}

/// "servo": number, model, firmware, volts and heat of a joint's.
std::optional<std::string> statement(const Driver& driver, const RobotModel& robot,
                                     std::string_view what, std::size_t joint) {
  if (what != "servo" || joint >= robot.joints.size()) return std::nullopt;
  const DeviceFacts facts = driver.facts();
  const auto* servos = facts.as<FeetechFacts>();
  if (servos == nullptr || !servos->servos[joint].known) return std::nullopt;
  const FeetechServoState& servo = servos->servos[joint];
  return fmt::format("number {}, model {}, firmware {}.{}, {:.1f} V, {} deg C",
                     robot.device.settings.get<FeetechDevice>().servos[joint].id, servo.model,
                     servo.firmware >> 8, servo.firmware & 0xFF, servo.volts / 10.0, servo.heat);
}

std::string silence_hint(const RobotModel& robot, const Error& /*trouble*/,
                         const DriverHealth& health) {
  return common_silence_hint(
      robot, health,
      fmt::format(" Do the servos have their own supply, and this baud rate ({})?",
                  robot.device.baud));
}

}  // namespace

extern const DeviceKind kFeetechKind;
const DeviceKind kFeetechKind{
    .table = {.protocol = "feetech",
              .serial_port = true,
              .segment_ms_max = 100,
              .hand = HandDrive::kJaws},
    .read = read_feetech,
    .check = check_feetech,
    .has = has_settings<FeetechDevice>,
    .driver = driver,
    .machine = machine,
    .listener = listener,
    .view = feetech_view,
    .statement = statement,
    .silence_hint = silence_hint,
};

}  // namespace sinew
