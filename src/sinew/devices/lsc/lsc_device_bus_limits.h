#pragma once

#include <cstdint>
#include <optional>
#include <utility>

#include "sinew/devices/lsc/lsc_wire.h"

namespace sinew {

/// What a servo on the bus keeps in itself, over a loss of power too. Values before anybody wrote:
/// the data sheet of servos of that class.
struct BusServoLimits {
  std::uint16_t position_min = 0;     ///< units; a target below is this one
  std::uint16_t position_max = 1000;  ///< units
  std::uint16_t millivolts_min = 4500;
  std::uint16_t millivolts_max = 12'000;
  std::uint16_t celsius_max = 85;
  std::uint8_t led = 0;           ///< 0 lit
  std::uint8_t led_warnings = 7;  ///< bits: heat, supply, position
  friend bool operator==(const BusServoLimits&, const BusServoLimits&) = default;
};

/// What it senses at this moment.
struct BusServoSenses {
  std::int8_t offset = 0;
  std::int16_t position = 0;
  std::uint16_t millivolts = 0;
};

/// Parameters of command 27: id, then the limits in their order above. Nothing where they are not
/// thirteen bytes long, or a lower limit is not below its upper one. docs/wires/lsc.md. @rt
std::optional<std::pair<std::uint8_t, BusServoLimits>> read_limits(const lsc::Parameters& bytes);

/// Parameters of the answer to 28: those of 27, then offset, position, temperature and supply.
/// The temperature is a warm servo's 30 C: no heat is simulated. @rt
lsc::Parameters written_info(std::uint8_t id, const BusServoLimits& limits,
                             const BusServoSenses& senses);

}  // namespace sinew
