#pragma once

#include "sinew/kinematics/arm_dynamics.h"
#include "sinew/kinematics/hexapod.h"
#include "sinew/model/dynamics.h"

namespace sinew::kinematics {

/// What moves with the platform. Legs count as weightless.
struct PlatformMass {
  LinkMass platform;
  double payload = 0;  ///< kg, at the origin of P
};

/// N along each leg, positive where it pushes its ends apart, so that the platform at X_BP moves
/// with the leg accelerations `qdd` (m/s^2): J^T f = wrench. Torques that come with the platform's
/// speed are left out: at 1 mm/s they are below a millionth of the weight's.
///
/// Source: docs/torque.md, eq. (11) and (12).
/// @error  kSingular
/// @rt     no allocation, no lock.
Expected<JointVector> leg_forces(const Hexapod& hexapod, const PoseBP& X_BP,
                                 const PlatformMass& mass, const JointVector& qdd,
                                 double gravity = kGravity);

}  // namespace sinew::kinematics
