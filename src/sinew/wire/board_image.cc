#include "sinew/wire/board_image.h"

#include <algorithm>

#include "sinew/wire/crc32c.h"
#include "sinew/wire/little_words.h"

namespace sinew {
namespace {

constexpr std::size_t kTexts = 24 + 16;  // bytes of board and version
constexpr std::size_t kSizeWord = kTexts / 4;
constexpr std::size_t kLabelSize = kImageMark.size() + kTexts + 8;

/// Letters, digits and a few signs, then zeros up to the end; and at least one letter.
bool is_text(std::span<const char> text) {
  const auto sayable = [](char c) {
    return (c >= '0' && c <= '9') || (c >= 'a' && c <= 'z') || c == '-' || c == '.' || c == '+';
  };
  const auto end = std::ranges::find_if_not(text, sayable);
  return end != text.begin() && std::all_of(end, text.end(), [](char c) { return c == 0; });
}

}  // namespace

ImageIdentity encode_identity(const BoardImage& image) {
  ImageIdentity bytes{};
  const auto version = std::ranges::copy(image.board, bytes.begin()).out;
  std::ranges::copy(image.version, version);
  put_little_word(bytes, kSizeWord, image.size);
  put_little_word(bytes, kSizeWord + 1, image.checksum);
  return bytes;
}

std::optional<BoardImage> decode_identity(const ImageIdentity& bytes) {
  BoardImage image;
  const auto* const version = bytes.begin() + image.board.size();
  std::copy(bytes.begin(), version, image.board.begin());
  std::copy_n(version, image.version.size(), image.version.begin());
  image.size = little_word(bytes, kSizeWord);
  image.checksum = little_word(bytes, kSizeWord + 1);
  if (!is_text(image.board) || !is_text(image.version)) return std::nullopt;
  return image;
}

std::optional<BoardImage> read_image(std::span<const std::uint8_t> bytes) {
  for (std::size_t place = 0; place + kLabelSize <= std::min(bytes.size(), kImageMarkWithin);
       place += 4) {
    const auto label = bytes.subspan(place, kLabelSize);
    if (!std::equal(kImageMark.begin(), kImageMark.end(), label.begin())) continue;
    const auto fields = label.subspan(kImageMark.size());
    const std::uint32_t begin = little_word(fields, kSizeWord);
    const std::uint32_t end = little_word(fields, kSizeWord + 1);
    const std::uint32_t size = end - begin;
    if (end <= begin || size > bytes.size()) return std::nullopt;
    ImageIdentity identity{};
    std::ranges::copy(fields.first(kTexts), identity.begin());
    put_little_word(identity, kSizeWord, size);
    put_little_word(identity, kSizeWord + 1, crc32c(bytes.first(size)));
    return decode_identity(identity);
  }
  return std::nullopt;
}

}  // namespace sinew
