#include "sinew/devices/encoder/encoder_device_chip.h"

#include <array>

namespace sinew {
namespace {

// AS5600 data sheet v1-06, register map. STATUS is followed by RAW ANGLE, so three bytes in one
// read belong together. The pointer is set each time: a chip that lost its supply has it at 0,
// where settings stand that read as an angle of 0.
constexpr std::uint8_t kChip = 0x36;
constexpr std::uint8_t kStatusAddress = 0x0B;
constexpr std::uint8_t kRawAngleAddress = 0x0C;
static_assert(kRawAngleAddress == kStatusAddress + 1);
constexpr std::uint8_t kMagnetDetected = 0x20;
constexpr std::uint8_t kMagnetTooWeak = 0x10;
constexpr std::uint8_t kMagnetTooStrong = 0x08;

}  // namespace

std::optional<As5600Reading> read_as5600(I2cBus& bus) {
  std::array<std::uint8_t, 3> bytes{};
  if (!bus.write(kChip, std::array{kStatusAddress}) || !bus.read(kChip, bytes)) return std::nullopt;
  return As5600Reading{.position = static_cast<std::uint16_t>((bytes[1] << 8 | bytes[2]) & 0xFFF),
                       .magnet = (bytes[0] & kMagnetDetected) != 0,
                       .too_weak = (bytes[0] & kMagnetTooWeak) != 0,
                       .too_strong = (bytes[0] & kMagnetTooStrong) != 0};
}

}  // namespace sinew
