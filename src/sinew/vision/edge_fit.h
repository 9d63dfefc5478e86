#pragma once

#include "sinew/vision/lab.h"
#include "sinew/vision/picture.h"

namespace sinew::vision {

/// Four corners, moved to where straight lines along the strongest changes of colour near each side
/// meet. As it was where a side has too few of them, or a corner would move far.
/// @param quad  clockwise, right to about 4 px
Quad fitted_to_edges(const LabPicture& picture, const Quad& quad);

}  // namespace sinew::vision
