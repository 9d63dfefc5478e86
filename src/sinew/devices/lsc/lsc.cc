#include <fmt/format.h>

#include "sinew/core/error_code.h"
#include "sinew/devices/kind.h"
#include "sinew/devices/lsc/lsc_driver.h"
#include "sinew/devices/lsc/lsc_driver_facts.h"
#include "sinew/devices/lsc/lsc_file.h"
#include "sinew/devices/lsc/lsc_listener.h"
#include "sinew/devices/lsc/lsc_machine.h"
#include "sinew/devices/lsc/lsc_view.h"

namespace sinew {
namespace {

RobotDriver driver(const RobotModel& robot, double patience) {
  LscTiming timing;
  for (Duration* each : {&timing.reply_timeout, &timing.output_timeout, &timing.lead}) {
    *each = stretched(*each, patience);
  }
  const auto& geometry = std::get<SerialGeometry>(robot.geometry);
  return {std::make_unique<LscDriver>(robot.device.settings.get<LscDevice>(), robot.joints,
                                      geometry.gripper, timing),
          nullptr};
}

std::expected<RobotMachine, std::string> machine(const RobotModel& robot,
                                                 const MachineVariant& variant, Instant boot) {
  if (!std::holds_alternative<SerialGeometry>(robot.geometry)) {
    return simulated_for(robot, "a serial chain");
  }
  const auto profile = robot.device.settings.get<LscDevice>().profile;
  return RobotMachine{std::make_unique<sim::LscMachine>(robot, profile, variant.seed, boot),
                      nullptr};
}

std::unique_ptr<WireReader> listener(const Device& device, const DeviceFacts& /*facts*/) {
  return wires::lsc_reader(device.settings.get<LscDevice>());
}

/// Classic boards report no version: then it is what the robot's settings say.
void state(const Driver& driver, const RobotModel& robot, DeviceStatements& statements) {
  const DeviceFacts all = driver.facts();
  const auto& facts = all.get<LscFacts>();
  std::string words = robot.device.settings.get<LscDevice>().profiles().front();
  if (facts.version) {
    words += fmt::format(", type {}, version {} by its own report", facts.version->what.type,
                         facts.version->what.version);
  } else {
    words += ", as the settings say: it reports no version";
  }
  statements.say("board", std::move(words));
}

/// No kind of LSC board answers all the questions of another one.
std::string silence_hint(const RobotModel& robot, const Error& trouble,
                         const DriverHealth& health) {
  const auto profile = robot.device.settings.get<LscDevice>().profile;
  if (trouble.code == ErrorCode::kOtherBoard) {
    return "; only one with servos on a bus does so: name it with --profile bus";
  }
  if (profile == LscProfile::kBus && health.supply_volts) {
    return "; it tells its supply and nothing else, as a classic board does: try --profile lsc6";
  }
  const std::string where = health.unexpected > 0
                                ? "; something answers there, but not as this board does. Is it"
                                : "; is it switched on, and is this its port? Or is it";
  return where + " another kind of board (--profile lsc6, bus or esp32)?";
}

}  // namespace

extern const DeviceKind kLscKind;
const DeviceKind kLscKind{
    .table = {.protocol = "lsc",
              .serial_port = true,
              .segment_ms_max = 100,
              .hand = HandDrive::kJaws},
    .read = read_lsc,
    .has = has_settings<LscDevice>,
    .driver = driver,
    .machine = machine,
    .listener = listener,
    .view = lsc_view,
    .state = state,
    .silence_hint = silence_hint,
};

}  // namespace sinew
