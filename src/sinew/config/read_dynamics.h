#pragma once

#include "sinew/config/table_reader.h"
#include "sinew/model/robot_model.h"

namespace sinew {

/// Reads [drive.<joint>] and [link.<joint>]: what moves a joint, what hangs on it. Either is there
/// for every joint or for none.
void read_dynamics(TableReader& root, RobotModel& model);

}  // namespace sinew
