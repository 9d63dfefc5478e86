#pragma once

#include <cstdint>
#include <span>

#include "sinew/kinematics/ik.h"
#include "sinew/kinematics/serial_chain.h"

namespace sinew::kinematics {

/// What the numeric solver has to meet: the whole pose, or only the flange's position.
enum class NumericTask : std::uint8_t { kPose, kPosition };

struct NumericOptions {
  NumericTask task = NumericTask::kPose;
  double position_tolerance = 1e-10;  ///< m
  double rotation_tolerance = 1e-10;  ///< rad
  int iterations_max = 40;            ///< of one attempt
  int attempts_max = 100;             ///< the first from the start, the others from random joints
  std::uint64_t seed = 1;             ///< of the random restarts: one seed, one answer
};

struct NumericSolution {
  JointVector q;  ///< inside the joint limits
  int attempts = 0;
  int iterations = 0;  ///< of all attempts together
};

/// Joint angles inside the limits that put the flange at X_BF, for any chain: damped least squares
/// whose damping follows the error (T. Sugihara, IEEE T-RO 27(5), 2011), joints at a limit held
/// while they push outwards or turned to their other limit where that is nearer on the circle,
/// restarts from random joints. Derivation: docs/kinematics/numeric.md.
///
/// @param start  rad; clamped into the limits. The answer is one branch, usually the nearest.
/// @error  kOutOfReach (m) where the lengths of the links cannot add up; kNotConverged with the
///         smallest remaining error, m: position and the arm's length times the rotation (rad),
///         as one vector.
/// @rt     bounded by attempts_max * iterations_max steps; no allocation, no lock.
Expected<NumericSolution> inverse_numeric(const SerialChain& chain, std::span<const Joint> joints,
                                          const PoseBF& X_BF, std::span<const double> start,
                                          const NumericOptions& options = {});

}  // namespace sinew::kinematics
