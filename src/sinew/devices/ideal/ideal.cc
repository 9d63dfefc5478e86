#include "sinew/devices/ideal/ideal_driver.h"
#include "sinew/devices/ideal/ideal_file.h"
#include "sinew/devices/ideal/ideal_listener.h"
#include "sinew/devices/ideal/ideal_machine.h"
#include "sinew/devices/kind.h"

namespace sinew {
namespace {

RobotDriver driver(const RobotModel& robot, double patience) {
  IdealTiming timing;
  timing.reply_timeout = stretched(timing.reply_timeout, patience);
  const auto* geometry = std::get_if<SerialGeometry>(&robot.geometry);
  return {std::make_unique<IdealDriver>(robot.joints,
                                        geometry != nullptr ? geometry->gripper : std::nullopt,
                                        robot.device.baud, timing),
          nullptr};
}

std::expected<RobotMachine, std::string> machine(const RobotModel& robot,
                                                 const MachineVariant& /*variant*/, Instant boot) {
  return RobotMachine{std::make_unique<sim::IdealMachine>(robot, boot), nullptr};
}

std::unique_ptr<WireReader> listener(const Device& /*device*/, const DeviceFacts& /*facts*/) {
  return wires::ideal_reader();
}

}  // namespace

extern const DeviceKind kIdealKind;
const DeviceKind kIdealKind{
    .table = {.protocol = "ideal", .capability_in_file = false},
    .read = read_ideal,
    .has = has_settings<IdealDevice>,
    .driver = driver,
    .machine = machine,
    .listener = listener,
};

}  // namespace sinew
