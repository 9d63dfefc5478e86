#pragma once

#include "sinew/model/device_table.h"
#include "sinew/model/robot_model.h"

namespace sinew {

class TableReader;

/// No joint is faster than its board makes steps, as far as its drive is known.
void check_step_rates(TableReader& root, const RobotModel& model);
void read_axis_registers(TableReader& reader, const DeviceTable& kind, RobotModel& model);
void read_axis_link(TableReader& reader, const DeviceTable& kind, RobotModel& model);

}  // namespace sinew
