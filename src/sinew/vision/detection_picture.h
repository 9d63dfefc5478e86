#pragma once

#include "sinew/vision/cube_detection.h"

namespace sinew::vision {

/// The picture with all that was seen in it: the tops of cubes with their middles in green, what
/// was refused in magenta, each with its number: cubes from 1 on, behind them what was refused, in
/// the order of the detection. Below the picture a line each says what it is, or why it is no cube.
Picture detection_picture(Picture picture, const Detection& detection);

}  // namespace sinew::vision
