#pragma once

#include <vector>

#include "sinew/model/robot_model.h"
#include "sinew/motion/rest_to_rest.h"

namespace sinew::planning {

/// What the joints may do on a robot's device: the model's limits, and what its device leaves of
/// them.
std::vector<motion::AxisLimits> motion_limits(const RobotModel& model);

}  // namespace sinew::planning
