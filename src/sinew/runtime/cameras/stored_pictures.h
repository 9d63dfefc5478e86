#pragma once

#include <expected>
#include <string>
#include <string_view>

#include "sinew/runtime/cameras/camera_source.h"

namespace sinew::runtime {

/// @name Stored pictures instead of a camera, for dry runs: one for each call, each once
/// What cannot be decoded is passed over. kCameraLost at the end.
/// @error  a sentence with the path: not there, no permission, nothing in it that is read
/// @{

/// JPEG and PNG files of a folder, by name, numbers in names by their value.
std::expected<CameraSource, std::string> folder_pictures(const std::string& folder);
/// Frames of an AVI file with Motion JPEG.
std::expected<CameraSource, std::string> avi_pictures(const std::string& path);
/// Frames of a YUV4MPEG2 file.
std::expected<CameraSource, std::string> y4m_pictures(const std::string& path);
/// @}

/// Whether a comes before b: "table2.png" before "table10.png"; letters by their bytes.
bool comes_before(std::string_view a, std::string_view b);

/// Whether a name ends in .jpg, .jpeg or .png, in any case of letters.
bool is_image_name(std::string_view name);

}  // namespace sinew::runtime
