#pragma once

#include "sinew/model/robot_model.h"
#include "sinew/program/plans/program_plan.h"

namespace sinew::runtime {

/// What is known of a robot's homing before it runs: how long each axis board may search for its
/// end stop and still find it, s (from the far end of its way, with a switch that opens only where
/// it would otherwise count as stuck; real homing is mostly half of that, since an axis rarely
/// stands at its far end), and where the axes rest behind it.
///
/// Source: DeviceKind::search. Boards with another firmware may rest elsewhere.
/// @return  empty for a robot without end stops
program::Homing homing_of(const RobotModel& robot);

}  // namespace sinew::runtime
