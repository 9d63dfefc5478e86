#pragma once

#include <string_view>

#include "sinew/model/robot_model.h"

namespace sinew::test {

/// The built-in robot or example of that id, read once per process. An unknown id or a file with
/// complaints ends the test program and says why.
const RobotModel& robot(std::string_view id);

}  // namespace sinew::test
