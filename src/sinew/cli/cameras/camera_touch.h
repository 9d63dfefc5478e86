#pragma once

#include "sinew/cli/cameras/camera_verb.h"

namespace sinew::cli {

/// `sinew camera touch`: where the sheet lies, from marks that the robot's tool touched.
Outcome camera_touch(const CameraRequest& request);

}  // namespace sinew::cli
