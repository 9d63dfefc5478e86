#pragma once

#include <optional>

#include "sinew/kinematics/serial_arm.h"

namespace sinew::program {

/// The pitch (rad) that misses a point (m, in base B) out of reach by least, to 0.5 deg; nothing
/// where no pitch is only out of reach.
std::optional<double> nearest_pitch(const kinematics::SerialArm& arm, const Vec3& p_BT);

}  // namespace sinew::program
