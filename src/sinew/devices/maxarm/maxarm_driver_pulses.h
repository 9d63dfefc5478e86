#pragma once

#include <array>
#include <cstdint>
#include <span>

#include "sinew/core/error.h"
#include "sinew/devices/maxarm/maxarm_settings.h"
#include "sinew/devices/maxarm/maxarm_wire.h"
#include "sinew/driver/send_range.h"
#include "sinew/model/device.h"
#include "sinew/model/robot_model.h"

namespace sinew {

/// What a servo may be told; one at 0 kills the MicroPython program.
inline constexpr std::int32_t kMaxArmPulseMin = 1;
inline constexpr std::int32_t kMaxArmPulseMax = 1000;

using MaxArmPulses = std::array<std::int32_t, maxarm::kServos>;

/// The pulses nearest to a place.
/// @param joints, q  base, shoulder, forearm; rad
/// @param here       where each of them is, where that is known: from beyond a limit the way back
///                   may be said too
/// @error kTaskNotSupported (another number of joints), kJointLimit (index, rad; also not a
///        number), kPulseRange (index, pulses)
/// @rt
Expected<MaxArmPulses> maxarm_pulses(const MaxArmDevice& device, std::span<const Joint> joints,
                                     std::span<const double> q,
                                     std::span<const JointPosition> here = {});

}  // namespace sinew
