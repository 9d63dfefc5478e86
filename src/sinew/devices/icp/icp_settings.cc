#include "sinew/devices/icp/icp_settings.h"

#include "sinew/model/device.h"

namespace sinew {

/// What a profile names comes on top of what the robot's file says.
void IcpDevice::use_profile(const std::string& name, Device& /*device*/) {
  if (name == "section4") firmware.knows_wake = false;
  if (name == "slow") firmware.processing = std::chrono::milliseconds(5);
  if (name == "idle-shutdown") firmware.idle_shutdown = std::chrono::minutes(10);
  if (name != "fffe") return;
  firmware.minus_one_is_fffe = true;
  units_per_down = 2;
}

bool IcpDevice::use_setting(const DeviceSetting& setting, Device& device) {
  constexpr double kFactorMax = 20;
  const auto& number = setting.number;
  if (setting.turns_joint()) {
    legs[*setting.joint].invert = !legs[*setting.joint].invert;
    return true;
  }
  if (setting.joint || !number) return false;
  if (setting.what == "units_per_down" && (*number == 1 || *number == 2)) {
    units_per_down = *number;
    return true;
  }
  if (setting.what == "way_factor" && *number >= 1 / kFactorMax && *number <= kFactorMax) {
    units_per_m /= *number;
    device.capability.shared_velocity *= *number;
    return true;
  }
  return false;
}

}  // namespace sinew
