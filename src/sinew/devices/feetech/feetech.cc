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

/// Number, model, firmware, volts and heat of each joint's servo.
void state(const Driver& driver, const RobotModel& robot, DeviceStatements& statements) {
  const DeviceFacts facts = driver.facts();
  const auto* servos = facts.as<FeetechFacts>();
  for (std::size_t j = 0; servos != nullptr && j < robot.joints.size(); ++j) {
    const FeetechServoState& servo = servos->servos[j];
    if (!servo.known) continue;
    statements.say(
        "servo",
        fmt::format("number {}, model {}, firmware {}.{}, {:.1f} V, {} deg C",
                    robot.device.settings.get<FeetechDevice>().servos[j].id, servo.model,
                    servo.firmware >> 8, servo.firmware & 0xFF, servo.volts / 10.0, servo.heat),
        j);
  }
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
    .state = state,
    .silence_hint = silence_hint,
};

}  // namespace sinew
