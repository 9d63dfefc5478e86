#pragma once

#include <cstddef>
#include <cstdint>
#include <expected>
#include <optional>
#include <span>
#include <string>

#include "sinew/vision/picture.h"

/// Uncompressed frames of cameras and video files as pictures. The matrix is that of ITU-R BT.601.
namespace sinew::vision {

/// What luma and chroma mean: BT.601's 16 to 235 and 16 to 240, or JPEG's 0 to 255.
enum class LumaRange : std::uint8_t { kLimited, kFull };

/// A frame of one plane.
struct FrameLayout {
  int width = 0;           ///< px
  int height = 0;          ///< px
  std::size_t stride = 0;  ///< bytes from row to row, as the driver pads them
  LumaRange range = LumaRange::kLimited;
};

/// Two pixels in four bytes: Y U Y V. An odd width has one unused luma byte at its end.
/// @error  a sentence: no size, too large, rows longer than the stride, cut short
std::expected<Picture, std::string> picture_from_yuyv(std::span<const std::uint8_t> bytes,
                                                      const FrameLayout& layout);

/// One byte of luma a pixel. @error  as picture_from_yuyv
std::expected<Picture, std::string> picture_from_grey(std::span<const std::uint8_t> bytes,
                                                      const FrameLayout& layout);

/// Where the chroma samples of a frame in planes are.
enum class Chroma : std::uint8_t {
  k420Centre,  ///< in the middle of four pixels (JPEG, MPEG-1)
  k420Left,    ///< between two rows, at the left pixel (MPEG-2)
  k422,        ///< at the left of two pixels
  k444,
  kNone,
};

/// A frame of a luma plane and two chroma planes, one behind the other without padding.
struct PlaneLayout {
  int width = 0;   ///< px
  int height = 0;  ///< px
  Chroma chroma = Chroma::k420Centre;
  LumaRange range = LumaRange::kLimited;
};

/// Bytes of such a frame; nothing where it has no size or over 64 million pixels.
std::optional<std::size_t> frame_bytes(const PlaneLayout& layout);

/// @error  a sentence: no size, too large, cut short
std::expected<Picture, std::string> picture_from_planes(std::span<const std::uint8_t> bytes,
                                                        const PlaneLayout& layout);

}  // namespace sinew::vision
