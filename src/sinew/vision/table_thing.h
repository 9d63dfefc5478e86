#pragma once

#include <optional>

#include "sinew/vision/cube_detection.h"
#include "sinew/vision/picture.h"
#include "sinew/vision/table_camera.h"

namespace sinew::vision {

/// Bounding rectangle of an object on the table that is no cube: of the connected pixels of
/// similar color around `middle`. One camera does not show the height: pixels are projected to half
/// a cube's height, and the box is as high as a cube.
/// @param edge  m, of the cubes on this table
/// @return  nothing where the pixels look like the table around them, reach beyond kThingMost, or
///          are too few
std::optional<ThingPosition> thing_position(const Picture& picture, const TableCamera& camera,
                                            Pixel middle, double edge);

/// m, from the middle of an object to its farthest point.
inline constexpr double kThingMost = 0.06;

}  // namespace sinew::vision
