#include "sinew/vision/detection_picture.h"

#include <algorithm>
#include <cmath>

namespace sinew::vision {
namespace {

using Ink = std::array<std::uint8_t, 3>;
constexpr Ink kSeen{0, 255, 70};
constexpr Ink kRefused{255, 0, 255};
constexpr Ink kPaper{0, 0, 0};

/// Digits of 3 x 5 dots, a row in three bits.
constexpr std::array<std::array<std::uint8_t, 5>, 10> kDigits{{{7, 5, 5, 5, 7},
                                                               {2, 6, 2, 2, 7},
                                                               {7, 1, 7, 4, 7},
                                                               {7, 1, 7, 1, 7},
                                                               {5, 5, 7, 1, 1},
                                                               {7, 4, 7, 1, 7},
                                                               {7, 4, 7, 5, 7},
                                                               {7, 1, 1, 2, 2},
                                                               {7, 5, 7, 5, 7},
                                                               {7, 5, 7, 1, 7}}};

class Pen {
 public:
  explicit Pen(Picture& picture)
      : picture_(picture), width_(std::max(1, std::max(picture.width, picture.height) / 500)) {}

  void box(Pixel corner, double width, double height, const Ink& ink) {
    const auto cut = [](double value, int size) {
      return static_cast<int>(std::lround(std::clamp(value, 0.0, static_cast<double>(size))));
    };
    const int right = cut(corner.x + width, picture_.width);
    const int bottom = cut(corner.y + height, picture_.height);
    for (int y = cut(corner.y, picture_.height); y < bottom; ++y) {
      for (int x = cut(corner.x, picture_.width); x < right; ++x) {
        std::ranges::copy(ink, picture_.at(x, y));
      }
    }
  }

  void line(Pixel from, Pixel to, const Ink& ink) {
    const double steps = std::max(1.0, std::ceil(length(to - from)));
    const double half = width_ / 2.0;
    for (int i = 0; i <= static_cast<int>(steps); ++i) {
      const Pixel p = from + (i / steps) * (to - from);
      box({p.x - half, p.y - half}, width_, width_, ink);
    }
  }

  void outline(const Quad& quad, const Ink& ink) {
    for (std::size_t i = 0; i < 4; ++i) line(quad[i], quad[(i + 1) % 4], ink);
  }

  void cross_at(Pixel p, const Ink& ink) {
    const double arm = 4.0 * width_;
    line({p.x - arm, p.y}, {p.x + arm, p.y}, ink);
    line({p.x, p.y - arm}, {p.x, p.y + arm}, ink);
  }

  /// @param at  its upper left corner
  void number(std::size_t value, Pixel at, const Ink& ink) {
    const double dot = 2.0 * width_;
    for (const char digit : std::to_string(value)) {
      box({at.x - dot, at.y - dot}, 5 * dot, 7 * dot, kPaper);
      for (int row = 0; row < 5; ++row) {
        const unsigned bits =
            kDigits[static_cast<std::size_t>(digit - '0')][static_cast<std::size_t>(row)];
        for (int column = 0; column < 3; ++column) {
          if ((bits >> static_cast<unsigned>(2 - column) & 1U) == 0) continue;
          box({at.x + column * dot, at.y + row * dot}, dot, dot, ink);
        }
      }
      at.x += 4 * dot;
    }
  }

 private:
  Picture& picture_;
  int width_;  ///< px, of a line
};

}  // namespace

Picture detection_picture(Picture picture, const Detection& detection) {
  Pen pen(picture);
  std::size_t number = 0;
  for (const SeenCube& cube : detection.cubes) {
    pen.outline(cube.top, kSeen);
    pen.cross_at(cube.center, kSeen);
    pen.number(++number, cube.top[0], kSeen);
  }
  for (const RefusedShape& shape : detection.refused) {
    pen.outline(shape.outline, kRefused);
    pen.number(++number, shape.outline[0], kRefused);
  }
  return picture;
}

}  // namespace sinew::vision
