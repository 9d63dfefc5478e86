#pragma once

#include <span>

#include "sinew/vision/picture.h"
#include "sinew/vision/tags.h"

namespace sinew::calibration {

/// Width of the borders of tags in a picture, px: contrast over the steepest slope across a border,
/// median over all of them, in the direction in which the picture is softer. 2 in a sharp picture;
/// about the length of the path of a camera or a board that moved. 0 without tags.
double edge_width(const vision::Picture& picture, std::span<const vision::SeenTag> tags);

}  // namespace sinew::calibration
