#pragma once

#include "sinew/model/robot_model.h"

namespace sinew {

class TableReader;

/// No joint is faster than its board makes steps, as far as its drive is known.
void check_step_rates(TableReader& root, const RobotModel& model);
void read_axis_registers(TableReader& reader, RobotModel& model);
void read_axis_link(TableReader& reader, RobotModel& model);

}  // namespace sinew
