#pragma once

#include "sinew/model/robot_model.h"
#include "sinew/toml/table_reader.h"

namespace sinew {

void read_arm_link(TableReader& reader, RobotModel& model);

}  // namespace sinew
