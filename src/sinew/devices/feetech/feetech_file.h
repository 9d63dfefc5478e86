#pragma once

#include "sinew/model/robot_model.h"
#include "sinew/toml/table_reader.h"

namespace sinew {

/// The [device] of servos on Feetech's bus. Complains about what is wrong.
void read_feetech(TableReader& reader, RobotModel& model);
/// Whether servos and ranges fit each other, once the whole file is read.
void check_feetech(TableReader& root, const RobotModel& model);

}  // namespace sinew
