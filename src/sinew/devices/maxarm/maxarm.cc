#include "sinew/devices/kind.h"
#include "sinew/devices/maxarm/maxarm_driver.h"
#include "sinew/devices/maxarm/maxarm_file.h"
#include "sinew/devices/maxarm/maxarm_listener.h"
#include "sinew/devices/maxarm/maxarm_machine.h"
#include "sinew/devices/maxarm/maxarm_view.h"

namespace sinew {
namespace {

RobotDriver driver(const RobotModel& robot, double patience) {
  MaxArmTiming timing;
  timing.reply_timeout = stretched(timing.reply_timeout, patience);
  timing.patience = stretched(timing.patience, patience);
  return {std::make_unique<MaxArmDriver>(robot.device.settings.get<MaxArmDevice>(), robot.joints,
                                         timing),
          nullptr};
}

std::expected<RobotMachine, std::string> machine(const RobotModel& robot,
                                                 const MachineVariant& variant, Instant boot) {
  if (!std::holds_alternative<PalletizerGeometry>(robot.geometry)) {
    return simulated_for(robot, "a palletizer");
  }
  const auto& device = robot.device.settings.get<MaxArmDevice>();
  return RobotMachine{std::make_unique<sim::MaxArmMachine>(robot, device.checksum, device.variant,
                                                           variant.seed, boot),
                      nullptr};
}

std::unique_ptr<WireReader> listener(const Device& /*device*/, const DeviceFacts& /*facts*/) {
  return wires::maxarm_reader();
}

void state(const Driver& driver, const RobotModel& /*robot*/, DeviceStatements& statements) {
  const auto sum = driver_as<MaxArmDriver>(driver).checksum();
  if (!sum) return;
  statements.say("checksum",
                 *sum == maxarm::Checksum::kSpec ? "as the document says" : "with the header");
}

std::string silence_hint(const RobotModel& robot, const Error& /*trouble*/,
                         const DriverHealth& health) {
  return common_silence_hint(
      robot, health,
      " The arm's stock firmware does not speak this wire: the vendor's slave program has to be "
      "installed. Its MicroPython program sleeps and homes for 14 s after it was switched on "
      "(--profile micropython waits for that)");
}

}  // namespace

extern const DeviceKind kMaxArmKind;
const DeviceKind kMaxArmKind{
    .table = {.protocol = "maxarm",
              .serial_port = true,
              .joints = maxarm::kServos,
              .segment_ms_max = 1000,
              .hand = HandDrive::kSuction},
    .read = read_maxarm,
    .has = has_settings<MaxArmDevice>,
    .driver = driver,
    .machine = machine,
    .listener = listener,
    .view = maxarm_view,
    .state = state,
    .silence_hint = silence_hint,
};

}  // namespace sinew
