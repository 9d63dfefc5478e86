#include "sinew/devices/grbl/grbl_settings.h"

namespace sinew {

void GrblDevice::use_profile(const std::string& name, Device& /*device*/) {
  if (name == "grblhal") firmware = GrblFirmware::kGrblHal;
  if (name == "fluidnc") firmware = GrblFirmware::kFluidNc;
}

bool GrblDevice::use_setting(const DeviceSetting& setting, Device& /*device*/) {
  if (!setting.turns_joint()) return false;
  axes[*setting.joint].steps_per_unit *= -1;
  return true;
}

}  // namespace sinew
