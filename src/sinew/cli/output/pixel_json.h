#pragma once

#include "sinew/cli/output/outcome.h"
#include "sinew/vision/picture.h"

namespace sinew::cli {

/// [x, y] in px, to a tenth.
Json pixel_json(vision::Pixel p);

}  // namespace sinew::cli
