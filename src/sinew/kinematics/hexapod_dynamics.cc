#include "sinew/kinematics/hexapod_dynamics.h"

#include "sinew/core/assert.h"
#include "sinew/core/error_code.h"
#include "sinew/kinematics/inertia.h"

namespace sinew::kinematics {
namespace {

constexpr double kPivotMin = 1e-9;

LegLanes lanes(std::span<const double> values) {
  LegLanes lanes;
  for (std::size_t i = 0; i < kLegs; ++i) lanes[i] = values[i];
  return lanes;
}

Vec3 head(const TwistArray& v) {
  return {v[0], v[1], v[2]};
}
Vec3 tail(const TwistArray& v) {
  return {v[3], v[4], v[5]};
}

}  // namespace

Expected<JointVector> leg_forces(const Hexapod& hexapod, const PoseBP& X_BP,
                                 const PlatformMass& mass, const JointVector& qdd, double gravity) {
  SINEW_ASSERT(qdd.size() == kLegs);
  const HexapodJacobian J = hexapod.jacobian(X_BP);
  LegColumns columns, transposed;
  for (std::size_t i = 0; i < kLegs; ++i) {
    for (std::size_t k = 0; k < kTwistSize; ++k) {
      columns[k][i] = J[i][k];
      transposed[i][k] = J[i][k];
    }
  }
  TwistArray pivots_min;
  pivots_min.fill(kPivotMin);
  LegLu twist_of_legs, forces_of_wrench;
  if (!twist_of_legs.factor(columns, pivots_min) ||
      !forces_of_wrench.factor(transposed, pivots_min)) {
    const double value = hexapod.dexterity(X_BP).singular_value_min;
    return std::unexpected(Error{ErrorCode::kSingular, -1, value, kPivotMin});
  }
  const TwistArray acceleration = twist_of_legs.solve(lanes(qdd));
  const Vec3 alpha = tail(acceleration);
  const Vec3 a_P = head(acceleration) + Vec3{0, 0, gravity};
  const Vec3 p_PC_B = X_BP.R * mass.platform.p_JC;
  const Vec3 f_C = mass.platform.mass * (a_P + cross(alpha, p_PC_B));
  const Vec3 force = f_C + mass.payload * a_P;
  const Vec3 moment = cross(p_PC_B, f_C) + inertia_times(X_BP.R, mass.platform.inertia, alpha);
  const std::array wrench{force.x, force.y, force.z, moment.x, moment.y, moment.z};
  const TwistArray legs = forces_of_wrench.solve(lanes(wrench));
  return JointVector(std::span<const double>(legs));
}

}  // namespace sinew::kinematics
