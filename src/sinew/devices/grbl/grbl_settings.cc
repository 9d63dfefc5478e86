#include "sinew/devices/grbl/grbl_settings.h"

#include <algorithm>

namespace sinew {

void GrblDevice::use_profile(const std::string& name, Device& /*device*/) {
  const auto* const found = std::ranges::find(kGrblFirmwares, name);
  if (found == kGrblFirmwares.end()) return;
  firmware = static_cast<GrblFirmware>(found - kGrblFirmwares.begin());
}

bool GrblDevice::use_setting(const DeviceSetting& setting, Device& /*device*/) {
  if (!setting.turns_joint()) return false;
  axes[*setting.joint].steps_per_unit *= -1;
  return true;
}

}  // namespace sinew
