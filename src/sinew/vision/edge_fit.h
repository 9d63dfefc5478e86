#pragma once

#include "sinew/vision/lab.h"
#include "sinew/vision/picture.h"

namespace sinew::vision {

/// Four corners, moved to where straight lines along the strongest changes of colour near each side
/// meet. As it was where a side has too few of them, or a corner would move far.
/// @param quad  clockwise
/// @param reach  px to either side of where an edge is looked for
Quad fitted_to_edges(const LabPicture& picture, const Quad& quad, double reach);

/// A square under perspective, turned about its middle until the picture has edges along all its
/// sides; as it is where no turn is clearly better.
Quad turned_to_edges(const LabPicture& picture, const Quad& quad);

/// How many corners of a quad look like what is inside of it, not like what is outside: 4 of a
/// square, 0 or 1 of a disc.
int corners_filled(const LabPicture& picture, const Quad& quad);

/// Share of a quad, but for its border, that is clearly lighter (25 of L*) than its dark fifth:
/// about a half of a black and white print, at most a quarter of a black face with a letter.
double light_share(const LabPicture& picture, const Quad& quad);

}  // namespace sinew::vision
