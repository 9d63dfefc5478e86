#include "sinew/io/video_modes.h"

#include <algorithm>
#include <set>
#include <tuple>
#include <utility>

namespace sinew::io {
namespace {

constexpr int kUsualWidth = 1280;
constexpr int kUsualHeight = 720;

/// The higher, the sooner a size is taken where none is wanted.
auto size_rank(const VideoMode& mode) {
  const bool is_usual = mode.width <= kUsualWidth && mode.height <= kUsualHeight;
  const auto pixels = std::int64_t{mode.width} * mode.height;
  return std::tuple(is_usual, is_usual ? pixels : -pixels);
}

/// Compression spoils edges and colours.
int format_rank(VideoFormat format) {
  switch (format) {
    case VideoFormat::kYuyv:
      return 2;
    case VideoFormat::kMjpg:
      return 1;
    case VideoFormat::kGrey:
      break;
  }
  return 0;
}

auto rate_rank(const VideoMode& mode, const VideoWanted& wanted) {
  const double rate = wanted.fps > 0 ? std::min(mode.fps, wanted.fps) : mode.fps;
  return std::tuple(mode.format != VideoFormat::kGrey, rate, format_rank(mode.format));
}

}  // namespace

std::optional<VideoMode> best_mode(std::span<const VideoMode> modes, const VideoWanted& wanted) {
  const bool any_size = wanted.width == 0 || wanted.height == 0;
  const VideoMode* best = nullptr;
  for (const VideoMode& mode : modes) {
    if (!any_size && (mode.width != wanted.width || mode.height != wanted.height)) continue;
    if (best == nullptr || std::tuple(size_rank(mode), rate_rank(mode, wanted)) >
                               std::tuple(size_rank(*best), rate_rank(*best, wanted))) {
      best = &mode;
    }
  }
  return best != nullptr ? std::optional(*best) : std::nullopt;
}

std::string size_list(std::span<const VideoMode> modes) {
  std::set<std::pair<int, int>> sizes;
  for (const VideoMode& mode : modes) sizes.emplace(mode.width, mode.height);
  std::string list;
  for (const auto& [width, height] : sizes) {
    list += (list.empty() ? "" : ", ") + std::to_string(width) + " x " + std::to_string(height);
  }
  return list;
}

}  // namespace sinew::io
