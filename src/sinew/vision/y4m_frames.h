#pragma once

#include <cstdint>
#include <expected>
#include <optional>
#include <string>
#include <utility>

#include "sinew/vision/raw_frame.h"
#include "sinew/vision/read_at.h"

namespace sinew::vision {

/// What the first line of a YUV4MPEG2 file says of all its frames, and how long it is.
struct Y4mHeader {
  PlaneLayout layout;
  std::size_t bytes = 0;  ///< with its line feed
};

/// Source: mjpegtools, yuv4mpeg(5); XCOLORRANGE as ffmpeg writes it. Limited range where it says
/// nothing.
/// @param text  the beginning of the file; more than the line may follow
/// @error  a sentence: no such file, no size, too large, chroma other than C420, C420jpeg,
///         C420mpeg2, C420paldv, C422, C444 and Cmono, interlaced
std::expected<Y4mHeader, std::string> read_y4m_header(std::span<const std::uint8_t> text);

/// The frames of a YUV4MPEG2 file, one after the other.
class Y4mFrames {
 public:
  /// @error  as read_y4m_header
  static std::expected<Y4mFrames, std::string> open(ReadAt read);

  /// The next frame; nothing at the end, and where the file was cut off.
  std::optional<Picture> next();

 private:
  Y4mFrames(ReadAt read, const Y4mHeader& header)
      : read_(std::move(read)), header_(header), at_(header.bytes) {}

  ReadAt read_;
  Y4mHeader header_;
  std::uint64_t at_;  ///< where the next frame's line begins
};

}  // namespace sinew::vision
