#pragma once

#include <cstddef>
#include <cstdint>

#include "sinew/core/fixed_vector.h"
#include "sinew/core/instant.h"

/// One framed exchange on a bus of several slaves, as a value: no bus, no pin, no clock.
namespace sinew::spi {

inline constexpr std::size_t kTransferMax = 64;  ///< bytes
using Bytes = FixedVector<std::uint8_t, kTransferMax>;

/// Chip selects go low, `setup` passes, the bytes are exchanged, chip selects go high.
struct Transfer {
  std::uint8_t select = 0;  ///< bit i: axis i is selected; several bits at once are a broadcast
  Bytes mosi;
  Duration setup{};            ///< from the falling edge of the select to the first clock
  std::uint32_t clock_hz = 0;  ///< mode 0, most significant bit first
};

/// Time on the wire, without the setup. @rt
constexpr Duration wire_time(const Transfer& transfer) {
  return Duration{static_cast<std::int64_t>(transfer.mosi.size()) * 8 * 1'000'000'000 /
                  static_cast<std::int64_t>(transfer.clock_hz)};
}

}  // namespace sinew::spi
