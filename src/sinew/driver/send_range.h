#pragma once

#include <algorithm>

#include "sinew/driver/driver.h"
#include "sinew/model/robot_model.h"

namespace sinew {

/// Where a joint may be sent: inside its limits; rad, or m of a leg. @rt
struct SendRange {
  double lower = 0;
  double upper = 0;

  SendRange() = default;
  SendRange(const Joint& joint) : lower(joint.lower), upper(joint.upper) {}

  /// From beyond a limit (sagged, pushed by hand) also to every place between there and the limit.
  SendRange from(double here) const {
    SendRange range = *this;
    range.lower = std::min(lower, here);
    range.upper = std::max(upper, here);
    return range;
  }
  SendRange from(const JointPosition& here) const {
    return here.quality == PositionQuality::kLost ? *this : from(here.q);
  }

  /// False for a NaN.
  bool holds(double q) const {
    return q >= lower - kJointLimitTolerance && q <= upper + kJointLimitTolerance;
  }
};

}  // namespace sinew
