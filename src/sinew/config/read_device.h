#pragma once

#include "sinew/config/table_reader.h"
#include "sinew/model/robot_model.h"

namespace sinew {

/// Reads [device]: the wire's name and what it can do, and the settings of the wires that this
/// version speaks.
void read_device(TableReader& root, RobotModel& model);

/// Whether the rest of the file asks for nothing that this device cannot do. @pre all of it is read
void check_device(TableReader& root, const RobotModel& model);

}  // namespace sinew
