#include "sinew/devices/feetech/feetech_settings.h"

#include <fmt/format.h>

#include <algorithm>

#include "sinew/model/hand.h"

namespace sinew {
Duration FeetechDevice::tool_time(const RobotModel& robot, const ToolAction& action,
                                  std::optional<double> jaws) const {
  const auto* to = std::get_if<JawsTo>(&action);
  const JawGripper* hand = jaws_of(robot);
  if (to == nullptr || hand == nullptr) return {};
  const double share = jaws_share(*hand, to->width, jaws);
  return from_seconds(share * to_seconds(kJawsStroke)) + motion_delay().report;
}

/// The other series counts the same angles in units of its own, from its own middle.
void FeetechDevice::use_profile(const std::string& name, Device& /*device*/) {
  const auto wanted = name == "scs" ? FeetechSeries::kScs : FeetechSeries::kSts;
  if (wanted == series) return;
  const double before = units_per_rad();
  const double middle = (units_max() + 1) / 2;
  series = wanted;
  const auto turned = [&](double units) {
    return (units_max() + 1) / 2 + (units - middle) * units_per_rad() / before;
  };
  for (Servo& servo : servos) {
    servo.centre = turned(servo.centre);
    servo.torque_limit = 1;
  }
  gripper.open = std::clamp(turned(gripper.open), 0.0, units_max());
  gripper.closed = std::clamp(turned(gripper.closed), 0.0, units_max());
}

bool FeetechDevice::use_setting(const DeviceSetting& setting, Device& /*device*/) {
  const auto& number = setting.number;
  if (!setting.joint) {
    if (setting.what != "jaws_turn" || setting.value != "other") return false;
    std::swap(gripper.open, gripper.closed);
    return true;
  }
  Servo& servo = servos[*setting.joint];
  if (setting.turns_joint()) {
    servo.sign *= -1;
  } else if (setting.what == "trim_rad" && number && std::abs(*number) <= trim_max()) {
    servo.centre = units_of(*setting.joint, *number);
  } else if (setting.what == "servo_id" && number && *number >= 0 && *number <= kIdMax) {
    servo.id = static_cast<std::uint8_t>(*number);
  } else {
    return false;
  }
  return true;
}

std::string FeetechDevice::contradiction(const RobotModel& robot) const {
  const bool jaws = jaws_of(robot) != nullptr;
  for (std::size_t j = 0; j < servos.size(); ++j) {
    const std::string& name = robot.joints[j].name;
    std::string whose = jaws && servos[j].id == gripper.id ? "the gripper" : "";
    for (std::size_t k = 0; k < j; ++k) {
      if (servos[k].id == servos[j].id) whose = robot.joints[k].name;
    }
    if (!whose.empty()) {
      return fmt::format("servo {} would be {}'s and {}'s", servos[j].id, name, whose);
    }
    const auto [low, high] =
        std::minmax({units_of(j, robot.joints[j].lower), units_of(j, robot.joints[j].upper)});
    if (low < 0 || high > units_max()) {
      return fmt::format(
          "the range of {} would be {:.0f} to {:.0f} of its servo, which counts 0 to {:.0f}", name,
          low, high, units_max());
    }
  }
  return {};
}

}  // namespace sinew
