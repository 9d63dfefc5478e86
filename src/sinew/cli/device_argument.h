#pragma once

#include <expected>

#include "sinew/cli/outcome.h"
#include "sinew/model/robot_model.h"

namespace sinew::cli {

/// The device settings of a robot whose wire this version speaks. The error is ready to be printed.
std::expected<BigRobotArmDevice, Outcome> big_robot_arm(const RobotModel& model);

/// Time scales that a simulation can keep up with: 0.01 to 100.
std::expected<void, Outcome> check_time_scale(double scale);

}  // namespace sinew::cli
