#pragma once

#include <cstdint>
#include <expected>
#include <functional>
#include <optional>
#include <span>

#include "sinew/core/error.h"
#include "sinew/devices/axis_link/axis_link_wire.h"
#include "sinew/wire/board_image.h"

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

/// What runs on a board; nothing where it does not tell, as simulated ones. A session is opened,
/// so what moves stops.
/// @param joint  that errors name
/// @error  kDeviceSilent, kVersionMismatch, kUnexpectedReply
std::expected<std::optional<BoardImage>, Error> read_board_image(std::int8_t joint,
                                                                 const SetupLine& line);

}  // namespace sinew::axis_link
