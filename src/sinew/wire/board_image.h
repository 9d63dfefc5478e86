#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string_view>

/// Identity of a board's image: as a label in its bytes, and over the board's wire. docs/firmware.
namespace sinew {

/// Begins a label, at a multiple of 4 bytes in the image's first kilobyte.
inline constexpr std::array<char, 8> kImageMark{'S', 'I', 'N', 'E', 'W', '-', 'F', 'W'};
inline constexpr std::size_t kImageMarkWithin = 1024;

/// Which board, and which build for it.
struct BoardImage {
  std::array<char, 24> board{};    ///< "axis-stm32f103", zeros behind it
  std::array<char, 16> version{};  ///< "0.1.0", likewise
  std::uint32_t size = 0;          ///< bytes
  std::uint32_t checksum = 0;      ///< CRC-32C of the image; tells builds apart
  friend bool operator==(const BoardImage&, const BoardImage&) = default;

  std::string_view board_name() const { return text_of(board); }
  std::string_view version_text() const { return text_of(version); }

 private:
  static std::string_view text_of(std::span<const char> text) {
    const std::string_view all(text.data(), text.size());
    return all.substr(0, all.find('\0'));
  }
};

/// A board's name or version in its field of an image. @pre it has room
template <std::size_t kRoom>
constexpr std::array<char, kRoom> image_text(std::string_view text) {
  std::array<char, kRoom> out{};
  for (std::size_t i = 0; i < text.size(); ++i) out[i] = text[i];
  return out;
}

/// An identity on the wire: board, version, size, checksum; numbers little endian.
inline constexpr std::size_t kImageIdentitySize = 48;
inline constexpr std::size_t kImageIdentityWords = kImageIdentitySize / 4;
using ImageIdentity = std::array<std::uint8_t, kImageIdentitySize>;
ImageIdentity encode_identity(const BoardImage& image);
/// Nothing where board or version is empty, or has a character other than a to z, 0 to 9, - . +
std::optional<BoardImage> decode_identity(const ImageIdentity& bytes);

/// Identity of an image, or of a flash that begins with one. Its label is the mark, board, version,
/// and the addresses of the image's first byte and of the one behind its last.
/// Nothing without a label, or with fewer bytes than the image has.
std::optional<BoardImage> read_image(std::span<const std::uint8_t> bytes);

}  // namespace sinew
