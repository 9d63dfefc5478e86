#include "sinew/runtime/device_statements.h"

#include <fmt/format.h>

#include "sinew/devices/kinds.h"

namespace sinew::runtime {

program::DeviceFact facts_of(const Driver& driver, const RobotModel& robot) {
  const DeviceKind& kind = kind_of(robot.device);
  return [&driver, &robot, &kind](std::string_view what,
                                  std::size_t joint) -> std::optional<std::string> {
    if (what == "supply") {
      const auto volts = driver.health().supply_volts;
      return volts ? std::optional(fmt::format("{:.1f}", *volts)) : std::nullopt;
    }
    return kind.statement != nullptr ? kind.statement(driver, robot, what, joint) : std::nullopt;
  };
}

}  // namespace sinew::runtime
