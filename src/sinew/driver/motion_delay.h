#pragma once

#include <optional>

#include "sinew/driver/driver.h"

namespace sinew {

/// What a wire and its device add to a motion's own time, undisturbed; the register wire's boards,
/// which are told one by one, have AxisRegisterTimes instead. Commands take their time on
/// the wire, boards look at their port now and then, and a driver looks before it says that a
/// motion is done. docs/motion/arrival.md has where the numbers come from.
struct MotionDelay {
  Duration arrival{};  ///< from the motion's own end until the joints are there
  Duration report{};   ///< from the motion's own end until the driver says so
};

MotionDelay motion_delay(const Device& device);

/// From a tool action's order until the driver says that it is done; zero where that is no more
/// than a question and its answer.
/// @param jaws  m: how wide they were told to be last since the port was opened, where they were
Duration tool_time(const RobotModel& robot, const ToolAction& action, std::optional<double> jaws);

}  // namespace sinew
