#include "sinew/sim/plan_shape.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "sinew/core/assert.h"

namespace sinew::sim {
namespace {

struct Span {
  double low = std::numeric_limits<double>::infinity();
  double high = -std::numeric_limits<double>::infinity();
};

Span span_along(const PlanShape& shape, PlanPoint axis) {
  Span span;
  for (const PlanPoint p : shape) {
    span.low = std::min(span.low, dot(p, axis));
    span.high = std::max(span.high, dot(p, axis));
  }
  return span;
}

/// Calls `visit(axis, depth)` for each edge of both: `b` leaves `a` along `axis` after `depth` m.
/// False where they do not overlap.
template <class Visit>
bool for_each_way(const PlanShape& a, const PlanShape& b, const Visit& visit) {
  if (a.size() < 3 || b.size() < 3) return false;
  for (const bool of_first : {true, false}) {
    const PlanShape& shape = of_first ? a : b;
    for (std::size_t i = 0; i < shape.size(); ++i) {
      const PlanPoint edge = shape[(i + 1) % shape.size()] - shape[i];
      const double size = length(edge);
      if (size < 1e-12) continue;
      const PlanPoint out = 1 / size * PlanPoint{edge.y, -edge.x};
      const PlanPoint axis = of_first ? out : -1 * out;
      const double depth = span_along(a, axis).high - span_along(b, axis).low;
      if (depth <= 0) return false;
      visit(axis, depth);
    }
  }
  return true;
}

}  // namespace

double length(PlanPoint a) {
  return std::hypot(a.x, a.y);
}

PlanPoint direction_of(PlanPoint a) {
  const double size = length(a);
  return size > 0 ? 1 / size * a : PlanPoint{1, 0};
}

PlanShape rectangle(PlanPoint middle, double yaw, PlanPoint half) {
  const PlanPoint u{std::cos(yaw), std::sin(yaw)};
  const PlanPoint v{-u.y, u.x};
  return {middle + half.x * u + half.y * v, middle - half.x * u + half.y * v,
          middle - half.x * u - half.y * v, middle + half.x * u - half.y * v};
}

PlanShape hull_of(std::vector<PlanPoint> points) {
  // Source: A. M. Andrew, Another efficient algorithm for convex hulls in two dimensions, 1979.
  std::ranges::sort(
      points, [](PlanPoint a, PlanPoint b) { return a.x < b.x || (a.x == b.x && a.y < b.y); });
  PlanShape hull;
  const auto add = [&](std::size_t least, PlanPoint p) {
    while (hull.size() >= least + 2 &&
           cross(hull.back() - hull[hull.size() - 2], p - hull.back()) <= 0) {
      hull.pop_back();
    }
    hull.push_back(p);
  };
  for (const PlanPoint p : points) add(0, p);
  const std::size_t lower = hull.size();
  if (lower < 2) return hull;
  for (std::size_t i = points.size() - 1; i-- > 0;) add(lower - 1, points[i]);
  hull.pop_back();
  return hull;
}

bool contains(const PlanShape& shape, PlanPoint p, double inside) {
  if (shape.size() < 3) return false;
  for (std::size_t i = 0; i < shape.size(); ++i) {
    const PlanPoint edge = shape[(i + 1) % shape.size()] - shape[i];
    if (cross(edge, p - shape[i]) < inside * length(edge)) return false;
  }
  return true;
}

PlanShape common_part(const PlanShape& a, const PlanShape& b) {
  // Source: I. E. Sutherland, G. W. Hodgman, Reentrant polygon clipping, 1974.
  if (a.size() < 3 || b.size() < 3) return {};
  PlanShape part = a;
  for (std::size_t i = 0; i < b.size() && !part.empty(); ++i) {
    const PlanPoint edge = b[(i + 1) % b.size()] - b[i];
    PlanShape rest;
    for (std::size_t k = 0; k < part.size(); ++k) {
      const PlanPoint from = part[k];
      const PlanPoint to = part[(k + 1) % part.size()];
      const double at_from = cross(edge, from - b[i]);
      const double at_to = cross(edge, to - b[i]);
      if (at_from >= 0) rest.push_back(from);
      if ((at_from >= 0) != (at_to >= 0)) {
        rest.push_back(from + at_from / (at_from - at_to) * (to - from));
      }
    }
    part = std::move(rest);
  }
  return part;
}

double area_of(const PlanShape& shape) {
  double twice = 0;
  for (std::size_t i = 0; i < shape.size(); ++i) {
    twice += cross(shape[i], shape[(i + 1) % shape.size()]);
  }
  return twice / 2;
}

PlanPoint middle_of(const PlanShape& shape) {
  SINEW_ASSERT(!shape.empty());
  PlanPoint sum;
  for (const PlanPoint p : shape) sum = sum + p;
  return 1 / static_cast<double>(shape.size()) * sum;
}

std::optional<PlanPoint> step_out(const PlanShape& a, const PlanShape& b) {
  double least = std::numeric_limits<double>::infinity();
  PlanPoint step;
  const bool overlap = for_each_way(a, b, [&](PlanPoint axis, double depth) {
    if (depth >= least) return;
    least = depth;
    step = depth * axis;
  });
  if (!overlap) return std::nullopt;
  return step;
}

double slide_out(const PlanShape& a, const PlanShape& b, PlanPoint toward) {
  double least = std::numeric_limits<double>::infinity();
  const bool overlap = for_each_way(a, b, [&](PlanPoint axis, double depth) {
    const double share = dot(axis, toward);
    if (share > 1e-9) least = std::min(least, depth / share);
  });
  return overlap ? least : 0;
}

HeightRange heights_of(const Block& block) {
  const Rotation& R = block.X_WX.R;
  const double reach = block.half.x * std::abs(R.x.z) + block.half.y * std::abs(R.y.z) +
                       block.half.z * std::abs(R.z.z);
  return {block.X_WX.p.z - reach, block.X_WX.p.z + reach};
}

PlanShape slab_of(const Block& block, HeightRange between) {
  const Vec3& half = block.half;
  std::array<Vec3, 8> corners;
  for (std::size_t i = 0; i < 8; ++i) {
    corners[i] =
        block.X_WX * Vec3{(i & 1U) != 0U ? half.x : -half.x, (i & 2U) != 0U ? half.y : -half.y,
                          (i & 4U) != 0U ? half.z : -half.z};
  }
  std::vector<PlanPoint> points;
  for (const Vec3& p : corners) {
    if (p.z >= between.low && p.z <= between.high) points.push_back(seen_from_above(p));
  }
  for (std::size_t i = 0; i < 8; ++i) {
    for (const std::size_t bit : {1U, 2U, 4U}) {
      if ((i & bit) != 0U) continue;
      const Vec3& a = corners[i];
      const Vec3& b = corners[i | bit];
      for (const double z : {between.low, between.high}) {
        if ((a.z < z) == (b.z < z)) continue;
        points.push_back(seen_from_above(a + (z - a.z) / (b.z - a.z) * (b - a)));
      }
    }
  }
  return hull_of(std::move(points));
}

}  // namespace sinew::sim
