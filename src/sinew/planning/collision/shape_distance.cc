#include "sinew/planning/collision/shape_distance.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

namespace sinew::planning {
namespace {

/// Vec3 with an index, for loops over the axes of a box.
using Axes = std::array<double, 3>;

Axes axes(const Vec3& v) {
  return {v.x, v.y, v.z};
}

double clamp01(double t) {
  return std::clamp(t, 0.0, 1.0);
}

double segment_distance(const Vec3& a0, const Vec3& a1, const Vec3& b0, const Vec3& b1) {
  const Vec3 u = a1 - a0, v = b1 - b0, w = a0 - b0;
  const double uu = dot(u, u), vv = dot(v, v), uv = dot(u, v), uw = dot(u, w), vw = dot(v, w);
  // By cross products, which keep their digits where the lines are nearly parallel. Parallel, or of
  // length zero: any place will do, the two steps after it go to the nearest one.
  const Vec3 normal = cross(u, v);
  const double area2 = dot(normal, normal);
  double s = area2 > 0 ? clamp01(-dot(cross(w, v), normal) / area2) : 0;
  const double t = vv > 0 ? clamp01((s * uv + vw) / vv) : 0;
  s = uu > 0 ? clamp01((t * uv - uw) / uu) : 0;
  return norm(w + s * u - t * v);
}

/// Least distance of the line p + t d, t in [0, 1], from the box around the origin.
double line_to_box(const Axes& p, const Axes& d, const Axes& half) {
  // Half the derivative of the squared distance: piecewise linear in t and never falling.
  const auto slope = [&](double t) {
    double sum = 0;
    for (std::size_t i = 0; i < 3; ++i) {
      const double x = p[i] + t * d[i];
      sum += d[i] * (x - std::clamp(x, -half[i], half[i]));
    }
    return sum;
  };
  double low = 0, high = 1;
  double at_low = slope(0), at_high = slope(1);
  double t = 0;
  if (at_low < 0 && at_high <= 0) {
    t = 1;
  } else if (at_low < 0) {
    // Between the two nearest of its corners the slope is a straight line.
    for (std::size_t i = 0; i < 3; ++i) {
      if (d[i] == 0) continue;
      for (const double side : {-half[i], half[i]}) {
        const double corner = (side - p[i]) / d[i];
        if (!(corner > low && corner < high)) continue;
        const double value = slope(corner);
        (value < 0 ? low : high) = corner;
        (value < 0 ? at_low : at_high) = value;
      }
    }
    t = clamp01(low - at_low * (high - low) / (at_high - at_low));
  }
  double squared = 0;
  for (std::size_t i = 0; i < 3; ++i) {
    const double x = p[i] + t * d[i];
    const double excess = x - std::clamp(x, -half[i], half[i]);
    squared += excess * excess;
  }
  return std::sqrt(squared);
}

/// Squared sine below which two edges count as parallel: a common normal is rounding only then,
/// and nothing is lost, since separation along any direction is a bound and faces are near by.
constexpr double kParallel = 1e-20;

/// How far the line overlaps the box, negative, or some separation of them where it does not.
double line_in_box(const Axes& p, const Axes& d, const Axes& half) {
  const Axes middle{p[0] + d[0] / 2, p[1] + d[1] / 2, p[2] + d[2] / 2};
  double separation = -std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < 3; ++i) {
    separation = std::max(separation, std::abs(middle[i]) - std::abs(d[i]) / 2 - half[i]);
  }
  const double dd = d[0] * d[0] + d[1] * d[1] + d[2] * d[2];
  for (std::size_t i = 0; i < 3; ++i) {
    const std::size_t j = (i + 1) % 3, k = (i + 2) % 3;
    const double normal2 = d[j] * d[j] + d[k] * d[k];  // of e_i x d = (0, -d_k, d_j)
    if (normal2 <= kParallel * dd) continue;
    const double apart = std::abs(d[j] * middle[k] - d[k] * middle[j]) -
                         (half[j] * std::abs(d[k]) + half[k] * std::abs(d[j]));
    separation = std::max(separation, apart / std::sqrt(normal2));
  }
  return separation;
}

double point_to_box(const Vec3& p, const Axes& half) {
  const Axes x = axes(p);
  double squared = 0;
  for (std::size_t i = 0; i < 3; ++i) {
    const double excess = std::max(std::abs(x[i]) - half[i], 0.0);
    squared += excess * excess;
  }
  return std::sqrt(squared);
}

/// The second box as the first one sees it.
struct RelativeBox {
  RelativeBox(const PlacedBox& first, const PlacedBox& second)
      : p(axes(transposed_times(first.X.R, second.X.p - first.X.p))),
        columns{axes(transposed_times(first.X.R, second.X.R.x)),
                axes(transposed_times(first.X.R, second.X.R.y)),
                axes(transposed_times(first.X.R, second.X.R.z))},
        half(axes(second.half)) {}

