#pragma once

#include "sinew/cli/cameras/camera_verb.h"

namespace sinew::cli {

/// `sinew camera hand-eye`: where a camera is on the arm, or beside it, from images of a target and
/// the joints at which they were taken.
Outcome camera_hand_eye(const CameraRequest& request);

}  // namespace sinew::cli
