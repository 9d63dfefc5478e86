#pragma once

#include <vector>

#include "sinew/planning/paths/planned_path.h"
#include "sinew/planning/paths/tool_space.h"

namespace sinew::planning {

/// Places s of a path, its end among them and its beginning not, such that a robot that goes from
/// one to the next with its joints straight stays on the path: the tool within `tolerance` (m, and
/// rad * kTurnRadius of its turn), looked at halfway between them, and no farther apart than
/// `longest` (m). For devices that take whole moves and no way.
///
/// @param X_near  a hexapod's pose at the path's beginning
std::vector<double> chords(const ToolSpace& space, const PlannedPath& path, double tolerance,
                           double longest, const PoseBT& X_near);

}  // namespace sinew::planning
