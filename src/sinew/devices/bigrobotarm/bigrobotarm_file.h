#pragma once

#include "sinew/model/robot_model.h"

namespace sinew {

struct BigRobotArmJoint;
class TableReader;

/// Steps of a joint and of its motor.
void read_motor(TableReader& table, BigRobotArmJoint& joint);
void read_bigrobotarm(TableReader& reader, RobotModel& model);

}  // namespace sinew
