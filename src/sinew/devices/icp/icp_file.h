#pragma once

#include "sinew/model/device_table.h"
#include "sinew/model/robot_model.h"

namespace sinew {

class TableReader;

inline constexpr DeviceTable kIcpTable{"icp", true, kLegs, 1000, HandDrive::kNone};

void read_icp(TableReader& reader, RobotModel& model);

}  // namespace sinew
