#pragma once

#include "sinew/model/robot_model.h"
#include "sinew/toml/table_reader.h"

namespace sinew {

/// Reads [collision]: the shapes of the robot's body, its table, and which links are not held
/// against each other. May be left out.
void read_collision(TableReader& root, RobotModel& model);

}  // namespace sinew
