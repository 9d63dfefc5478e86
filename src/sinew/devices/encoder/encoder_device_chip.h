#pragma once

#include <cstdint>
#include <optional>

#include "sinew/devices/axis/axis_device_i2c.h"

namespace sinew {

/// What an AS5600 says at one moment.
struct As5600Reading {
  std::uint16_t position = 0;  ///< 0..4095
  bool magnet = false;         ///< without one the position is noise
  bool too_weak = false;
  bool too_strong = false;
};

/// Status and angle of the chip, in one reading that belongs together; nothing where it did not
/// answer. @rt
std::optional<As5600Reading> read_as5600(I2cBus& bus);

}  // namespace sinew
