#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace sinew::io {

/// Pixel formats of cameras that are read.
enum class VideoFormat : std::uint8_t { kMjpg, kYuyv, kGrey };

/// What is wanted of a camera.
struct VideoWanted {
  int width = 0;   ///< px, as it was calibrated; 0: any
  int height = 0;  ///< px, likewise
  double fps = 0;  ///< pictures per second; 0: as many as it gives
};

/// One way in which a camera can give its pictures.
struct VideoMode {
  VideoFormat format{};
  int width = 0;   ///< px
  int height = 0;  ///< px
  double fps = 0;  ///< the most; 0 where the driver does not say

  friend bool operator==(const VideoMode&, const VideoMode&) = default;
};

/// The mode to choose: of the wanted size, else of the largest up to 1280 x 720, else of the
/// smallest. Of that size the format with the highest rate, as far as it is wanted; uncompressed
/// before compressed ones, and grey only where there is no colour.
/// @return  nothing where no mode has the wanted size, and where there are none
std::optional<VideoMode> best_mode(std::span<const VideoMode> modes, const VideoWanted& wanted);

/// Sizes of the modes, for a sentence: "640 x 480, 1280 x 720"; ascending, each once.
std::string size_list(std::span<const VideoMode> modes);

}  // namespace sinew::io
