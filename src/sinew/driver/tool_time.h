#pragma once

#include <optional>

#include "sinew/driver/driver.h"

namespace sinew {

/// From a tool action's order until the driver says that it is done; zero where that is no more
/// than a question and its answer.
/// @param jaws  m: how wide they were told to be last since the port was opened, where they were
Duration tool_time(const RobotModel& robot, const ToolAction& action, std::optional<double> jaws);

}  // namespace sinew
