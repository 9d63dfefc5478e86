#pragma once

#include "sinew/model/device_table.h"
#include "sinew/model/robot_model.h"

namespace sinew {

class TableReader;

void read_ideal(TableReader& reader, const DeviceTable& kind, RobotModel& model);

}  // namespace sinew
