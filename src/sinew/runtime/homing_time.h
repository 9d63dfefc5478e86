#pragma once

#include "sinew/model/robot_model.h"
#include "sinew/program/program_plan.h"

namespace sinew::runtime {

/// How long each axis board may search for its end stop and still find it, s: from the far end of
/// its way, with a switch that opens only where it would otherwise count as stuck. Real homing is
/// mostly half of that, since an axis rarely stands at its far end.
///
/// Source: the phases of device/homing.h with the settings of device/axis_settings.h.
/// @return  one per joint; empty for a robot without end stops
program::HomingTimes homing_times(const RobotModel& robot);

}  // namespace sinew::runtime
