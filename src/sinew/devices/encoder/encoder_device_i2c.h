#pragma once

#include <cstdint>
#include <span>

namespace sinew {

/// One transaction each, as a board's I2C peripheral makes it: start, address, bytes, stop.
/// Nothing waits longer than its bytes take; a line that is held low is a refusal too. @rt
class I2cBus {
 public:
  virtual ~I2cBus() = default;

  /// @return  false where the device or one of the bytes was not acknowledged, or the bus is stuck.
  virtual bool write(std::uint8_t address, std::span<const std::uint8_t> bytes) = 0;
  /// `out` is untouched where it returns false.
  virtual bool read(std::uint8_t address, std::span<std::uint8_t> out) = 0;
};

}  // namespace sinew
