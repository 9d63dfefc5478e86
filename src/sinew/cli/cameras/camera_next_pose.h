#pragma once

#include <optional>
#include <span>

#include "sinew/calibration/hand_eye.h"
#include "sinew/model/robot_model.h"
#include "sinew/vision/tag_board.h"

namespace sinew::cli {

/// A view to add to a hand-eye calibration.
struct NextView {
  JointVector q;          ///< inside the limits, clear of the robot itself and of its table
  bool suffices = false;  ///< views like it can determine all directions; else marks have to be
                          ///< touched
};

/// Of some thousand poses around those of the views and all over the joints' ranges, the one that
/// adds most; the same for the same views.
/// @param joints  of the views
/// @return  nothing where none of them shows the target
std::optional<NextView> next_view(const RobotModel& model, const vision::CameraModel& camera,
                                  const calibration::HandEye& found,
                                  std::span<const JointVector> joints,
                                  const vision::TagBoard& target);

}  // namespace sinew::cli
