#include "sinew/devices/bigrobotarm/bigrobotarm_driver.h"
#include "sinew/devices/bigrobotarm/bigrobotarm_file.h"
#include "sinew/devices/bigrobotarm/bigrobotarm_listener.h"
#include "sinew/devices/bigrobotarm/bigrobotarm_machine.h"
#include "sinew/devices/bigrobotarm/bigrobotarm_view.h"
#include "sinew/devices/kind.h"

namespace sinew {
namespace {

RobotDriver driver(const RobotModel& robot, double patience) {
  BigRobotArmTiming timing;
  for (Duration* each : {&timing.wire.reply_timeout, &timing.wire.move_margin,
                         &timing.wire.quiet_limit, &timing.opening_limit}) {
    *each = stretched(*each, patience);
  }
  return {std::make_unique<BigRobotArmDriver>(robot.device.settings.get<BigRobotArmDevice>(),
                                              robot.joints, timing),
          nullptr};
}

std::expected<RobotMachine, std::string> machine(const RobotModel& robot,
                                                 const MachineVariant& variant, Instant boot) {
  if (!std::holds_alternative<SerialGeometry>(robot.geometry)) {
    return simulated_for(robot, "a serial chain");
  }
  const auto profile = variant.profile == "as-built" ? BigRobotArmProfile::kAsBuilt
                       : variant.profile == "sinew"  ? BigRobotArmProfile::kOwn
                                                     : BigRobotArmProfile::kDocument;
  const auto dialect = robot.device.settings.get<BigRobotArmDevice>().dialect;
  return RobotMachine{
      std::make_unique<sim::BigRobotArmMachine>(robot, profile, dialect, variant.seed, boot),
      nullptr};
}

std::unique_ptr<WireReader> listener(const Device& device, const DeviceFacts& facts) {
  const auto* found = facts.as<BigRobotArmFacts>();
  return wires::bigrobotarm_reader(
      found != nullptr ? found->wire : device.settings.get<BigRobotArmDevice>().wire);
}

void state(const Driver& driver, const RobotModel& /*robot*/, DeviceStatements& statements) {
  const BigRobotArmFound found = driver_as<BigRobotArmDriver>(driver).wire();
  const char* text = found.dialect == BigRobotArmDialect::k2026 ? "text2026" : "text";
  statements.say("wire", found.wire == BigRobotArmWire::kByte ? "byte" : text);
}

std::string silence_hint(const RobotModel& robot, const Error& /*trouble*/,
                         const DriverHealth& health) {
  const std::string own = " Does it run Sinew's firmware (--wire framed)?";
  if (robot.device.settings.get<BigRobotArmDevice>().probe_wire) {
    return common_silence_hint(robot, health, own, own);
  }
  return common_silence_hint(robot, health,
                             " Does it speak this wire (--wire probe finds out)?" + own,
                             " Or does it speak another wire (--wire probe finds out)?");
}

}  // namespace

extern const DeviceKind kBigRobotArmKind;
const DeviceKind kBigRobotArmKind{
    .table = {.protocol = "bigrobotarm",
              .serial_port = true,
              .joints = kBigRobotArmJoints,
              .segment_ms_max = 1000,
              .hand = HandDrive::kServo},
    .read = read_bigrobotarm,
    .has = has_settings<BigRobotArmDevice>,
    .driver = driver,
    .machine = machine,
    .listener = listener,
    .view = bigrobotarm_view,
    .state = state,
    .silence_hint = silence_hint,
};

}  // namespace sinew
