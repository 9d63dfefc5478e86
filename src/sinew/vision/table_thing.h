#pragma once

#include <optional>

#include "sinew/vision/cube_detection.h"
#include "sinew/vision/picture.h"
#include "sinew/vision/table_camera.h"

namespace sinew::vision {

/// What lies on the table at a pixel and is no cube: the rectangle around all that is connected
/// with it and has nearly its color, seen half an edge above the table, since how high it is is not
/// known. As high as a cube to be on the safe side.
/// @param edge  m, of the cubes there
/// @return  nothing where it looks like the table around it, is larger than kThingMost, or is
///          little more than a point
std::optional<ThingPosition> thing_position(const Picture& picture, const TableCamera& camera,
                                            Pixel middle, double edge);

/// m, from the middle of a thing to its farthest point: what is larger is no thing on the table.
inline constexpr double kThingMost = 0.06;

}  // namespace sinew::vision
