#pragma once

#include "sinew/model/robot_model.h"

namespace sinew {

class TableReader;

/// As far as the drives are known: no joint is faster than its board makes steps, and an encoder on
/// RS-485 is an AS5600.
void check_axis_boards(TableReader& root, const RobotModel& model);
void read_axis_registers(TableReader& reader, RobotModel& model);
void read_axis_link(TableReader& reader, RobotModel& model);

}  // namespace sinew
