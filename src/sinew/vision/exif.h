#pragma once

#include <cstdint>
#include <span>

#include "sinew/vision/picture.h"

namespace sinew::vision {

/// How a picture has to be turned to stand upright: the tag Orientation of EXIF 2.3, 1 to 8.
/// @param tiff  an EXIF block behind its "Exif\0\0"
/// @return  1 where it does not say, or is no EXIF block
int exif_orientation(std::span<const std::uint8_t> tiff);

/// The same of a whole file: JPEG (APP1) or PNG (eXIf).
int orientation_of_file(std::span<const std::uint8_t> file);

/// @param orientation  1 to 8
Picture upright(Picture picture, int orientation);

}  // namespace sinew::vision
