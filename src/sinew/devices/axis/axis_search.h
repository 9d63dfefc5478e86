#pragma once

#include "sinew/devices/kind.h"

namespace sinew {

/// DeviceKind::search of both kinds of axis boards: the phases of axis_device_homing.h with the
/// settings of axis_device_settings.h.
ZeroSearch axis_search(const RobotModel& robot, std::size_t joint);

}  // namespace sinew
