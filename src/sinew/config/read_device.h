#pragma once

#include "sinew/model/robot_model.h"
#include "sinew/toml/table_reader.h"

namespace sinew {

/// Reads [device]: the name of its wire, and the rest as its kind has it.
void read_device(TableReader& root, RobotModel& model);

/// Whether the rest of the file asks for nothing that this device cannot do. @pre all of it is read
void check_device(TableReader& root, const RobotModel& model);

}  // namespace sinew
