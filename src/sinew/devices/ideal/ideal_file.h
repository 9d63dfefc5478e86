#pragma once

#include "sinew/model/device_table.h"
#include "sinew/model/robot_model.h"

namespace sinew {

class TableReader;

inline constexpr DeviceTable kIdealTable{"ideal", true, 0, 0, HandDrive::kJaws};

void read_ideal(TableReader& reader, RobotModel& model);

}  // namespace sinew
