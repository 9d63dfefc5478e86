#include "sinew/model/device_settings.h"

#include "sinew/model/device.h"

namespace sinew {

void DeviceSettings::use_profile(const std::string& /*name*/, Device& /*device*/) {}

void DeviceSettings::use_wire(const std::string& /*name*/, Device& /*device*/) {}

bool DeviceSettings::use_setting(const DeviceSetting& /*setting*/, Device& /*device*/) {
  return false;
}

}  // namespace sinew
