#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

namespace sinew {

/// Word `index` of bytes that hold it: four of them, little endian. @rt
constexpr std::uint32_t little_word(std::span<const std::uint8_t> bytes, std::size_t index) {
  std::uint32_t word = 0;
  for (std::size_t i = 0; i < 4; ++i) word |= std::uint32_t{bytes[4 * index + i]} << 8 * i;
  return word;
}

/// @rt
constexpr void put_little_word(std::span<std::uint8_t> bytes, std::size_t index,
                               std::uint32_t word) {
  for (std::size_t i = 0; i < 4; ++i) {
    bytes[4 * index + i] = static_cast<std::uint8_t>(word >> 8 * i);
  }
}

}  // namespace sinew
