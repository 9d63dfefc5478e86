#include "sinew/wire/board_image.h"

#include <algorithm>

#include "sinew/wire/crc32c.h"

namespace sinew {
namespace {

constexpr std::size_t kLabelSize = kImageMark.size() + 24 + 16 + 8;

std::uint32_t word_at(std::span<const std::uint8_t> bytes, std::size_t place) {
  std::uint32_t word = 0;
  for (std::size_t i = 0; i < 4; ++i) word |= std::uint32_t{bytes[place + i]} << 8 * i;
  return word;
}

/// Letters, digits and a few signs, then zeros up to the end; and at least one letter.
bool is_text(std::span<const char> text) {
  const auto sayable = [](char c) {
    return (c >= '0' && c <= '9') || (c >= 'a' && c <= 'z') || c == '-' || c == '.' || c == '+';
  };
  const auto end = std::ranges::find_if_not(text, sayable);
  return end != text.begin() && std::all_of(end, text.end(), [](char c) { return c == 0; });
}

template <std::size_t kSize>
void copy(std::span<const std::uint8_t> from, std::array<char, kSize>& to) {
  for (std::size_t i = 0; i < kSize; ++i) to[i] = static_cast<char>(from[i]);
}

}  // namespace

ImageWords words_of(const BoardImage& image) {
  ImageWords words{};
  const auto put = [&](std::span<const char> text, std::size_t word) {
    for (std::size_t i = 0; i < text.size(); ++i) {
      words[word + i / 4] |= std::uint32_t{static_cast<std::uint8_t>(text[i])} << 8 * (i % 4);
    }
  };
  put(image.board, 0);
  put(image.version, 6);
  words[10] = image.size;
  words[11] = image.checksum;
  return words;
}

std::optional<BoardImage> image_of(const ImageWords& words) {
  BoardImage image;
  const auto take = [&](std::span<char> text, std::size_t word) {
    for (std::size_t i = 0; i < text.size(); ++i) {
      text[i] = static_cast<char>(words[word + i / 4] >> 8 * (i % 4) & 0xFF);
    }
  };
  take(image.board, 0);
  take(image.version, 6);
  image.size = words[10];
  image.checksum = words[11];
  if (!is_text(image.board) || !is_text(image.version)) return std::nullopt;
  return image;
}

std::optional<BoardImage> read_image(std::span<const std::uint8_t> bytes) {
  for (std::size_t place = 0; place + kLabelSize <= std::min(bytes.size(), kImageMarkWithin);
       place += 4) {
    const auto label = bytes.subspan(place, kLabelSize);
    if (!std::equal(kImageMark.begin(), kImageMark.end(), label.begin())) continue;
    BoardImage image;
    copy(label.subspan(8), image.board);
    copy(label.subspan(32), image.version);
    const std::uint32_t begin = word_at(label, 48), end = word_at(label, 52);
    image.size = end - begin;
    const bool whole = end > begin && image.size <= bytes.size();
    if (!whole || !is_text(image.board) || !is_text(image.version)) return std::nullopt;
    image.checksum = crc32c(bytes.first(image.size));
    return image;
  }
  return std::nullopt;
}

}  // namespace sinew
