#include "sinew/devices/encoder/encoder_device_chip.h"

namespace sinew {

std::optional<As5600Bytes> read_as5600_bytes(I2cBus& bus) {
  constexpr std::array<std::uint8_t, 1> kPointer{kAs5600First};
  As5600Bytes bytes{};
  if (!bus.write(kAs5600Address, kPointer) || !bus.read(kAs5600Address, bytes)) {
    return std::nullopt;
  }
  return bytes;
}

std::optional<As5600Reading> read_as5600(I2cBus& bus) {
  const auto bytes = read_as5600_bytes(bus);
  if (!bytes) return std::nullopt;
  return As5600Reading{.position = as5600_position(bytes->data()),
                       .magnet = magnet_of((*bytes)[0])};
}

Magnet magnet_of(std::uint8_t chip_status) {
  return magnet_from((chip_status & kAs5600MagnetDetected) != 0,
                     (chip_status & kAs5600MagnetTooWeak) != 0,
                     (chip_status & kAs5600MagnetTooStrong) != 0);
}

}  // namespace sinew
