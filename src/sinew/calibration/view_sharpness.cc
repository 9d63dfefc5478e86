#include "sinew/calibration/view_sharpness.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <vector>

#include "sinew/calibration/geometry.h"

namespace sinew::calibration {
namespace {

using vision::Picture;
using vision::Pixel;

/// Green at a place between pixels; nothing outside of the picture.
std::optional<double> light_at(const Picture& picture, Pixel p) {
  const double x = p.x - 0.5;
  const double y = p.y - 0.5;
  if (!(x >= 0 && y >= 0 && x < picture.width - 1 && y < picture.height - 1)) return std::nullopt;
  const int left = static_cast<int>(x);
  const int top = static_cast<int>(y);
  const double u = x - left;
  const double v = y - top;
  const auto green = [&](int dx, int dy) { return picture.at(left + dx, top + dy)[1]; };
  return (1 - v) * ((1 - u) * green(0, 0) + u * green(1, 0)) +
         v * ((1 - u) * green(0, 1) + u * green(1, 1));
}

/// Across one side of a tag's border at one place. px; nothing where it cannot be told
std::optional<double> width_at(const Picture& picture, Pixel middle, Pixel across, double reach) {
  constexpr double kStep = 0.5;  // px
  constexpr double kLeastContrast = 20;
  double steepest = 0;
  double darkest = 255;
  double brightest = 0;
  std::optional<double> before;
  for (double at = -reach; at <= reach; at += kStep) {
    const auto light = light_at(picture, middle + at * across);
    if (!light) return std::nullopt;
    if (before) steepest = std::max(steepest, std::abs(*light - *before) / kStep);
    before = light;
    darkest = std::min(darkest, *light);
    brightest = std::max(brightest, *light);
  }
  if (brightest - darkest < kLeastContrast) return std::nullopt;
  return (brightest - darkest) / steepest;
}

}  // namespace

double edge_width(const Picture& picture, std::span<const vision::SeenTag> tags) {
  // A tag's border is an eighth of its side wide, and white lies around it.
  constexpr double kReach = 0.12;
  constexpr std::array kAlong{0.2, 0.35, 0.5, 0.65, 0.8};
  // Sides that are rather upright, and the others: motion blurs one of them.
  std::array<std::vector<double>, 2> widths;
  for (const vision::SeenTag& tag : tags) {
    for (std::size_t k = 0; k < 4; ++k) {
      const Pixel from = tag.corners[k];
      const Pixel side = tag.corners[(k + 1) % 4] - from;
      const double size = length(side);
      if (!(size > 1)) continue;
      const Pixel across{-side.y / size, side.x / size};
      const std::size_t which = std::abs(side.x) > std::abs(side.y) ? 0 : 1;
      for (const double along : kAlong) {
        const auto width = width_at(picture, from + along * side, across, kReach * size);
        if (width) widths[which].push_back(*width);
      }
    }
  }
  return std::max(quantile(widths[0], 0.5), quantile(widths[1], 0.5));
}

}  // namespace sinew::calibration
