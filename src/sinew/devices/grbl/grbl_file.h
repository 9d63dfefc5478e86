#pragma once

#include "sinew/model/robot_model.h"

namespace sinew {

class TableReader;

void read_grbl(TableReader& reader, RobotModel& model);

}  // namespace sinew
