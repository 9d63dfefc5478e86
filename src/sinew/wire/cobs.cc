#include "sinew/wire/cobs.h"

#include "sinew/core/assert.h"

namespace sinew::cobs {

Stream encode(std::span<const std::uint8_t> frame) {
  SINEW_ASSERT(!frame.empty() && frame.size() <= kFrameMax);
  std::array<std::uint8_t, kStreamMax> stuffed{};
  const std::size_t size =
      mcu::stuff(frame.data(), static_cast<std::uint8_t>(frame.size()), stuffed.data());
  return Stream(std::span(stuffed.data(), size));
}

std::optional<std::span<const std::uint8_t>> Decoder::push(std::uint8_t byte) {
  const std::size_t size = receiver_.push(byte);
  if (size == 0) return std::nullopt;
  return std::span(receiver_.frame(), size);
}

}  // namespace sinew::cobs
