#pragma once

#include "sinew/model/robot_model.h"
#include "sinew/toml/table_reader.h"

namespace sinew {

/// Reads [drive.<joint>], [link.<joint>] and [control.<joint>]: what moves a joint, what hangs on
/// it, how its board holds it. Each is there for every joint or for none.
void read_dynamics(TableReader& root, RobotModel& model);

}  // namespace sinew
