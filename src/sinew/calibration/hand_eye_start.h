#pragma once

#include <span>
#include <vector>

#include "sinew/calibration/mount_chain.h"

namespace sinew::calibration {

struct MountStart {
  PoseMC X_MC;
  PoseNB X_NB;
  double misfit = 0;  ///< mean over the views of rad, and of m over the distance, both cut at 0.3
};

/// Mounts that nearly explain the board's pose in each view, the best first, at most four that
/// differ by 10 deg or more. A few poses may be wrong, as the second pose of a plane target is.
/// @param X_MN, X_CB  by view
std::vector<MountStart> mount_starts(std::span<const PoseMN> X_MN,
                                     std::span<const Pose<frame::Camera, frame::Board>> X_CB);

}  // namespace sinew::calibration
