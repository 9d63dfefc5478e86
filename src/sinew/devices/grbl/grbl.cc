#include "sinew/devices/grbl/grbl_driver.h"
#include "sinew/devices/grbl/grbl_file.h"
#include "sinew/devices/grbl/grbl_listener.h"
#include "sinew/devices/grbl/grbl_machine.h"
#include "sinew/devices/grbl/grbl_view.h"
#include "sinew/devices/kind.h"

namespace sinew {
namespace {

RobotDriver driver(const RobotModel& robot, double patience) {
  GrblTiming timing;
  timing.segment = robot.device.capability.segment;
  timing.reply_timeout = stretched(timing.reply_timeout, patience);
  timing.welcome_timeout = stretched(timing.welcome_timeout, patience);
  return {std::make_unique<GrblDriver>(robot.device.settings.get<GrblDevice>(), robot.joints,
                                       robot.device.baud, timing),
          nullptr};
}

std::expected<RobotMachine, std::string> machine(const RobotModel& robot,
                                                 const MachineVariant& /*variant*/, Instant boot) {
  return RobotMachine{std::make_unique<sim::GrblMachine>(robot, boot), nullptr};
}

std::unique_ptr<WireReader> listener(const Device& /*device*/, const DeviceFacts& /*facts*/) {
  return wires::grbl_reader();
}

std::string silence_hint(const RobotModel& robot, const Error& /*trouble*/,
                         const DriverHealth& health) {
  return common_silence_hint(robot, health, " (baud " + std::to_string(robot.device.baud) + ")");
}

}  // namespace

extern const DeviceKind kGrblKind;
const DeviceKind kGrblKind{
    .table = {.protocol = "grbl", .serial_port = true, .slides = true, .segment_ms_max = 200},
    .read = read_grbl,
    .has = has_settings<GrblDevice>,
    .driver = driver,
    .machine = machine,
    .listener = listener,
    .view = grbl_view,
    .silence_hint = silence_hint,
};

}  // namespace sinew
