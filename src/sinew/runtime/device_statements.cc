#include "sinew/runtime/device_statements.h"

#include <fmt/format.h>

#include "sinew/core/units.h"
#include "sinew/device/axis_settings.h"
#include "sinew/devices/bigrobotarm/bigrobotarm_settings.h"
#include "sinew/driver/axis_link.h"
#include "sinew/driver/axis_registers.h"
#include "sinew/driver/bigrobotarm.h"
#include "sinew/driver/icp.h"
#include "sinew/driver/maxarm.h"
#include "sinew/model/error_sentence.h"

namespace sinew::runtime {
namespace {

/// What a module's last step down left in its target position.
std::optional<std::string> minus_one(const IcpDriver& driver) {
  for (std::size_t leg = 0; leg < kLegs; ++leg) {
    const auto& status = driver.status(leg);
    if (!status || status->two.target >= 0) continue;
    return fmt::format("{:04X}", static_cast<std::uint16_t>(status->two.target));
  }
  return std::nullopt;
}

template <class AxisDriver>
std::string axis_text(const AxisDriver& driver, std::size_t joint, const RobotModel& robot) {
  const auto fault = driver.axis_fault(joint);
  return fault ? sentence_of(*fault, robot) : "fine";
}

}  // namespace

program::DeviceFact facts_of(const Driver& driver, const RobotModel& robot) {
  return [&driver, &robot](std::string_view what, std::size_t joint) -> std::optional<std::string> {
    if (what == "supply") {
      const auto volts = driver.health().supply_volts;
      return volts ? std::optional(fmt::format("{:.1f}", *volts)) : std::nullopt;
    }
    if (const auto* icp = dynamic_cast<const IcpDriver*>(&driver); icp && what == "minus_one") {
      return minus_one(*icp);
    }
    if (const auto* arm = dynamic_cast<const BigRobotArmDriver*>(&driver); arm && what == "wire") {
      const BigRobotArmFound found = arm->wire();
      if (found.wire == BigRobotArmWire::kByte) return "byte";
      return found.dialect == BigRobotArmDialect::k2026 ? "text2026" : "text";
    }
    if (const auto* arm = dynamic_cast<const MaxArmDriver*>(&driver); arm && what == "checksum") {
      const auto sum = arm->checksum();
      if (!sum) return std::nullopt;
      return *sum == maxarm::Checksum::kSpec ? "as the document says" : "with the header";
    }
    if (const auto* link = dynamic_cast<const AxisLinkDriver*>(&driver);
        link && (what == "zero_shift_steps" || what == "zero_shift_deg")) {
      const auto shift = link->zero_shift(joint);
      if (!shift) return std::nullopt;
      const bool steps = what == "zero_shift_steps";
      return fmt::format(
          "{:.3f}", steps ? *shift * axis_settings(robot, joint).steps_per_rad() : to_deg(*shift));
    }
    if (what == "axis") {
      if (const auto* boards = dynamic_cast<const AxisRegistersDriver*>(&driver)) {
        return axis_text(*boards, joint, robot);
      }
      if (const auto* link = dynamic_cast<const AxisLinkDriver*>(&driver)) {
        return axis_text(*link, joint, robot);
      }
    }
    return std::nullopt;
  };
}

}  // namespace sinew::runtime
