#include "sinew/devices/kinds.h"

#include <fmt/format.h>

#include <algorithm>

#include "sinew/core/assert.h"

namespace sinew {

// One line for each kind, in each of the two lists.
extern const DeviceKind kIdealKind;
extern const DeviceKind kBigRobotArmKind;
extern const DeviceKind kLscKind;
extern const DeviceKind kMaxArmKind;
extern const DeviceKind kIcpKind;
extern const DeviceKind kAxisRegistersKind;
extern const DeviceKind kAxisLinkKind;
extern const DeviceKind kArmLinkKind;
extern const DeviceKind kGrblKind;
extern const DeviceKind kFeetechKind;

std::span<const DeviceKind* const> device_kinds() {
  static constexpr const DeviceKind* kAll[] = {
      &kIdealKind,         &kBigRobotArmKind, &kLscKind,     &kMaxArmKind, &kIcpKind,
      &kAxisRegistersKind, &kAxisLinkKind,    &kArmLinkKind, &kGrblKind,   &kFeetechKind,
  };
  return kAll;
}

const DeviceKind& kind_of(const Device& device) {
  const auto kinds = device_kinds();
  const auto found = std::ranges::find_if(
      kinds, [&](const DeviceKind* kind) { return kind->has(device.settings); });
  SINEW_ASSERT(found != kinds.end());
  return **found;
}

DeviceStatements statements_of(const Driver& driver, const RobotModel& robot) {
  DeviceStatements statements;
  if (const auto volts = driver.health().supply_volts) {
    statements.say("supply", fmt::format("{:.1f}", *volts));
  }
  const DeviceKind& kind = kind_of(robot.device);
  if (kind.state != nullptr) kind.state(driver, robot, statements);
  return statements;
}

}  // namespace sinew
