#pragma once

#include "sinew/core/pose.h"

namespace sinew::planning {

/// All points within `radius` (m) of the straight line from a to b, both in base B.
struct PlacedCapsule {
  Vec3 a;
  Vec3 b;
  double radius = 0;
};

/// A box with its middle at X.p, its edges along X.R and twice `half` (m) long.
struct PlacedBox {
  Pose<frame::Base, frame::Box> X;
  Vec3 half;
};

/// How far two bodies are apart, m; negative where they overlap: how far one of them has to be
/// shifted until they only touch. Continuous, and exact to 1e-10 m for bodies of robots' sizes.
///
/// Source: C. Ericson, Real-Time Collision Detection, 2005, 5.1.9 (lines), 4.4 (separating axes);
/// a line and a box: least square of its excess over the box, which is convex along the line.
/// @rt no allocation, no lock.
double distance(const PlacedCapsule& first, const PlacedCapsule& second);
double distance(const PlacedCapsule& capsule, const PlacedBox& box);
double distance(const PlacedBox& first, const PlacedBox& second);

/// From everything below z = `height` (m). @rt
double distance_above(const PlacedCapsule& capsule, double height);
double distance_above(const PlacedBox& box, double height);

}  // namespace sinew::planning
