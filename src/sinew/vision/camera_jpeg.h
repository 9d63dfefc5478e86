#pragma once

#include <cstdint>
#include <expected>
#include <span>
#include <string>

#include "sinew/vision/picture.h"

namespace sinew::vision {

/// A JPEG frame of a camera, an MJPEG stream or an AVI file, upright. Frames without Huffman tables
/// mean those of ISO/IEC 10918-1, annex K.3. Stricter than decode_picture: a frame that lost bytes
/// on its path is refused, since cubes in its spoiled part would be missing or in a wrong position.
/// @error  a sentence: no JPEG, damaged, cut short, too large
std::expected<Picture, std::string> decode_camera_jpeg(std::span<const std::uint8_t> frame);

}  // namespace sinew::vision
