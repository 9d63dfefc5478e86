#pragma once

#include <string>

#include "sinew/core/instant.h"
#include "sinew/runtime/camera_source.h"

namespace sinew::runtime {

/// How long after a look begins a picture has to be written to count: what programs that write
/// pictures have in hand by then was taken before.
inline constexpr Duration kPictureDelay = std::chrono::milliseconds(300);
/// So long a look waits for one.
inline constexpr Duration kPicturePatience = std::chrono::seconds(5);

/// Pictures of a camera that another program writes into one file, again and again (ffmpeg -update
/// 1, fswebcam). What is half written is read again.
CameraSource written_pictures(std::string path);

}  // namespace sinew::runtime
