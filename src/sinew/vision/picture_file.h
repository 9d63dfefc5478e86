#pragma once

#include <cstdint>
#include <expected>
#include <span>
#include <string>
#include <vector>

#include "sinew/vision/picture.h"

namespace sinew::vision {

/// More than any camera gives; a file of some kilobytes may say that it is larger than any memory.
inline constexpr std::int64_t kPixelsMax = 64'000'000;

/// A JPEG or PNG file as an upright picture: grey, CMYK, palettes, 16 bits and interlaced ones too.
/// What is transparent is white. Pixels are taken for sRGB.
/// @error  a sentence: no picture, a kind of picture that is not read, cut short, too large
std::expected<Picture, std::string> decode_picture(std::span<const std::uint8_t> file);

/// As a JPEG file, as cameras write them. @pre it has a size. @param quality  1 to 100
std::vector<std::uint8_t> encode_jpeg(const Picture& picture, int quality = 85);
/// As a PNG file.
std::vector<std::uint8_t> encode_png(const Picture& picture);

}  // namespace sinew::vision
