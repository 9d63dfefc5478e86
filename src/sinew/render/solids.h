#pragma once

#include "sinew/render/scene.h"

namespace sinew::render {

/// At a point of W (m), turned about z. rad
Pose<frame::World, frame::Solid> upright(double x, double y, double z, double turn);

/// In the middle between two points of W (m), with z along the way between them.
/// @pre the points differ
Pose<frame::World, frame::Solid> along(const Vec3& from, const Vec3& to);

/// A rod with round ends: all points within `radius` of the line from one point of W to the other.
/// A ball where they are one. m
void add_rod(Scene& scene, const Vec3& from, const Vec3& to, double radius,
             const Material& material);

}  // namespace sinew::render
