#include "sinew/devices/maxarm/maxarm_settings.h"

namespace sinew {

void MaxArmDevice::use_profile(const std::string& name, Device& /*device*/) {
  const bool arduino = name.starts_with("arduino");
  variant = arduino ? MaxArmVariant::kArduino : MaxArmVariant::kMicroPython;
  const bool header = name == "micropython" || name == "arduino-with-header";
  checksum = header ? MaxArmChecksum::kWithHeader : MaxArmChecksum::kSpec;
}

bool MaxArmDevice::use_setting(const DeviceSetting& setting, Device& /*device*/) {
  constexpr double kPulsesMax = 1000;
  if (!setting.turns_joint()) return false;
  // Its pulses run the other way over the same range.
  MaxArmServo& servo = servos[*setting.joint];
  servo.offset = kPulsesMax - servo.offset;
  servo.pulses_per_rad *= -1;
  return true;
}

}  // namespace sinew
