#pragma once

#include <array>
#include <cstdint>
#include <optional>

#include "sinew/devices/maxarm/maxarm_settings.h"
#include "sinew/model/device.h"
#include "sinew/model/robot_model.h"

namespace sinew::maxarm {

/// Servo pulses as the board sends them to its servos.
using ServoPulses = std::array<std::int32_t, 3>;

/// What the firmware's own inverse kinematics makes of SET_XYZ, with its faults: pulses are cut,
/// not rounded; an arc tangent of one argument folds the arm near its axis. Nothing: the program
/// ignores the target. On the Arduino program an unreachable one sends shoulder and forearm to 0.
///
/// Source: docs/wires/maxarm.md, "What the firmware makes of a point".
/// @rt no allocation, no lock.
std::optional<ServoPulses> firmware_pulses(const PalletizerGeometry& geometry,
                                           MaxArmVariant variant,
                                           const std::array<std::int16_t, 3>& xyz_mm);

/// What the firmware answers to READ_XYZ, from its servos' readings; mm. The MicroPython program
/// rounds half up before it cuts, so that negative numbers come out one too high.
/// @rt no allocation, no lock.
std::array<std::int16_t, 3> firmware_xyz(const PalletizerGeometry& geometry, MaxArmVariant variant,
                                         const std::array<std::int16_t, 3>& pulses);

}  // namespace sinew::maxarm
