#pragma once

#include <array>
#include <span>

#include "sinew/core/error.h"
#include "sinew/core/pose.h"
#include "sinew/model/robot_model.h"

namespace sinew::kinematics {

inline constexpr std::size_t kPalletizerJoints = 3;

/// Tool in base of a four-bar palletizer. The linkage keeps the tool level, so its frame is
/// parallel to the base, turned by the base alone: R_BT = Rz(base_front - q[0]). With the arm at
/// its front the tool's axes are the base's own.
///
/// Source: docs/kinematics/maxarm.md, eq. (1) to (5).
/// @param q  base, shoulder, forearm as the maker's firmware counts them, rad; any value is
///           computed as written, reachable or not.
/// @return   p in m, to 1e-15 times the arm's length; R to 1e-15 rad.
/// @rt       no allocation, no lock.
Pose<frame::Base, frame::Tool> forward(const PalletizerGeometry& geometry,
                                       std::span<const double> q);

/// Joint angles that put the nozzle at p_BT: closed form, elbow up, the only assembly that the
/// linkage has.
///
/// Source: docs/kinematics/maxarm.md, eq. (6) to (12).
/// @param joints  base, shoulder, forearm; their limits are inclusive (kJointLimitTolerance), and
///                of the turns of an angle the one nearest to the middle of its range is meant.
/// @param p_BT    nozzle in base B, m. On the base axis itself, where radius_min allows that, the
///                base angle is free and the front is chosen.
/// @return        3 angles, rad; |forward(q).p - p_BT| <= 1e-9 m.
/// @error         kTooClose (distance from the base axis against radius_min, or shoulder to
///                forearm end against the folded arm, m), kOutOfReach (shoulder to forearm end
///                against the stretched arm, m; a target that is not a number), kJointLimit (the
///                joint that is farthest outside of its limits, rad)
/// @rt            no allocation, no lock.
Expected<JointVector> inverse(const PalletizerGeometry& geometry, std::span<const Joint> joints,
                              const Vec3& p_BT);

/// Column, upper arm, forearm and tool in base B. Each lies along its frame's -y from the origin:
/// the column's origin is B's, the upper arm's the shoulder, the forearm's the elbow, the tool's
/// the nozzle; the x axes are all the tool's.
using PalletizerLinks = std::array<Pose<frame::Base, frame::Link>, kPalletizerJoints + 1>;

/// Source: docs/kinematics/maxarm.md, eq. (14) to (17).
/// @rt no allocation, no lock.
PalletizerLinks palletizer_links(const PalletizerGeometry& geometry, std::span<const double> q);

/// Column i is what joint i contributes to the velocity of the nozzle, in base B, m/rad. The tool
/// turns about the base's z at -qd[0], whatever the other joints do.
using PalletizerJacobian = std::array<Vec3, kPalletizerJoints>;

/// Source: docs/kinematics/maxarm.md, eq. (13).
/// @rt no allocation, no lock.
PalletizerJacobian jacobian(const PalletizerGeometry& geometry, std::span<const double> q);

}  // namespace sinew::kinematics
