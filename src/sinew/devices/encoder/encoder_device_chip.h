#pragma once

#include <array>
#include <cstdint>
#include <optional>

#include "sinew/devices/encoder/encoder_device_i2c.h"
#include "sinew/devices/encoder/encoder_wire_magnet.h"
#include "sinew/mcu/as5600.h"

namespace sinew {

/// What an AS5600 reports at one moment.
struct As5600Reading {
  std::uint16_t position = 0;  ///< 0..4095; noise where no magnet is detected
  Magnet magnet = Magnet::kMissing;
};

/// STATUS and RAW ANGLE as bytes.
using As5600Bytes = std::array<std::uint8_t, kAs5600Size>;
/// Nothing where the chip did not acknowledge. @rt
std::optional<As5600Bytes> read_as5600_bytes(I2cBus& bus);

/// Status and angle of the chip, in one reading that belongs together; nothing where it did not
/// acknowledge. @rt
std::optional<As5600Reading> read_as5600(I2cBus& bus);

/// Of the chip's STATUS register.
Magnet magnet_of(std::uint8_t chip_status);

}  // namespace sinew
