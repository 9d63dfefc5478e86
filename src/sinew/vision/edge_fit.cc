#include "sinew/vision/edge_fit.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <vector>

#include "sinew/core/units.h"
#include "sinew/vision/shapes.h"

namespace sinew::vision {
namespace {

constexpr double kStep = 0.5;    ///< px
constexpr int kPlaces = 24;      ///< on each side
constexpr int kPlacesLeast = 8;  ///< of them that make a line
constexpr double kFar = 1.75;    ///< of the reach; a corner that would move farther stays

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
  const Lab corners[] = {picture.at(left, top), picture.at(right, top), picture.at(left, bottom),
                         picture.at(right, bottom)};
  const auto of = [&](float Lab::* part) {
    const float above = corners[0].*part * (1 - u) + corners[1].*part * u;
    const float below = corners[2].*part * (1 - u) + corners[3].*part * u;
    return above * (1 - v) + below * v;
  };
  return {of(&Lab::L), of(&Lab::a), of(&Lab::b)};
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
std::vector<Pixel> edge_points(const LabPicture& picture, Pixel from, Pixel to, double reach) {
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
    for (double offset = -reach; offset <= reach; offset += kStep) {
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

/// What the weakest side has of an edge, near it; a little of the others.
double edge_strength(const LabPicture& picture, const Quad& quad) {
  constexpr int kAlong = 12;
  constexpr double kStrong = 12;  // more colour across a side makes it no better a side
  constexpr double kNear = 0.035;
  double weakest = kStrong;
  double sum = 0;
  for (std::size_t i = 0; i < 4; ++i) {
    const Pixel side = quad[(i + 1) % 4] - quad[i];
    const double size = std::max(length(side), 1e-9);
    const Pixel normal = (1 / size) * Pixel{side.y, -side.x};
    double strength = 0;
    for (int k = 0; k < kAlong; ++k) {
      const Pixel place = quad[i] + (0.1 + 0.8 * k / (kAlong - 1)) * side;
      double most = 0;
      for (const double offset : {-kNear * size, 0.0, kNear * size}) {
        const Pixel p = place + offset * normal;
        most = std::max<double>(most,
                                distance(sample(picture, p + normal), sample(picture, p - normal)));
      }
      strength += std::min(most, kStrong) / kAlong;
    }
    weakest = std::min(weakest, strength);
    sum += strength;
  }
  return weakest + 0.1 * sum;
}

std::optional<Pixel> meeting(const Line& one, const Line& other) {
  const double turn = cross(one.along, other.along);
  if (std::abs(turn) < 0.2) return std::nullopt;
  return one.point + (cross(other.point - one.point, other.along) / turn) * one.along;
}

}  // namespace

Quad fitted_to_edges(const LabPicture& picture, const Quad& quad, double reach) {
  std::array<Line, 4> lines;
  for (std::size_t i = 0; i < 4; ++i) {
    const auto line = line_through(edge_points(picture, quad[i], quad[(i + 1) % 4], reach));
    if (!line) return quad;
    lines[i] = *line;
  }
  Quad fitted;
  for (std::size_t i = 0; i < 4; ++i) {
    const auto corner = meeting(lines[(i + 3) % 4], lines[i]);
    if (!corner || length(*corner - quad[i]) > kFar * reach) return quad;
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

Quad turned_to_edges(const LabPicture& picture, const Quad& quad) {
  constexpr double kStep = from_deg(7.5);
  constexpr int kSteps = 5;        // to each side: all turns of a square, but for the eighth one
  constexpr double kBetter = 1.1;  // than as it is
  const Pixel middle = middle_of(quad);
  const Pixel u = 0.5 * (quad[1] - quad[0] + quad[2] - quad[3]);
  const Pixel v = 0.5 * (quad[3] - quad[0] + quad[2] - quad[1]);
  Quad best = quad;
  double most = kBetter * edge_strength(picture, quad);
  for (int i = -kSteps; i <= kSteps; ++i) {
    if (i == 0) continue;
    const double c = 0.5 * std::cos(i * kStep);
    const double s = 0.5 * std::sin(i * kStep);
    const auto corner = [&](double x, double y) {
      return middle + (c * x - s * y) * u + (s * x + c * y) * v;
    };
    const Quad turned{corner(-1, -1), corner(1, -1), corner(1, 1), corner(-1, 1)};
    const double strength = edge_strength(picture, turned);
    if (strength <= most) continue;
    most = strength;
    best = turned;
  }
  return best;
}

int corners_filled(const LabPicture& picture, const Quad& quad) {
  constexpr double kInside = 0.86;  // of the way to a corner: a disc ends at 0.71
  constexpr double kBefore = 0.55;
  constexpr double kOutside = 1.3;
  constexpr float kAlike = 8;  // beside a cube of its own color both are
  const Pixel middle = middle_of(quad);
  int filled = 0;
  for (const Pixel corner : quad) {
    const auto at = [&](double share) {
      return sample(picture, middle + share * (corner - middle));
    };
    const Lab here = at(kInside);
    filled += distance(here, at(kBefore)) < distance(here, at(kOutside)) + kAlike ? 1 : 0;
  }
  return filled;
}

double light_share(const LabPicture& picture, const Quad& quad) {
  constexpr double kInside = 0.8;  // of the quad: its border may be that of another face
  constexpr int kSamples = 16;     // to a side
  constexpr float kLighter = 25;   // of L*
  const Pixel middle = middle_of(quad);
  std::array<float, kSamples * kSamples> lightness{};
  std::size_t count = 0;
  for (int i = 0; i < kSamples; ++i) {
    for (int k = 0; k < kSamples; ++k) {
      const double u = (i + 0.5) / kSamples;
      const double v = (k + 0.5) / kSamples;
      const Pixel upper = quad[0] + u * (quad[1] - quad[0]);
      const Pixel lower = quad[3] + u * (quad[2] - quad[3]);
      const Pixel place = upper + v * (lower - upper);
      lightness[count++] = sample(picture, middle + kInside * (place - middle)).L;
    }
  }
  const auto dark = lightness.begin() + kSamples * kSamples / 5;
  std::ranges::nth_element(lightness, dark);
  const auto lighter = std::ranges::count_if(
      lightness, [limit = *dark + kLighter](float one) { return one > limit; });
  return static_cast<double>(lighter) / (kSamples * kSamples);
}

}  // namespace sinew::vision
