#pragma once

#include <optional>
#include <span>
#include <vector>

#include "sinew/vision/picture.h"

namespace sinew::vision {

/// The corners of the smallest convex shape around points, clockwise on the screen; none three of
/// them on a line. @param points  by y, then by x
std::vector<Pixel> convex_hull(std::span<const Pixel> points);

/// px^2; of corners in either order.
double area_of(std::span<const Pixel> corners);

/// The four corners that keep most of a convex shape: corners are given up one by one, the one that
/// costs least area first. Nothing of fewer than four.
std::optional<Quad> four_corners(std::vector<Pixel> hull);

/// Whether a point is inside a convex shape with clockwise corners.
bool is_inside(std::span<const Pixel> corners, Pixel point);

/// px^2, of what two convex shapes with clockwise corners have in common.
double common_area(std::span<const Pixel> one, std::span<const Pixel> other);

/// About its middle.
Quad scaled(const Quad& quad, double factor);

/// Longest side over shortest; infinite where one has no length.
double side_ratio(const Quad& quad);
/// The most by which a corner is off a right angle. rad
double skew(const Quad& quad);
/// Of its sides, on the screen, mod 90 deg: 0 to pi/2. rad
double yaw(const Quad& quad);

}  // namespace sinew::vision
