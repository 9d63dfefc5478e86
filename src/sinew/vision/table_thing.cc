#include "sinew/vision/table_thing.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <vector>

#include "sinew/core/units.h"

namespace sinew::vision {
namespace {

/// Every few pixels of a square part of a picture.
class Window {
 public:
  Window(const Picture& picture, Pixel middle, double reach)
      : picture_(picture),
        step_(std::max(1, static_cast<int>(std::ceil(reach / kHalfMost)))),
        half_(static_cast<int>(std::ceil(reach / step_))),
        x_(static_cast<int>(middle.x)),
        y_(static_cast<int>(middle.y)),
        in_(static_cast<std::size_t>(size() * size())) {}

  int size() const { return 2 * half_ + 1; }
  Pixel pixel(int i, int j) const {
    return {x_ + (i - half_) * step_ + 0.5, y_ + (j - half_) * step_ + 0.5};
  }
  bool is_in_patch(int i, int j) const {
    return i >= 0 && j >= 0 && i < size() && j < size() && in_[at(i, j)];
  }

  /// Flood fill from the middle. @param tolerance  of 8-bit RGB
  /// @return  false where the patch reaches the border of the window
  bool fill(int tolerance) {
    in_.assign(in_.size(), false);
    const std::array<int, 3> color = middle_color();
    std::vector<std::array<int, 2>> open{{half_, half_}};
    in_[at(half_, half_)] = true;
    while (!open.empty()) {
      const auto [i, j] = open.back();
      open.pop_back();
      for (const auto& [di, dj] : kBeside) {
        const int u = i + di, v = j + dj;
        if (u < 0 || v < 0 || u >= size() || v >= size()) return false;
        if (in_[at(u, v)] || !is_like(u, v, color, tolerance)) continue;
        in_[at(u, v)] = true;
        open.push_back({u, v});
      }
    }
    return true;
  }

  /// Pixels at the rim of the patch, without lines that are one pixel wide.
  std::vector<Pixel> rim() const {
    std::vector<Pixel> rim;
    for (int j = 0; j < size(); ++j) {
      for (int i = 0; i < size(); ++i) {
        if (!is_thick(i, j)) continue;
        const auto beside = std::ranges::count_if(
            kBeside, [&](const auto& d) { return is_in_patch(i + d[0], j + d[1]); });
        if (beside < 4) rim.push_back(pixel(i, j));
      }
    }
    return rim;
  }

 private:
  static constexpr double kHalfMost = 48;
  static constexpr std::array<std::array<int, 2>, 4> kBeside{{{1, 0}, {-1, 0}, {0, 1}, {0, -1}}};

  /// Part of a square of 2 x 2 in the patch.
  bool is_thick(int i, int j) const {
    if (!is_in_patch(i, j)) return false;
    for (const int di : {-1, 1}) {
      for (const int dj : {-1, 1}) {
        if (is_in_patch(i + di, j) && is_in_patch(i, j + dj) && is_in_patch(i + di, j + dj)) {
          return true;
        }
      }
    }
    return false;
  }
  std::size_t at(int i, int j) const { return static_cast<std::size_t>(j * size() + i); }
  const std::uint8_t* color_at(int i, int j) const {
    const int x = x_ + (i - half_) * step_, y = y_ + (j - half_) * step_;
    if (x < 0 || y < 0 || x >= picture_.width || y >= picture_.height) return nullptr;
    return picture_.at(x, y);
  }
  std::array<int, 3> middle_color() const {
    std::array<int, 3> sum{};
    int count = 0;
    for (int j = half_ - 1; j <= half_ + 1; ++j) {
      for (int i = half_ - 1; i <= half_ + 1; ++i) {
        const std::uint8_t* color = color_at(i, j);
        if (color == nullptr) continue;
        for (std::size_t c = 0; c < 3; ++c) sum[c] += color[c];
        ++count;
      }
    }
    for (int& part : sum) part /= std::max(count, 1);
    return sum;
  }
  bool is_like(int i, int j, const std::array<int, 3>& color, int tolerance) const {
    const std::uint8_t* here = color_at(i, j);
    if (here == nullptr) return false;
    for (std::size_t c = 0; c < 3; ++c) {
      if (std::abs(here[c] - color[c]) > tolerance) return false;
    }
    return true;
  }

  const Picture& picture_;
  int step_;
  int half_;
  int x_, y_;
  std::vector<bool> in_;
};

/// Smallest bounding rectangle in the plane.
ThingPosition rectangle_around(const std::vector<Vec3>& points, double height) {
  constexpr double kStep = from_deg(3);
  ThingPosition best;
  double least = std::numeric_limits<double>::infinity();
  for (double yaw = 0; yaw < kPi / 2 - kStep / 2; yaw += kStep) {
    const double c = std::cos(yaw), s = std::sin(yaw);
    constexpr double kFar = std::numeric_limits<double>::infinity();
    double u_min = kFar, u_max = -kFar, v_min = kFar, v_max = -kFar;
    for (const Vec3& p : points) {
      const double u = c * p.x + s * p.y, v = c * p.y - s * p.x;
      u_min = std::min(u_min, u);
      u_max = std::max(u_max, u);
      v_min = std::min(v_min, v);
      v_max = std::max(v_max, v);
    }
    const double area = (u_max - u_min) * (v_max - v_min);
    if (area >= least) continue;
    least = area;
    const double u = (u_min + u_max) / 2, v = (v_min + v_max) / 2;
    best = {{c * u - s * v, s * u + c * v, height}, yaw, (u_max - u_min) / 2, (v_max - v_min) / 2};
  }
  return best;
}

}  // namespace

std::optional<ThingPosition> thing_position(const Picture& picture, const TableCamera& camera,
                                            Pixel middle, double edge) {
  constexpr double kSmallest = 3e-3;             // m, half of its edges
  constexpr std::array kTolerances{28, 18, 12};  // of 8-bit RGB
  const auto p_W = on_plane(camera, middle, edge / 2);
  const auto p_right_W = on_plane(camera, middle + Pixel{1, 0}, edge / 2);
  const auto p_below_W = on_plane(camera, middle + Pixel{0, 1}, edge / 2);
  if (!p_W || !p_right_W || !p_below_W) return std::nullopt;
  const double metres = std::min(norm(*p_right_W - *p_W), norm(*p_below_W - *p_W));  // of a pixel
  Window window(picture, middle, kThingMost / metres);
  for (const int tolerance : kTolerances) {
    if (!window.fill(tolerance)) continue;
    std::vector<Vec3> points;
    for (const Pixel& p : window.rim()) {
      if (const auto at_W = on_plane(camera, p, edge / 2)) points.push_back(*at_W);
    }
    if (points.empty()) return std::nullopt;
    const auto is_far = [&](const Vec3& at_W) { return norm(at_W - *p_W) > kThingMost; };
    if (std::ranges::any_of(points, is_far)) continue;
    const ThingPosition found = rectangle_around(points, edge);
    if (std::min(found.half_x, found.half_y) < kSmallest) return std::nullopt;
    return found;
  }
  return std::nullopt;
}

}  // namespace sinew::vision
