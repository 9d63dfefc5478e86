#pragma once

#include "sinew/model/device_table.h"
#include "sinew/model/robot_model.h"

namespace sinew {

class TableReader;

inline constexpr DeviceTable kLscTable{"lsc", true, 0, 100, HandDrive::kJaws};

void read_lsc(TableReader& reader, RobotModel& model);

}  // namespace sinew
