#include "sinew/vision/exif.h"

#include <algorithm>
#include <array>
#include <string_view>
#include <utility>

#include "sinew/vision/byte_text.h"

namespace sinew::vision {
namespace {

/// Big-endian or little-endian, of 2 or 4 bytes; 0 beyond the end.
std::uint32_t number_at(Bytes bytes, std::size_t at, std::size_t size, bool little) {
  if (at > bytes.size() || bytes.size() - at < size) return 0;
  std::uint32_t value = 0;
  for (std::size_t i = 0; i < size; ++i) {
    value = value << 8U | bytes[at + (little ? size - 1 - i : i)];
  }
  return value;
}

constexpr std::string_view kExif{"Exif\0\0", 6};

/// The EXIF block of a JPEG: in the APP1 segments before its first scan.
Bytes jpeg_exif(Bytes file) {
  for (std::size_t at = 2; at + 4 <= file.size();) {
    if (file[at] != 0xFF) return {};
    const std::uint8_t marker = file[at + 1];
    constexpr std::uint8_t kFill = 0xFF;
    constexpr std::uint8_t kScan = 0xDA;
    constexpr std::uint8_t kApp1 = 0xE1;
    if (marker == kFill) {
      ++at;
      continue;
    }
    if (marker == kScan) return {};
    const std::size_t size = number_at(file, at + 2, 2, false);
    if (size < 2 || file.size() - at - 2 < size) return {};
    const Bytes body = file.subspan(at + 4, size - 2);
    if (marker == kApp1 && has_at(body, 0, kExif)) return body.subspan(kExif.size());
    at += 2 + size;
  }
  return {};
}

Bytes png_exif(Bytes file) {
  constexpr std::size_t kSignature = 8;
  constexpr std::size_t kAround = 12;  // length, name, checksum
  for (std::size_t at = kSignature; at + kAround <= file.size();) {
    const std::size_t size = number_at(file, at, 4, false);
    if (file.size() - at - kAround < size) return {};
    if (has_at(file, at + 4, "eXIf")) return file.subspan(at + 8, size);
    at += kAround + size;
  }
  return {};
}

}  // namespace

int exif_orientation(Bytes tiff) {
  const bool little = has_at(tiff, 0, "II");
  if (!little && !has_at(tiff, 0, "MM")) return 1;
  const std::size_t directory = number_at(tiff, 4, 4, little);
  const std::size_t entries = number_at(tiff, directory, 2, little);
  constexpr std::size_t kEntry = 12;
  constexpr std::uint32_t kOrientation = 0x0112;
  for (std::size_t i = 0; i < entries; ++i) {
    const std::size_t at = directory + 2 + kEntry * i;
    if (at > tiff.size()) return 1;
    if (number_at(tiff, at, 2, little) != kOrientation) continue;
    const std::uint32_t value = number_at(tiff, at + 8, 2, little);
    return value >= 1 && value <= 8 ? static_cast<int>(value) : 1;
  }
  return 1;
}

int orientation_of_file(Bytes file) {
  constexpr std::string_view kJpeg{"\xFF\xD8", 2};
  return exif_orientation(has_at(file, 0, kJpeg) ? jpeg_exif(file) : png_exif(file));
}

Picture upright(Picture picture, int orientation) {
  if (orientation == 1) return picture;
  // Of each orientation: whether rows become columns, and which of both run backwards in the file.
  struct Turn {
    bool across;
    bool x_back;
    bool y_back;
  };
  constexpr std::array<Turn, 8> kTurns{{{false, false, false},
                                        {false, true, false},
                                        {false, true, true},
                                        {false, false, true},
                                        {true, false, false},
                                        {true, false, true},
                                        {true, true, true},
                                        {true, true, false}}};
  const Turn turn = kTurns[static_cast<std::size_t>(orientation - 1)];
  Picture out = turn.across ? black_picture(picture.height, picture.width)
                            : black_picture(picture.width, picture.height);
  for (int y = 0; y < out.height; ++y) {
    for (int x = 0; x < out.width; ++x) {
      int from_x = turn.across ? y : x;
      int from_y = turn.across ? x : y;
      if (turn.x_back) from_x = picture.width - 1 - from_x;
      if (turn.y_back) from_y = picture.height - 1 - from_y;
      std::copy_n(std::as_const(picture).at(from_x, from_y), 3, out.at(x, y));
    }
  }
  return out;
}

}  // namespace sinew::vision
