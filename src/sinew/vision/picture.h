#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace sinew::vision {

/// A point of a picture, px: x to the right, y down; the middle of the first pixel is (0.5, 0.5).
struct Pixel {
  double x = 0;
  double y = 0;

  friend constexpr Pixel operator+(Pixel a, Pixel b) { return {a.x + b.x, a.y + b.y}; }
  friend constexpr Pixel operator-(Pixel a, Pixel b) { return {a.x - b.x, a.y - b.y}; }
  friend constexpr Pixel operator*(double k, Pixel a) { return {k * a.x, k * a.y}; }
};

constexpr double dot(Pixel a, Pixel b) {
  return a.x * b.x + a.y * b.y;
}
/// Positive where b is to the right of a, seen on the screen.
constexpr double cross(Pixel a, Pixel b) {
  return a.x * b.y - a.y * b.x;
}
double length(Pixel a);

using Quad = std::array<Pixel, 4>;
Pixel middle_of(const Quad& quad);

/// An upright picture in sRGB, row by row from above, three bytes a pixel.
struct Picture {
  int width = 0;
  int height = 0;
  std::vector<std::uint8_t> rgb;

  const std::uint8_t* at(int x, int y) const {
    return rgb.data() + 3 * (static_cast<std::size_t>(y) * static_cast<std::size_t>(width) +
                             static_cast<std::size_t>(x));
  }
  std::uint8_t* at(int x, int y) {
    return rgb.data() + 3 * (static_cast<std::size_t>(y) * static_cast<std::size_t>(width) +
                             static_cast<std::size_t>(x));
  }
};

/// A picture of this size, black. @pre width, height > 0
Picture black_picture(int width, int height);

/// Its longer side has at most `longest` px; each pixel is the mean of what it covers. Pictures
/// that are small enough stay as they are.
Picture shrunk(const Picture& picture, int longest);

}  // namespace sinew::vision
