#include "sinew/kinematics/five_r.h"

#include <algorithm>
#include <cmath>

#include "sinew/core/error_code.h"
#include "sinew/core/trig.h"

namespace sinew::kinematics {
namespace {

/// Angles of the first three joints of an arm, less their offsets.
void set_arm(const ArmSide& arm, double forearm_angle, std::span<const double, 5> theta_offset,
             IkBranch& branch) {
  branch.singular = arm.singular;
  branch.q.resize(5);
  branch.q[0] = arc_tangent(arm.s1, arm.c1) - theta_offset[0];
  branch.q[1] = arc_tangent(arm.s2, arm.c2) - theta_offset[1];
  branch.q[2] = arc_tangent(arm.sin_bend, arm.cos_bend) - forearm_angle - theta_offset[2];
}

}  // namespace

std::optional<FiveRPitch> FiveRPitch::match(const SerialGeometry& geometry,
                                            std::span<const Joint> joints) {
  const auto& rows = geometry.rows;
  if (rows.size() != 5 || joints.size() != 5) return std::nullopt;
  const bool parallel = is_zero(std::sin(rows[2].alpha)) && std::cos(rows[2].alpha) > 0;
  const bool wrist = is_right_angle(rows[3].alpha) && is_zero(rows[4].a) && is_zero(rows[4].alpha);
  const auto arm = RegionalArm::match(rows, 0);
  if (!parallel || !wrist || !arm || !suits(geometry.X_FT)) return std::nullopt;
  // With a lateral offset the second family stands in another plane; no known arm has one.
  if (!is_zero(rows[1].d + rows[2].d) || !is_zero(rows[3].d)) return std::nullopt;
  return FiveRPitch(geometry, joints, *arm);
}

FiveRPitch::FiveRPitch(const SerialGeometry& geometry, std::span<const Joint> joints,
                       const RegionalArm& arm)
    : ranges_(joints), arm_(arm) {
  const auto& rows = geometry.rows;
  a4_ = rows[3].a;
  d5_ = rows[4].d;
  sign1_ = std::copysign(1, std::sin(rows[0].alpha));
  sign4_ = std::copysign(1, std::sin(rows[3].alpha));
  for (std::size_t i = 0; i < 5; ++i) theta_offset_[i] = rows[i].theta_offset;
}

bool FiveRPitch::suits(const PoseFT& X_FT) {
  return std::hypot(X_FT.p.x, X_FT.p.y) < 1e-9 && std::hypot(X_FT.R.z.x, X_FT.R.z.y) < 1e-9 &&
         X_FT.R.z.z > 0;
}

Expected<PitchTarget> FiveRPitch::target(const PoseBT& X_BT, double tolerance) const {
  const Vec3& approach = X_BT.R.z;
  const double rho = std::hypot(X_BT.p.x, X_BT.p.y);
  const double level = std::hypot(approach.x, approach.y);
  PitchTarget target{.p_BT = X_BT.p};
  if (rho > kFreeDirection) {
    target.yaw = std::atan2(X_BT.p.y, X_BT.p.x);
  } else if (level > kFreeDirection) {
    target.yaw = std::atan2(approach.y, approach.x);
  }
  const SinCos yaw = sin_cos(target.yaw);
  const double along = yaw.cos * approach.x + yaw.sin * approach.y;
  const double across = yaw.cos * approach.y - yaw.sin * approach.x;
  const double out_of_plane = std::abs(std::atan2(across, std::hypot(along, approach.z)));
  if (!(out_of_plane <= tolerance)) {
    return std::unexpected(Error{ErrorCode::kApproachOutOfPlane, -1, out_of_plane, tolerance});
  }
  target.pitch = std::atan2(along, approach.z);
  const Rotation R_BP = rotation_z(target.yaw) * rotation_y(target.pitch);
  const Vec3 x_P = transposed_times(R_BP, X_BT.R.x);
  target.roll = std::atan2(x_P.y, x_P.x);
  return target;
}

Expected<IkBranches> FiveRPitch::inverse(const PitchTarget& target, const PoseFT& X_FT,
                                         std::span<const double> near) const {
  const auto theta_near = [&](std::size_t joint) {
    return (joint < near.size() ? near[joint] : 0) + theta_offset_[joint];
  };
  const bool on_axis = std::hypot(target.p_BT.x, target.p_BT.y) <= kFreeDirection;
  std::array<ShoulderSide, 2> sides;
  const std::size_t side_count =
      arm_.shoulders(target.p_BT, on_axis ? target.yaw : theta_near(0), sides);

  const SinCos pitch = sin_cos(target.pitch);
  const double tip = d5_ + X_FT.p.z;
  const double roll_tool = std::atan2(X_FT.R.x.y, X_FT.R.x.x);
  std::array<ArmSide, 4> arms;
  std::array<double, 4> theta234{};
  std::array<double, 4> theta5{};
  std::size_t count = 0;
  for (std::size_t i = 0; i < side_count; ++i) {
    // The second family stands with its back to the target, so the same approach leans away.
    const double side_sign = i == 0 ? 1 : -1;
    const double lean = side_sign * pitch.sin;
    const double s234 = sign4_ * lean;
    const double c234 = -sign4_ * sign1_ * pitch.cos;
    sides[i].x -= tip * lean + a4_ * c234;
    sides[i].y -= tip * sign1_ * pitch.cos + a4_ * s234;
    const std::size_t first = count;
    arm_.append_elbows(sides[i], theta_near(1), arms, count);
    for (std::size_t j = first; j < count; ++j) {
      theta234[j] = arc_tangent(s234, c234);
      // x4 is the plane's own x axis or its opposite, by the two twists; half a turn more for the
      // family that faces away.
      theta5[j] = target.roll - roll_tool + (sign1_ * sign4_ > 0 ? kPi : 0) + (i == 0 ? 0 : kPi);
    }
  }
  if (count == 0) return std::unexpected(arm_.refusal(target.p_BT, {sides.data(), side_count}));

  IkBranches branches;
  for (std::size_t i = 0; i < count; ++i) {
    IkBranch branch;
    set_arm(arms[i], arm_.forearm_angle(), theta_offset_, branch);
    const double theta2 = branch.q[1] + theta_offset_[1];
    const double theta3 = branch.q[2] + theta_offset_[2];
    branch.q[3] = theta234[i] - theta2 - theta3 - theta_offset_[3];
    branch.q[4] = theta5[i] - theta_offset_[4];
    ranges_.settle(branch, near);
    branches.push_back(branch);
  }
  return branches;
}

std::optional<FiveRRoll> FiveRRoll::match(const SerialGeometry& geometry,
                                          std::span<const Joint> joints) {
  const auto& rows = geometry.rows;
  if (rows.size() != 5 || joints.size() != 5) return std::nullopt;
  const bool wrist =
      is_right_angle(rows[2].alpha) && is_right_angle(rows[3].alpha) && is_zero(rows[3].a);
  const auto arm = RegionalArm::match(rows, rows[3].d);
  if (!wrist || !arm) return std::nullopt;
  // Tool tip and approach axis in frame 5 before its turn: both must point straight away from the
  // wrist, across axis 5.
  const SerialGeometry last{.rows = {rows[4]}, .X_FT = {}, .gripper = {}};
  const PoseBT X_5T = SerialChain(last).link(0, -rows[4].theta_offset) * geometry.X_FT;
  const double length = norm(X_5T.p);
  if (length < 1e-9 || norm(X_5T.p - length * X_5T.R.z) > 1e-9 || std::abs(X_5T.R.z.z) > 1e-9) {
    return std::nullopt;
  }
  FiveRRoll solver(geometry, joints, *arm);
  solver.tool_length_ = length;
  solver.tool_angle_ = std::atan2(X_5T.R.z.y, X_5T.R.z.x);
  return solver;
}

FiveRRoll::FiveRRoll(const SerialGeometry& geometry, std::span<const Joint> joints,
                     const RegionalArm& arm)
    : ranges_(joints), arm_(arm) {
  sign4_ = std::copysign(1, std::sin(geometry.rows[3].alpha));
  for (std::size_t i = 0; i < 5; ++i) theta_offset_[i] = geometry.rows[i].theta_offset;
}

Expected<IkBranches> FiveRRoll::inverse(const ApproachTarget& target,
                                        std::span<const double> near) const {
  const auto theta_near = [&](std::size_t joint) {
    return (joint < near.size() ? near[joint] : 0) + theta_offset_[joint];
  };
  const Vec3 p_BW = target.p_BT - tool_length_ * target.approach_B;
  std::array<ShoulderSide, 2> sides;
  std::array<ArmSide, 4> arms;
  std::size_t count = 0;
  const std::size_t side_count = arm_.shoulders(p_BW, theta_near(0), sides);
  for (std::size_t i = 0; i < side_count; ++i) {
    arm_.append_elbows(sides[i], theta_near(1), arms, count);
  }
  if (count == 0) return std::unexpected(arm_.refusal(p_BW, {sides.data(), side_count}));

  IkBranches branches;
  for (std::size_t i = 0; i < count; ++i) {
    // Approach axis in frame 3: theta4 turns it about z, theta5 bends it away from z.
    const Vec3 approach_3 = transposed_times(arms[i].R_B3, target.approach_B);
    const double bend = std::sqrt(approach_3.x * approach_3.x + approach_3.y * approach_3.y);
    const bool free = bend < kFreeDirection;
    const double theta4 = free ? theta_near(3) : arc_tangent(approach_3.y, approach_3.x);
    for (const double flip : {1.0, -1.0}) {
      IkBranch branch;
      set_arm(arms[i], arm_.forearm_angle(), theta_offset_, branch);
      if (bend < kSingularSine) branch.singular |= kWristBit;
      branch.q[3] = theta4 + (flip > 0 ? 0 : kPi) - theta_offset_[3];
      branch.q[4] =
          arc_tangent(sign4_ * approach_3.z, flip * bend) - tool_angle_ - theta_offset_[4];
      ranges_.settle(branch, near);
      branches.push_back(branch);
    }
  }
  return branches;
}

}  // namespace sinew::kinematics
