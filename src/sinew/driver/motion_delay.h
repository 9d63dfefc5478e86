#pragma once

#include "sinew/core/instant.h"
#include "sinew/model/device.h"

namespace sinew {

/// What a wire and its device add to a motion's own time, undisturbed. Commands take their time on
/// the wire, boards look at their port now and then, and a driver looks before it says that a
/// motion is done. docs/motion/arrival.md has where the numbers come from.
struct MotionDelay {
  Duration arrival{};  ///< from the motion's own end until the joints are there
  Duration report{};   ///< from the motion's own end until the driver says so
  /// Where each joint is told by itself and then goes at its own pace: how much later each further
  /// one begins. Zero where the joints go together.
  Duration each{};
};

MotionDelay motion_delay(const Device& device);

}  // namespace sinew
