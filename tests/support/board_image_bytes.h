#pragma once

#include <cstddef>
#include <cstdint>
#include <string_view>
#include <vector>

namespace sinew::test {

/// Bytes of an image with its label at `place`, written out by hand; the rest differs from byte to
/// byte, and from page to page of a flash.
inline std::vector<std::uint8_t> board_image_bytes(std::string_view board, std::string_view version,
                                                   std::size_t place, std::size_t size) {
  std::vector<std::uint8_t> bytes(size);
  for (std::size_t i = 0; i < size; ++i) bytes[i] = static_cast<std::uint8_t>(i * 7 + i / 251);
  const auto put = [&](std::size_t at, std::string_view text, std::size_t room) {
    for (std::size_t i = 0; i < room; ++i) {
      bytes[place + at + i] = i < text.size() ? static_cast<std::uint8_t>(text[i]) : 0;
    }
  };
  put(0, "SINEW-FW", 8);
  put(8, board, 24);
  put(32, version, 16);
  const std::uint32_t begin = 0x08000000, end = begin + static_cast<std::uint32_t>(size);
  for (std::size_t i = 0; i < 4; ++i) {
    bytes[place + 48 + i] = static_cast<std::uint8_t>(begin >> 8 * i);
    bytes[place + 52 + i] = static_cast<std::uint8_t>(end >> 8 * i);
  }
  return bytes;
}

}  // namespace sinew::test
