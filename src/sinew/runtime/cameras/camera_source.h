#pragma once

#include <chrono>
#include <functional>
#include <stop_token>

#include "sinew/core/error.h"
#include "sinew/core/instant.h"
#include "sinew/vision/picture.h"

namespace sinew::runtime {

/// How long after a look begins a picture has to come to count, where nothing says when it was
/// taken: what is under way by then was taken before.
inline constexpr Duration kPictureDelay = std::chrono::milliseconds(300);
/// So long a look waits for one.
inline constexpr Duration kPicturePatience = std::chrono::seconds(5);

/// The next picture that is taken from now on; may take its time, and gives up where the end is
/// asked for. For one thread.
/// @error  kCameraLost: none came
using CameraSource = std::function<Expected<vision::Picture>(const std::stop_token& ending)>;

}  // namespace sinew::runtime
