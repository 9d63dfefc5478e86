#include "sinew/kinematics/six_r.h"

#include <cmath>

#include "sinew/core/trig.h"

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
}

/// The wrist of one arm, docs/kinematics/six_r.md eq. (10) to (13); returns the singularity bit.
std::uint8_t SixR::wrist(const ArmSide& arm, const Rotation& R_B6, double theta4_near,
                         std::size_t i, Lanes& lanes) const {
  const Vec3 z_36 = transposed_times(arm.R_B3, R_B6.z);
  const double sin5 = std::sqrt(z_36.x * z_36.x + z_36.y * z_36.y);
  SinCos four;
  if (sin5 < kFreeDirection) {
    // Axes 4 and 6 are in line and only their sum counts: joint 4 keeps the angle it has.
    four = sin_cos(theta4_near);
  } else {
    const double scale = sign5_ / sin5;
    four = {scale * z_36.y, scale * z_36.x};
  }
  // Joint 6 from the axis that joint 4 leaves it, so that their errors cancel near the singularity.
  const Vec3 z_B4 = sign4_ * (four.sin * arm.R_B3.x - four.cos * arm.R_B3.y);
  lanes.sine[3][i] = four.sin;
  lanes.cosine[3][i] = four.cos;
  lanes.sine[4][i] = sin5;
  lanes.cosine[4][i] = -sign4_ * sign5_ * z_36.z;
  lanes.sine[5][i] = sign5_ * dot(z_B4, R_B6.x);
  lanes.cosine[5][i] = sign5_ * dot(z_B4, R_B6.y);
  return sin5 < kSingularSine ? kWristBit : 0;
}

Expected<IkBranches> SixR::inverse(const PoseBF& X_BF, std::span<const double> near) const {
  // Frame 6 before its twist, and the wrist W: eq. (2).
  const Rotation R_B6{X_BF.R.x, cos_alpha6_ * X_BF.R.y - sin_alpha6_ * X_BF.R.z,
                      sin_alpha6_ * X_BF.R.y + cos_alpha6_ * X_BF.R.z};
  const Vec3 p_BW = X_BF.p - R_B6 * p_6F_;
  const auto theta_near = [&](std::size_t joint) {
    return (joint < near.size() ? near[joint] : 0) + theta_offset_[joint];
  };

  std::array<ShoulderSide, 2> sides;
  std::array<ArmSide, 4> arms;
  const std::size_t side_count = arm_.shoulders(p_BW, theta_near(0), sides);
  std::size_t arm_count = 0;
  for (std::size_t i = 0; i < side_count; ++i) {
    arm_.append_elbows(sides[i], theta_near(1), arms, arm_count);
  }
  if (arm_count == 0) return std::unexpected(arm_.refusal(p_BW, {sides.data(), side_count}));

  Lanes lanes;
  for (std::size_t i = 0; i < arm_count; ++i) {
    const ArmSide& arm = arms[i];
    lanes.sine[0][i] = arm.s1;
    lanes.cosine[0][i] = arm.c1;
    lanes.sine[1][i] = arm.s2;
    lanes.cosine[1][i] = arm.c2;
    lanes.sine[2][i] = arm.sin_bend;
    lanes.cosine[2][i] = arm.cos_bend;
    arms[i].singular |= wrist(arm, R_B6, theta_near(3), i, lanes);
  }
  std::array<std::array<double, 4>, 6> q;
  for (std::size_t j = 0; j < 6; ++j) {
    for (std::size_t i = 0; i < 4; ++i) {
      q[j][i] = arc_tangent(lanes.sine[j][i], lanes.cosine[j][i]);
    }
  }
  Expected<IkBranches> branches(std::in_place);
  write_branches(q, arms, arm_count, near, *branches);
  return branches;
}

/// Both flips of the wrist of every arm, eq. (13), as joint angles next to `near`.
void SixR::write_branches(const Angles& theta, const std::array<ArmSide, 4>& arms,
                          std::size_t arm_count, std::span<const double> near,
                          IkBranches& branches) const {
  std::array<std::array<double, 8>, 6> q;  // 4 arms, then the same with the wrist flipped
  for (std::size_t i = 0; i < 4; ++i) {
    for (std::size_t j = 0; j < 6; ++j) q[j][i] = theta[j][i] - q_zero_[j];
    for (std::size_t j = 0; j < 3; ++j) q[j][4 + i] = q[j][i];
    q[3][4 + i] = q[3][i] + kPi;
    q[4][4 + i] = -theta[4][i] - q_zero_[4];
    q[5][4 + i] = q[5][i] + kPi;
  }
  const std::array<double, 8> outside = ranges_.settle(q, near);
  branches.resize(2 * arm_count);
  for (std::size_t k = 0; k < 2 * arm_count; ++k) {
    const std::size_t arm = k / 2;
    const std::size_t lane = arm + 4 * (k % 2);
    IkBranch& branch = branches[k];
    branch.q.resize(6);
    for (std::size_t j = 0; j < 6; ++j) branch.q[j] = q[j][lane];
    branch.within_limits = outside[lane] <= 0;
    branch.singular = arms[arm].singular;
  }
}

}  // namespace sinew::kinematics
