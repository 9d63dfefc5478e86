#include "sinew/devices/bigrobotarm/bigrobotarm_settings.h"

#include <algorithm>

#include "sinew/devices/arm_link/arm_link_settings.h"

namespace sinew {

std::vector<std::string> BigRobotArmDevice::wires() const {
  std::vector<std::string> names{"byte", "text", "text2026", "probe", "framed"};
  std::ptrdiff_t own = 0;
  if (wire == BigRobotArmWire::kText) own = dialect == BigRobotArmDialect::k2026 ? 2 : 1;
  if (probe_wire) own = 3;
  std::rotate(names.begin(), names.begin() + own, names.begin() + own + 1);
  return names;
}

void BigRobotArmDevice::use_wire(const std::string& name, Device& device) {
  if (name == "framed") {
    ArmLinkDevice link;
    link.arm = ArmLinkDevice::of_no_wire(*this);
    device.protocol = "arm_link";
    device.capability = arm_link_capability(device.capability.nudge_max);
    device.settings = link;  // the end of these
    return;
  }
  probe_wire = name == "probe";
  wire = name.starts_with("text") ? BigRobotArmWire::kText : BigRobotArmWire::kByte;
  dialect = name == "text2026" ? BigRobotArmDialect::k2026 : BigRobotArmDialect::k2021;
}

bool BigRobotArmDevice::use_setting(const DeviceSetting& setting, Device& /*device*/) {
  if (setting.turns_joint()) joints[*setting.joint].steps_per_rad *= -1;
  return setting.turns_joint();
}

const BigRobotArmDevice* big_robot_arm_of(const DeviceSettings& settings) {
  if (const auto* link = dynamic_cast<const ArmLinkDevice*>(&settings)) return &link->arm;
  return dynamic_cast<const BigRobotArmDevice*>(&settings);
}

}  // namespace sinew
