#pragma once

#include <expected>
#include <string>

#include "sinew/cli/outcome.h"
#include "sinew/vision/picture.h"

namespace sinew::cli {

/// A JPEG or PNG file, upright; or a sentence that names it.
std::expected<vision::Picture, std::string> read_picture(const std::string& path);

/// [x, y] in px, to a tenth.
Json pixel_json(vision::Pixel p);

}  // namespace sinew::cli
