#pragma once

#include "sinew/config/read_geometry.h"
#include "sinew/model/robot_model.h"
#include "sinew/toml/table_reader.h"

namespace sinew {

/// Reads every [[joint]] into `model.joints`: legs with lengths for a hexapod, else revolute
/// joints. A leg has no home of its own: it follows from the platform's home pose, so that the two
/// cannot disagree.
void read_joints(TableReader& root, GeometryKind kind, RobotModel& model);

}  // namespace sinew
