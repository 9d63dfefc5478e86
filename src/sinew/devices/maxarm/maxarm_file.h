#pragma once

#include "sinew/model/device_table.h"
#include "sinew/model/robot_model.h"

namespace sinew {

class TableReader;

inline constexpr DeviceTable kMaxArmTable{"maxarm", true, 3, 1000, HandDrive::kSuction};

void read_maxarm(TableReader& reader, RobotModel& model);

}  // namespace sinew
