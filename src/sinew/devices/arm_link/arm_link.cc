#include <fmt/format.h>

#include "sinew/devices/arm_link/arm_link_driver.h"
#include "sinew/devices/arm_link/arm_link_file.h"
#include "sinew/devices/arm_link/arm_link_listener.h"
#include "sinew/devices/arm_link/arm_link_view.h"
#include "sinew/devices/bigrobotarm/bigrobotarm_machine.h"
#include "sinew/devices/kind.h"

namespace sinew {
namespace {

RobotDriver driver(const RobotModel& robot, double patience) {
  ArmLinkTiming timing;
  for (Duration* each : {&timing.wire.reply, &timing.wire.hello, &timing.opening_limit}) {
    *each = stretched(*each, patience);
  }
  return {std::make_unique<ArmLinkDriver>(robot.device.settings.get<ArmLinkDevice>(), robot.joints,
                                          timing),
          nullptr};
}

std::expected<RobotMachine, std::string> machine(const RobotModel& robot,
                                                 const MachineVariant& variant, Instant boot) {
  if (!std::holds_alternative<SerialGeometry>(robot.geometry)) {
    return simulated_for(robot, "a serial chain");
  }
  RobotModel arm = robot;
  arm.device.settings = robot.device.settings.get<ArmLinkDevice>().arm;
  return RobotMachine{
      std::make_unique<sim::BigRobotArmMachine>(arm, BigRobotArmProfile::kOwn,
                                                BigRobotArmDialect::k2026, variant.seed, boot),
      nullptr};
}

std::unique_ptr<WireReader> listener(const Device& /*device*/, const DeviceFacts& /*facts*/) {
  return wires::arm_link_reader();
}

std::optional<BoardImage> image_of(const DeviceFacts& facts) {
  const auto& image = facts.get<ArmLinkFacts>().image;
  return image ? std::optional(image->what) : std::nullopt;
}

void state(const Driver& driver, const RobotModel& /*robot*/, DeviceStatements& statements) {
  const auto image = image_of(driver.facts());
  statements.say(
      "wire",
      image ? fmt::format("framed, {} {}", image->board_name(), image->version_text()) : "framed");
}

std::string silence_hint(const RobotModel& robot, const Error& /*trouble*/,
                         const DriverHealth& health) {
  return common_silence_hint(robot, health,
                             " Does it run Sinew's firmware (docs/firmware/bigrobotarm.md)? The "
                             "maker's is spoken to with --wire byte, text or text2026");
}

}  // namespace

extern const DeviceKind kArmLinkKind;
const DeviceKind kArmLinkKind{
    .table = {.protocol = "arm_link",
              .serial_port = true,
              .joints = kBigRobotArmJoints,
              .segment_ms_min = 10,
              .segment_ms_max = 1000,
              .hand = HandDrive::kServo},
    .read = read_arm_link,
    .has = has_settings<ArmLinkDevice>,
    .driver = driver,
    .machine = machine,
    .listener = listener,
    .view = arm_link_view,
    .image = image_of,
    .state = state,
    .silence_hint = silence_hint,
};

}  // namespace sinew
