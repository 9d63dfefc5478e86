#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string_view>

/// Images of boards: what each says of itself, in its bytes and by its wire. docs/firmware.
namespace sinew {

/// Stands in an image, at a place that is a multiple of 4, in its first kilobyte.
inline constexpr std::array<char, 8> kImageMark{'S', 'I', 'N', 'E', 'W', '-', 'F', 'W'};
inline constexpr std::size_t kImageMarkWithin = 1024;

/// Which board, and which build for it.
struct BoardImage {
  std::array<char, 24> board{};    ///< "axis-stm32f103", zeros behind it
  std::array<char, 16> version{};  ///< "0.1.0", likewise
  std::uint32_t size = 0;          ///< bytes
  std::uint32_t checksum = 0;      ///< CRC-32C of them: two builds that differ have two
  friend bool operator==(const BoardImage&, const BoardImage&) = default;

  std::string_view board_name() const { return text_of(board); }
  std::string_view version_text() const { return text_of(version); }

 private:
  static std::string_view text_of(std::span<const char> text) {
    return std::string_view(text.data(), text.size()).substr(0, length_of(text));
  }
  static std::size_t length_of(std::span<const char> text) {
    std::size_t length = 0;
    while (length < text.size() && text[length] != 0) ++length;
    return length;
  }
};

/// A board's name or version, as it stands in an image. @pre it has room
template <std::size_t kRoom>
constexpr std::array<char, kRoom> image_text(std::string_view text) {
  std::array<char, kRoom> out{};
  for (std::size_t i = 0; i < text.size(); ++i) out[i] = text[i];
  return out;
}

/// As a board tells it: board, version, size, checksum; words little endian.
inline constexpr std::size_t kImageWords = 12;
using ImageWords = std::array<std::uint32_t, kImageWords>;
ImageWords words_of(const BoardImage& image);
/// Nothing where a text has characters that none has.
std::optional<BoardImage> image_of(const ImageWords& words);

/// What bytes of an image, or of a flash that begins with one, say of it: behind the mark stand the
/// board, the version, and the addresses of its first byte and behind its last one.
/// Nothing where there is no mark, or fewer bytes than the image has.
std::optional<BoardImage> read_image(std::span<const std::uint8_t> bytes);

}  // namespace sinew
