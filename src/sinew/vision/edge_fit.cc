#include "sinew/vision/edge_fit.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <vector>

#include "sinew/vision/shapes.h"

namespace sinew::vision {
namespace {

constexpr double kReach = 4;     ///< px to either side of where an edge is looked for
constexpr double kStep = 0.5;    ///< px
constexpr int kPlaces = 24;      ///< on each side
constexpr int kPlacesLeast = 8;  ///< of them that make a line
constexpr double kFar = 7;       ///< px; a corner that would move farther stays

/// Between four pixels.
Lab sample(const LabPicture& picture, Pixel p) {
  const double x = std::clamp(p.x - 0.5, 0.0, picture.width() - 1.0);
  const double y = std::clamp(p.y - 0.5, 0.0, picture.height() - 1.0);
  const int left = std::min(static_cast<int>(x), std::max(0, picture.width() - 2));
  const int top = std::min(static_cast<int>(y), std::max(0, picture.height() - 2));
  const int right = std::min(left + 1, picture.width() - 1);
  const int bottom = std::min(top + 1, picture.height() - 1);
  const auto u = static_cast<float>(x - left);
  const auto v = static_cast<float>(y - top);
  const auto of = [&](const Plane& plane) {
    const float above = plane.at(left, top) * (1 - u) + plane.at(right, top) * u;
    const float below = plane.at(left, bottom) * (1 - u) + plane.at(right, bottom) * u;
    return above * (1 - v) + below * v;
  };
  return {of(picture.L), of(picture.a), of(picture.b)};
}

struct Line {
  Pixel point;
  Pixel along;  ///< of length 1
};

/// By least squares across it; points that are far from the first one are left out of the second.
std::optional<Line> line_through(std::vector<Pixel> points) {
  std::optional<Line> line;
  for (const double far : {1.5, 1.5}) {
    if (points.size() < kPlacesLeast) return std::nullopt;
    Pixel mean;
    for (const Pixel p : points) mean = mean + (1.0 / static_cast<double>(points.size())) * p;
    double xx = 0;
    double xy = 0;
    double yy = 0;
    for (const Pixel p : points) {
      const Pixel d = p - mean;
      xx += d.x * d.x;
      xy += d.x * d.y;
      yy += d.y * d.y;
    }
    const double angle = std::atan2(2 * xy, xx - yy) / 2;
    line = Line{mean, {std::cos(angle), std::sin(angle)}};
    std::erase_if(points,
                  [&](Pixel p) { return std::abs(cross(line->along, p - line->point)) > far; });
  }
  return line;
}

/// Where the colour changes most across a side, at places that keep away from its ends.
std::vector<Pixel> edge_points(const LabPicture& picture, Pixel from, Pixel to) {
  const Pixel side = to - from;
  const Pixel normal = (1 / std::max(length(side), 1e-9)) * Pixel{side.y, -side.x};
  std::vector<Pixel> points;
  for (int k = 0; k < kPlaces; ++k) {
    const Pixel place = from + (0.12 + 0.76 * k / (kPlaces - 1)) * side;
    const auto change = [&](double offset) {
      return distance(sample(picture, place + (offset + 0.75) * normal),
                      sample(picture, place + (offset - 0.75) * normal));
    };
    constexpr double kWeak = 3;
    double best = 0;
    double most = kWeak;
    for (double offset = -kReach; offset <= kReach; offset += kStep) {
      const double here = change(offset);
      if (here <= most) continue;
      most = here;
      best = offset;
    }
    if (most == kWeak) continue;
    // The top of the parabola through the best and its neighbours.
    const double before = change(best - kStep);
    const double behind = change(best + kStep);
    const double bend = before - 2 * most + behind;
    if (bend < 0) best += kStep * (before - behind) / (2 * bend);
    points.push_back(place + best * normal);
  }
  return points;
}

std::optional<Pixel> meeting(const Line& one, const Line& other) {
  const double turn = cross(one.along, other.along);
  if (std::abs(turn) < 0.2) return std::nullopt;
  return one.point + (cross(other.point - one.point, other.along) / turn) * one.along;
}

}  // namespace

Quad fitted_to_edges(const LabPicture& picture, const Quad& quad) {
  std::array<Line, 4> lines;
  for (std::size_t i = 0; i < 4; ++i) {
    const auto line = line_through(edge_points(picture, quad[i], quad[(i + 1) % 4]));
    if (!line) return quad;
    lines[i] = *line;
  }
  Quad fitted;
  for (std::size_t i = 0; i < 4; ++i) {
    const auto corner = meeting(lines[(i + 3) % 4], lines[i]);
    if (!corner || length(*corner - quad[i]) > kFar) return quad;
    fitted[i] = *corner;
  }
  // Corners that changed places, or a side that fell on another.
  for (std::size_t i = 0; i < 4; ++i) {
    const Pixel in = fitted[i] - fitted[(i + 3) % 4];
    const Pixel out = fitted[(i + 1) % 4] - fitted[i];
    if (cross(in, out) <= 0.3 * length(in) * length(out)) return quad;
  }
  const double larger = area_of(fitted) / area_of(quad);
  return larger > 0.5 && larger < 2 ? fitted : quad;
}

}  // namespace sinew::vision
