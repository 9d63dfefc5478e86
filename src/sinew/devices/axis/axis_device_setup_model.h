#pragma once

#include <cstddef>

#include "sinew/devices/axis/axis_device_setup.h"
#include "sinew/model/robot_model.h"

namespace sinew {

/// What the board of `joint` must be set up with; degrees of the register wire count from the
/// joint's lower limit where the robot's file is for another wire.
AxisSetup axis_setup(const RobotModel& model, std::size_t joint);

}  // namespace sinew
