#pragma once

#include <functional>
#include <stop_token>

#include "sinew/core/error.h"
#include "sinew/vision/picture.h"

namespace sinew::runtime {

/// The next picture that is taken from now on; may take its time, and gives up where the end is
/// asked for. For one thread.
/// @error  kCameraLost: none came
using CameraSource = std::function<Expected<vision::Picture>(const std::stop_token& ending)>;

}  // namespace sinew::runtime
