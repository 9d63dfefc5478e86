#pragma once

#include <span>

#include "sinew/vision/picture.h"

namespace sinew::vision {

/// px^2; of corners in either order.
double area_of(std::span<const Pixel> corners);

/// px, of the square with the same area.
double edge_of(const Quad& quad);

/// Whether a point is inside a convex shape with clockwise corners.
bool is_inside(std::span<const Pixel> corners, Pixel point);

/// px^2, of what two convex shapes with clockwise corners have in common.
double common_area(std::span<const Pixel> one, std::span<const Pixel> other);

/// Of its sides, on the screen, mod 90 deg: 0 to pi/2. rad
double yaw(const Quad& quad);

}  // namespace sinew::vision
