#pragma once

#include <cstdint>
#include <expected>
#include <functional>
#include <span>

#include "sinew/core/error.h"
#include "sinew/devices/axis_link/axis_link_wire.h"

namespace sinew::axis_link {

/// What the writing of a setup needs of the world.
struct SetupLine {
  /// A frame to the one board, and what came back in the same clocks; false where the bus failed.
  std::function<bool(std::span<const std::uint8_t> mosi, std::span<std::uint8_t> miso)> exchange;
  std::function<void(Duration)> wait;
};

/// How a board was found.
struct SetupReport {
  SetupBytes before{};   ///< what it kept
  bool written = false;  ///< else that was this very setup
};

/// Makes a board keep `wanted`, whatever it was before: reads what it keeps, and where that differs
/// writes the whole, lets it start again and reads it back. The board must be
/// the only one that is selected; nothing moves, and it is not homed afterwards.
/// @param joint  that errors name
/// @error  kDeviceSilent, kVersionMismatch; kEmergencyStop: one is latched; kBusy: the
///         axis moves, or the board cannot keep it; kUnexpectedReply: it kept something else
std::expected<SetupReport, Error> write_setup(const SetupBytes& wanted, std::int8_t joint,
                                              const SetupLine& line);

}  // namespace sinew::axis_link
