#include "sinew/devices/encoder/encoder_device_chip.h"

#include <array>

#include "sinew/mcu/as5600.h"

namespace sinew {

std::optional<As5600Reading> read_as5600(I2cBus& bus) {
  constexpr std::array<std::uint8_t, 1> kPointer{kAs5600First};
  std::array<std::uint8_t, kAs5600Size> bytes{};
  if (!bus.write(kAs5600Address, kPointer) || !bus.read(kAs5600Address, bytes)) {
    return std::nullopt;
  }
  return As5600Reading{.position = as5600_position(bytes.data()), .magnet = magnet_of(bytes[0])};
}

Magnet magnet_of(std::uint8_t chip_status) {
  if ((chip_status & kAs5600MagnetDetected) == 0) return Magnet::kMissing;
  if ((chip_status & kAs5600MagnetTooWeak) != 0) return Magnet::kTooWeak;
  return (chip_status & kAs5600MagnetTooStrong) != 0 ? Magnet::kTooStrong : Magnet::kGood;
}

}  // namespace sinew
