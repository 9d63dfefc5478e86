#pragma once

#include <string>

#include "sinew/cli/output/outcome.h"
#include "sinew/model/robot_model.h"
#include "sinew/sim/machine.h"

namespace sinew::cli {

/// Where a simulated machine really stands, which its wire never tells.
Json truth_json(const sim::Truth& truth, const RobotModel& model);
/// The same in one line: "base 12.03 deg (believes 12.00), ...; supply 7.4 V; at rest".
std::string truth_line(const sim::Truth& truth, const RobotModel& model);

}  // namespace sinew::cli
