#pragma once

#include <cstddef>
#include <expected>
#include <string>

#include "sinew/vision/picture.h"

namespace sinew::runtime {

/// A JPEG or PNG file, upright; or a sentence that names it.
/// @param bytes_max  of the file; where left out a PNG of all pixels that are read
std::expected<vision::Picture, std::string> read_picture(const std::string& path,
                                                         std::size_t bytes_max = std::size_t{256}
                                                                                 << 20U);

}  // namespace sinew::runtime
