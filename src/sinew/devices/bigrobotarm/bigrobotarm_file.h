#pragma once

#include "sinew/model/device_table.h"
#include "sinew/model/robot_model.h"

namespace sinew {

class TableReader;

inline constexpr DeviceTable kBigRobotArmTable{"bigrobotarm", true, 5, 1000, HandDrive::kServo};

void read_bigrobotarm(TableReader& reader, RobotModel& model);

}  // namespace sinew
