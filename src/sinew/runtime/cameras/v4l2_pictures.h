#pragma once

#include <expected>
#include <string>

#include "sinew/io/v4l2_calls.h"
#include "sinew/io/video_modes.h"
#include "sinew/runtime/cameras/camera_source.h"

namespace sinew::runtime {

/// Pictures of a camera at this computer, as /dev/video0. The first call takes 1 s longer:
/// exposure, white balance and focus settle, and are kept from then on, also where the camera was
/// unplugged and comes back under its name.
/// @error  a sentence with the device and what to do: not there, no permission, used by another
///         program, no camera, not the wanted size
std::expected<CameraSource, std::string> v4l2_pictures(
    const std::string& device, const io::VideoWanted& wanted,
    const io::V4l2Calls& calls = io::system_v4l2_calls());

}  // namespace sinew::runtime
