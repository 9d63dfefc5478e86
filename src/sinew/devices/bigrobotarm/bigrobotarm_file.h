#pragma once

#include "sinew/model/robot_model.h"

namespace sinew {

struct BigRobotArmJoint;
class TableReader;

/// Steps of a joint and of its motor.
void read_motor(TableReader& table, BigRobotArmJoint& joint);
/// How far a joint of unknown position may be nudged.
void read_nudge(TableReader& reader, RobotModel& model);
void read_bigrobotarm(TableReader& reader, RobotModel& model);

}  // namespace sinew
