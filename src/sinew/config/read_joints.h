#pragma once

#include "sinew/config/read_geometry.h"
#include "sinew/config/table_reader.h"
#include "sinew/model/robot_model.h"

namespace sinew {

/// How many joints a geometry has.
std::size_t joints_moved_by(const Geometry& geometry);

/// Reads every [[joint]] into `model.joints`: legs with lengths for a hexapod, else revolute
/// joints. A leg has no home of its own: it follows from the platform's home pose, so that the two
/// cannot disagree.
void read_joints(TableReader& root, GeometryKind kind, RobotModel& model);

}  // namespace sinew
