#include "sinew/kinematics/six_r.h"

#include <cmath>

#include "sinew/core/dispatch.h"
#include "sinew/core/trig.h"
#include "sinew/core/unrolled.h"

namespace sinew::kinematics {

std::optional<SixR> SixR::match(const SerialGeometry& geometry, std::span<const Joint> joints) {
  const auto& rows = geometry.rows;
  if (rows.size() != 6 || joints.size() != 6) return std::nullopt;
  const bool twists = is_right_angle(rows[2].alpha) && is_right_angle(rows[3].alpha) &&
                      is_right_angle(rows[4].alpha);
  const bool wrist_in_one_point = is_zero(rows[3].a) && is_zero(rows[4].a) && is_zero(rows[4].d);
  const auto arm = RegionalArm::match(rows, rows[3].d);
  if (!twists || !wrist_in_one_point || !arm) return std::nullopt;
  return SixR(geometry, joints, *arm);
}

SixR::SixR(const SerialGeometry& geometry, std::span<const Joint> joints, const RegionalArm& arm)
    : ranges_(joints), arm_(arm) {
  const auto& rows = geometry.rows;
  sign4_ = std::copysign(1, std::sin(rows[3].alpha));
  sign5_ = std::copysign(1, std::sin(rows[4].alpha));
  p_6F_ = {rows[5].a, 0, rows[5].d};
  cos_alpha6_ = std::cos(rows[5].alpha);
  sin_alpha6_ = std::sin(rows[5].alpha);
  for (std::size_t i = 0; i < 6; ++i) theta_offset_[i] = q_zero_[i] = rows[i].theta_offset;
  q_zero_[2] += arm.forearm_angle();
  free_at_zero_ = {sin_cos(theta_offset_[0]), sin_cos(theta_offset_[1]), sin_cos(theta_offset_[3])};
}

/// All four arms: docs/kinematics/six_r.md eq. (3) to (12). Every lane takes the same way through
/// this loop, which is what makes it a vector's.
void SixR::solve(const Vec3& p_BW, const Rotation& R_B6, FreeJoints free, Arms& arms) const {
  constexpr std::array<double, kArms> kSide{1, 1, -1, -1};
  constexpr std::array<double, kArms> kElbow{1, -1, 1, -1};
  // Copies, so that nothing in the loop has to be read from memory that `arms` might overlap.
  const RegionalArm arm = arm_;
  const auto [x6, y6, z6] = R_B6;
  const Vec3 p = p_BW;
  const double sign5 = sign5_;
  const double sign45 = sign4_ * sign5_;
  const double up = arm.up();
  const double twist3 = arm.third_twist();
  for (std::size_t i = 0; i < kArms; ++i) {
    const ShoulderSide side = arm.shoulder(p, kSide[i], free.first);
    const Elbow elbow = arm.elbow(side, kElbow[i], free.second);
    // A vector of the base along frame 3's axes x and y, the latter across the arm's plane.
    const auto along_x3 = [&](const Vec3& v_B) {
      return elbow.c23 * (side.c1 * v_B.x + side.s1 * v_B.y) + up * elbow.s23 * v_B.z;
    };
    const auto along_y3 = [&](const Vec3& v_B) {
      return twist3 * up * (side.s1 * v_B.x - side.c1 * v_B.y);
    };
    const double z_36_x = along_x3(z6);
    const double z_36_y = along_y3(z6);
    const double z_36_z =
        twist3 * (elbow.s23 * (side.c1 * z6.x + side.s1 * z6.y) - up * elbow.c23 * z6.z);
    const double sin5 = std::sqrt(z_36_x * z_36_x + z_36_y * z_36_y);
    // Axes 4 and 6 in line: only their sum counts, and joint 4 keeps the angle it has.
    const bool is_free = sin5 < kFreeDirection;
    const double scale = sign5 / sin5;
    const double s4 = is_free ? free.fourth.sin : scale * z_36_y;
    const double c4 = is_free ? free.fourth.cos : scale * z_36_x;
    arms.sine[i] = side.s1;
    arms.cosine[i] = side.c1;
    arms.sine[kArms + i] = elbow.s2;
    arms.cosine[kArms + i] = elbow.c2;
    arms.sine[2 * kArms + i] = elbow.sin_bend;
    arms.cosine[2 * kArms + i] = elbow.cos_bend;
    arms.sine[3 * kArms + i] = s4;
    arms.cosine[3 * kArms + i] = c4;
    arms.sine[4 * kArms + i] = sin5;
    arms.cosine[4 * kArms + i] = -sign45 * z_36_z;
    // Joint 6 from the axis that joint 4 leaves it, so that their errors cancel near the
    // singularity.
    arms.sine[5 * kArms + i] = sign45 * (s4 * along_x3(x6) - c4 * along_y3(x6));
    arms.cosine[5 * kArms + i] = sign45 * (s4 * along_x3(y6) - c4 * along_y3(y6));
    arms.spread[i] = side.spread;
    arms.distance_squared[i] = elbow.distance_squared;
  }
}

std::array<std::uint8_t, SixR::kArms> SixR::singular_bits(const Arms& arms) const {
  std::array<std::uint8_t, kArms> bits{};
  for (std::size_t i = 0; i < kArms; ++i) {
    bits[i] = RegionalArm::singular_bits(arms.spread[i], arms.sine[2 * kArms + i],
                                         arms.distance_squared[i]);
    if (arms.sine[4 * kArms + i] < kSingularSine) bits[i] |= kWristBit;
  }
  return bits;
}

Expected<IkBranches> SixR::inverse(const PoseBF& X_BF, std::span<const double> near) const {
  return dispatched([&] { return inverse_portable(X_BF, near); });
}

Expected<IkBranches> SixR::inverse_portable(const PoseBF& X_BF,
                                            std::span<const double> near) const {
  // Frame 6 before its twist, and the wrist W: eq. (2).
  const Rotation R_B6{X_BF.R.x, cos_alpha6_ * X_BF.R.y - sin_alpha6_ * X_BF.R.z,
                      sin_alpha6_ * X_BF.R.y + cos_alpha6_ * X_BF.R.z};
  const Vec3 p_BW = X_BF.p - R_B6 * p_6F_;
  if (!arm_.plane_holds(p_BW)) return std::unexpected(arm_.refusal(p_BW, {}));
  Arms arms;
  solve(p_BW, R_B6, free_at_zero_, arms);
  if (!arm_.within_reach(arms.distance_squared[0]) &&
      !arm_.within_reach(arms.distance_squared[2])) {
    return std::unexpected(refusal(p_BW));
  }
  const auto singular = singular_bits(arms);
  if (!near.empty() && (singular[0] | singular[1] | singular[2] | singular[3]) != 0) {
    const auto near_theta = [&](std::size_t j) { return sin_cos(near[j] + theta_offset_[j]); };
    solve(p_BW, R_B6, {near_theta(0), near_theta(1), near_theta(3)}, arms);
  }
  return branches(arms, singular, near);
}

/// Both flips of the wrist of every arm within reach, eq. (13), next to `near`.
Expected<IkBranches> SixR::branches(const Arms& arms,
                                    const std::array<std::uint8_t, kArms>& singular,
                                    std::span<const double> near) const {
  Angles theta;
  for (std::size_t k = 0; k < theta.size(); ++k) {
    theta[k] = arc_tangent(arms.sine[k], arms.cosine[k]);
  }
  std::array<std::array<double, 2 * kArms>, 6> q;  // the arms, then the same with the wrist flipped
  for (std::size_t i = 0; i < kArms; ++i) {
    for (std::size_t j = 0; j < 6; ++j) q[j][i] = theta[j * kArms + i] - q_zero_[j];
    for (std::size_t j = 0; j < 3; ++j) q[j][kArms + i] = q[j][i];
    q[3][kArms + i] = q[3][i] + kPi;
    q[4][kArms + i] = -theta[4 * kArms + i] - q_zero_[4];
    q[5][kArms + i] = q[5][i] + kPi;
  }
  const std::array<double, 2 * kArms> outside = ranges_.settle(q, near);

  Expected<IkBranches> found(std::in_place);
  for (std::size_t k = 0; k < 2 * kArms; ++k) {
    const std::size_t arm = k / 2;
    const std::size_t lane = arm + kArms * (k % 2);
    if (!arm_.within_reach(arms.distance_squared[arm])) continue;
    found->resize(found->size() + 1);
    IkBranch& branch = found->back();
    branch.q.resize(6);
    double* const joints = branch.q.data();
    unrolled<6>([&](auto j) { joints[j] = q[j][lane]; });
    branch.within_limits = outside[lane] <= 0;
    branch.singular = singular[arm];
  }
  return found;
}

Error SixR::refusal(const Vec3& p_BW) const {
  std::array<ShoulderSide, 2> sides;
  const std::size_t count = arm_.shoulders(p_BW, 0, sides);
  return arm_.refusal(p_BW, {sides.data(), count});
}

}  // namespace sinew::kinematics
