#include "sinew/vision/shapes.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

namespace sinew::vision {
namespace {

std::size_t behind(std::size_t i, std::size_t size) {
  return i + 1 == size ? 0 : i + 1;
}

}  // namespace

std::vector<Pixel> convex_hull(std::span<const Pixel> points) {
  // Andrew's two chains: along the top, and back along the bottom.
  std::vector<Pixel> hull;
  const auto add = [&](Pixel point, std::size_t least) {
    while (hull.size() > least &&
           cross(hull.back() - hull[hull.size() - 2], point - hull.back()) <= 0) {
      hull.pop_back();
    }
    hull.push_back(point);
  };
  for (const Pixel point : points) add(point, 1);
  const std::size_t half = hull.size();
  for (std::size_t i = points.size(); i-- > 0;) add(points[i], half);
  if (hull.size() > 1) hull.pop_back();
  return hull;
}

double area_of(std::span<const Pixel> corners) {
  double twice = 0;
  for (std::size_t i = 0; i < corners.size(); ++i) {
    twice += cross(corners[i], corners[behind(i, corners.size())]);
  }
  return std::abs(twice) / 2;
}

std::optional<Quad> four_corners(std::vector<Pixel> hull) {
  while (hull.size() > 4) {
    std::size_t cheapest = 0;
    double least = std::numeric_limits<double>::infinity();
    for (std::size_t i = 0; i < hull.size(); ++i) {
      const Pixel before = hull[i == 0 ? hull.size() - 1 : i - 1];
      const Pixel next = hull[behind(i, hull.size())];
      const double loss = std::abs(cross(hull[i] - before, next - before));
      if (loss >= least) continue;
      least = loss;
      cheapest = i;
    }
    hull.erase(hull.begin() + static_cast<std::ptrdiff_t>(cheapest));
  }
  if (hull.size() < 4) return std::nullopt;
  return Quad{hull[0], hull[1], hull[2], hull[3]};
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

Quad scaled(const Quad& quad, double factor) {
  const Pixel middle = middle_of(quad);
  Quad out;
  std::ranges::transform(quad, out.begin(),
                         [&](Pixel p) { return middle + factor * (p - middle); });
  return out;
}

double side_ratio(const Quad& quad) {
  double shortest = std::numeric_limits<double>::infinity();
  double longest = 0;
  for (std::size_t i = 0; i < 4; ++i) {
    const double side = length(quad[behind(i, 4)] - quad[i]);
    shortest = std::min(shortest, side);
    longest = std::max(longest, side);
  }
  return longest / shortest;
}

double skew(const Quad& quad) {
  double most = 0;
  for (std::size_t i = 0; i < 4; ++i) {
    const Pixel in = quad[i] - quad[(i + 3) % 4];
    const Pixel out = quad[behind(i, 4)] - quad[i];
    most = std::max(
        most, std::abs(std::atan2(std::abs(cross(in, out)), dot(in, out)) - std::numbers::pi / 2));
  }
  return most;
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
