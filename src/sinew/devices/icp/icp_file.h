#pragma once

#include "sinew/model/robot_model.h"

namespace sinew {

class TableReader;

void read_icp(TableReader& reader, RobotModel& model);

}  // namespace sinew