  /// Corner of the signs in the three lowest bits.
  Axes corner(unsigned signs) const {
    Axes at = p;
    for (std::size_t j = 0; j < 3; ++j) {
      const double sign = (signs >> j & 1U) != 0 ? 1 : -1;
      for (std::size_t i = 0; i < 3; ++i) at[i] += sign * half[j] * columns[j][i];
    }
    return at;
  }

  Axes p;
  std::array<Axes, 3> columns;  ///< axes of the second box
  Axes half;
};

/// Largest separation along the normals of all faces and of all pairs of edges: negative where the
/// boxes overlap, and then how far; a lower bound of their distance elsewhere.
double box_separation(const Axes& half, const RelativeBox& other) {
  double separation = -std::numeric_limits<double>::infinity();
  const auto along = [&](const Axes& n, double length) {
    double middle = 0, reach = 0;
    for (std::size_t i = 0; i < 3; ++i) {
      middle += n[i] * other.p[i];
      reach += half[i] * std::abs(n[i]);
      const Axes& column = other.columns[i];
      reach += other.half[i] * std::abs(n[0] * column[0] + n[1] * column[1] + n[2] * column[2]);
    }
    separation = std::max(separation, (std::abs(middle) - reach) / length);
  };
  for (std::size_t i = 0; i < 3; ++i) {
    along({i == 0 ? 1.0 : 0.0, i == 1 ? 1.0 : 0.0, i == 2 ? 1.0 : 0.0}, 1);
    along(other.columns[i], 1);
  }
  for (std::size_t i = 0; i < 3; ++i) {
    const std::size_t j = (i + 1) % 3, k = (i + 2) % 3;
    for (const Axes& column : other.columns) {
      Axes n{};
      n[j] = -column[k];
      n[k] = column[j];
      const double length2 = n[j] * n[j] + n[k] * n[k];
      if (length2 > kParallel) along(n, std::sqrt(length2));
    }
  }
  return separation;
}

/// Least distance of the edges of `other` from the box around the origin.
double edges_to_box(const RelativeBox& other, const Axes& half) {
  double nearest = std::numeric_limits<double>::infinity();
  for (std::size_t j = 0; j < 3; ++j) {
    const Axes& column = other.columns[j];
    const double length = 2 * other.half[j];
    for (unsigned signs = 0; signs < 8; ++signs) {
      if ((signs >> j & 1U) != 0) continue;
      const Axes edge{length * column[0], length * column[1], length * column[2]};
      nearest = std::min(nearest, line_to_box(other.corner(signs), edge, half));
    }
  }
  return nearest;
}

}  // namespace

double distance(const PlacedCapsule& first, const PlacedCapsule& second) {
  return segment_distance(first.a, first.b, second.a, second.b) - first.radius - second.radius;
}

double distance(const PlacedCapsule& capsule, const PlacedBox& box) {
  const Axes p = axes(transposed_times(box.X.R, capsule.a - box.X.p));
  const Axes d = axes(transposed_times(box.X.R, capsule.b - capsule.a));
  const Axes half = axes(box.half);
  const double apart = line_to_box(p, d, half);
  // Through rounding a line that ends its way out of the box on its face may seem beside it.
  constexpr double kRounding = 1e-12;  // m
  const double signed_apart = apart > kRounding ? apart : std::min(line_in_box(p, d, half), apart);
  return signed_apart - capsule.radius;
}

double distance(const PlacedBox& first, const PlacedBox& second) {
  const RelativeBox other(first, second);
  const Axes half = axes(first.half);
  const double separation = box_separation(half, other);
  if (separation <= 0) return separation;
  // What is nearest is an edge or a corner of one of them: edges of the second against the first
  // leave only corners of the first against faces of the second.
  double nearest = edges_to_box(other, half);
  const RelativeBox back(second, first);
  for (unsigned signs = 0; signs < 8; ++signs) {
    const Axes at = back.corner(signs);
    nearest = std::min(nearest, point_to_box({at[0], at[1], at[2]}, axes(second.half)));
  }
  return nearest;
}

double distance_above(const PlacedCapsule& capsule, double height) {
  return std::min(capsule.a.z, capsule.b.z) - capsule.radius - height;
}

double distance_above(const PlacedBox& box, double height) {
  const double reach = box.half.x * std::abs(box.X.R.x.z) + box.half.y * std::abs(box.X.R.y.z) +
                       box.half.z * std::abs(box.X.R.z.z);
  return box.X.p.z - reach - height;
}

}  // namespace sinew::planning
