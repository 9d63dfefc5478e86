#pragma once

#include <span>
#include <vector>

#include "sinew/model/robot_model.h"
#include "sinew/motion/rest_to_rest.h"

namespace sinew::planning {

/// What the joints may do on a robot's device: the model's limits, and what its device leaves of
/// them.
std::vector<motion::AxisLimits> motion_limits(const RobotModel& model);

/// The same, as far as programs may ask for more (limit_reach()): what no motion is beyond.
std::vector<motion::AxisLimits> farthest_limits(const RobotModel& model);

/// What the speeds of all joints together may be, m/s (rad/s): infinite but for a device whose wire
/// all of them share.
double shared_velocity(const RobotModel& model);

/// motion_limits() of a move straight from one place to the other in joint space: what its joints
/// share is parted by their ways.
std::vector<motion::AxisLimits> straight_limits(const RobotModel& model,
                                                std::span<const double> from,
                                                std::span<const double> to);

}  // namespace sinew::planning
