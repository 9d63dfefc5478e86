#include "sinew/core/base64.h"

#include <algorithm>
#include <array>
#include <cstdint>

namespace sinew {
namespace {

constexpr std::string_view kLetters =
    "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";

}  // namespace

std::string base64(std::string_view bytes) {
  std::string text;
  text.reserve((bytes.size() + 2) / 3 * 4);
  for (std::size_t i = 0; i < bytes.size(); i += 3) {
    std::uint32_t bits = 0;
    for (std::size_t k = 0; k < 3; ++k) {
      bits <<= 8;
      if (i + k < bytes.size()) bits |= static_cast<std::uint8_t>(bytes[i + k]);
    }
    const std::size_t letters = std::min<std::size_t>(bytes.size() - i, 3) + 1;
    for (std::size_t k = 0; k < 4; ++k) {
      text += k < letters ? kLetters[(bits >> (18 - 6 * k)) & 63] : '=';
    }
  }
  return text;
}

std::optional<std::string> from_base64(std::string_view text) {
  if (text.size() % 4 != 0) return std::nullopt;
  std::array<std::uint8_t, 256> values{};
  values.fill(64);
  for (std::size_t i = 0; i < kLetters.size(); ++i) {
    values[static_cast<std::uint8_t>(kLetters[i])] = static_cast<std::uint8_t>(i);
  }
  std::string bytes;
  bytes.reserve(text.size() / 4 * 3);
  for (std::size_t i = 0; i < text.size(); i += 4) {
    const bool last = i + 4 == text.size();
    std::size_t ends = 0;
    if (last && text[i + 3] == '=') ends = text[i + 2] == '=' ? 2 : 1;
    std::uint32_t bits = 0;
    for (std::size_t k = 0; k < 4; ++k) {
      const std::uint8_t value =
          k >= 4 - ends ? std::uint8_t{0} : values[static_cast<std::uint8_t>(text[i + k])];
      if (value == 64) return std::nullopt;
      bits = bits << 6 | value;
    }
    for (std::size_t k = 0; k < 3 - ends; ++k) {
      bytes += static_cast<char>(bits >> (16 - 8 * k) & 0xFF);
    }
  }
  return bytes;
}

}  // namespace sinew
