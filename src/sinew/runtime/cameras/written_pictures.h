#pragma once

#include <string>

#include "sinew/runtime/cameras/camera_source.h"

namespace sinew::runtime {

/// Pictures of a camera that another program writes into one file, again and again (ffmpeg -update
/// 1, fswebcam). What is half written is read again.
CameraSource written_pictures(std::string path);

}  // namespace sinew::runtime
