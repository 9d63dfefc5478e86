#include "sinew/devices/bigrobotarm/bigrobotarm_settings.h"

#include <algorithm>

namespace sinew {

std::vector<std::string> BigRobotArmDevice::wires() const {
  std::vector<std::string> names{"byte", "text", "text2026", "probe"};
  std::ptrdiff_t own = 0;
  if (wire == BigRobotArmWire::kText) own = dialect == BigRobotArmDialect::k2026 ? 2 : 1;
  if (probe_wire) own = 3;
  std::rotate(names.begin(), names.begin() + own, names.begin() + own + 1);
  return names;
}

void BigRobotArmDevice::use_wire(const std::string& name, Device& /*device*/) {
  probe_wire = name == "probe";
  wire = name.starts_with("text") ? BigRobotArmWire::kText : BigRobotArmWire::kByte;
  dialect = name == "text2026" ? BigRobotArmDialect::k2026 : BigRobotArmDialect::k2021;
}

bool BigRobotArmDevice::use_setting(const DeviceSetting& setting, Device& /*device*/) {
  if (setting.turns_joint()) joints[*setting.joint].steps_per_rad *= -1;
  return setting.turns_joint();
}

}  // namespace sinew
