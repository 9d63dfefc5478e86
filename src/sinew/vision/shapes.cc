#include "sinew/vision/shapes.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace sinew::vision {
namespace {

std::size_t behind(std::size_t i, std::size_t size) {
  return i + 1 == size ? 0 : i + 1;
}

}  // namespace

double area_of(std::span<const Pixel> corners) {
  double twice = 0;
  for (std::size_t i = 0; i < corners.size(); ++i) {
    twice += cross(corners[i], corners[behind(i, corners.size())]);
  }
  return std::abs(twice) / 2;
}

double edge_of(const Quad& quad) {
  return std::sqrt(area_of(quad));
}

bool is_inside(std::span<const Pixel> corners, Pixel point) {
  for (std::size_t i = 0; i < corners.size(); ++i) {
    if (cross(corners[behind(i, corners.size())] - corners[i], point - corners[i]) < 0)
      return false;
  }
  return true;
}

double common_area(std::span<const Pixel> one, std::span<const Pixel> other) {
  // Sutherland and Hodgman: the one is cut along each side of the other.
  std::vector<Pixel> left(one.begin(), one.end());
  for (std::size_t i = 0; i < other.size() && !left.empty(); ++i) {
    const Pixel along = other[behind(i, other.size())] - other[i];
    const auto height = [&](Pixel p) { return cross(along, p - other[i]); };
    std::vector<Pixel> kept;
    for (std::size_t k = 0; k < left.size(); ++k) {
      const Pixel p = left[k];
      const Pixel q = left[behind(k, left.size())];
      const double at_p = height(p);
      const double at_q = height(q);
      if (at_p >= 0) kept.push_back(p);
      if ((at_p >= 0) != (at_q >= 0)) kept.push_back(p + (at_p / (at_p - at_q)) * (q - p));
    }
    left = std::move(kept);
  }
  return area_of(left);
}

double yaw(const Quad& quad) {
  // Four times the angle: sides that are a quarter turn apart say the same.
  Pixel sum;
  for (std::size_t i = 0; i < 4; ++i) {
    const Pixel side = quad[behind(i, 4)] - quad[i];
    const double angle = 4 * std::atan2(side.y, side.x);
    sum = sum + length(side) * Pixel{std::cos(angle), std::sin(angle)};
  }
  const double angle = std::atan2(sum.y, sum.x) / 4;
  return angle < 0 ? angle + std::numbers::pi / 2 : angle;
}

}  // namespace sinew::vision
