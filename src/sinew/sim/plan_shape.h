#pragma once

#include <optional>
#include <vector>

#include "sinew/core/pose.h"

/// Convex shapes seen from above, in the plane of a table: what a quasi-static world of cubes is
/// computed with.
namespace sinew::sim {

/// A point or a step in the plane, m, in W.
struct PlanPoint {
  double x = 0;
  double y = 0;

  friend constexpr bool operator==(PlanPoint, PlanPoint) = default;
  friend constexpr PlanPoint operator+(PlanPoint a, PlanPoint b) { return {a.x + b.x, a.y + b.y}; }
  friend constexpr PlanPoint operator-(PlanPoint a, PlanPoint b) { return {a.x - b.x, a.y - b.y}; }
  friend constexpr PlanPoint operator*(double k, PlanPoint a) { return {k * a.x, k * a.y}; }
};

constexpr double dot(PlanPoint a, PlanPoint b) {
  return a.x * b.x + a.y * b.y;
}
/// Positive where b is to the left of a.
constexpr double cross(PlanPoint a, PlanPoint b) {
  return a.x * b.y - a.y * b.x;
}
double length(PlanPoint a);
/// Of length 1; x where `a` has no length.
PlanPoint direction_of(PlanPoint a);
constexpr PlanPoint seen_from_above(const Vec3& p_W) {
  return {p_W.x, p_W.y};
}

/// Corners of a convex shape, counterclockwise. Fewer than three: it fills nothing.
using PlanShape = std::vector<PlanPoint>;

/// @param yaw   rad, of its first edge
/// @param half  m, of its edges
PlanShape rectangle(PlanPoint middle, double yaw, PlanPoint half);

/// The smallest convex shape around all points.
PlanShape hull_of(std::vector<PlanPoint> points);

/// Whether a point lies within a shape, at least `inside` (m) from its edges.
bool contains(const PlanShape& shape, PlanPoint p, double inside = 0);

PlanShape common_part(const PlanShape& a, const PlanShape& b);

/// m^2
double area_of(const PlanShape& shape);

/// Mean of the corners. @pre at least one
PlanPoint middle_of(const PlanShape& shape);

/// Shortest step that takes `b` out of `a`; nothing where they do not overlap.
std::optional<PlanPoint> step_out(const PlanShape& a, const PlanShape& b);

/// How far `b` has to go along `toward` (length 1) to leave `a`, m; 0 where they do not overlap.
double slide_out(const PlanShape& a, const PlanShape& b, PlanPoint toward);

/// A box in space.
struct Block {
  Pose<frame::World, frame::Box> X_WX;  ///< its middle, along its edges
  Vec3 half;                            ///< m, of its edges
};

struct HeightRange {
  double low = 0;   ///< m, z in W
  double high = 0;  ///< m
};
/// From a block's lowest point to its highest.
HeightRange heights_of(const Block& block);

/// What of a block lies between two heights, seen from above.
PlanShape slab_of(const Block& block, HeightRange between);

}  // namespace sinew::sim
