#include "sinew/kinematics/scara.h"

#include <algorithm>
#include <cmath>

#include "sinew/core/error_code.h"
#include "sinew/core/trig.h"
#include "sinew/kinematics/regional_arm.h"
#include "sinew/kinematics/serial_chain.h"

namespace sinew::kinematics {
namespace {

constexpr std::size_t kJoints = 4;
/// Axes nearer to each other than this (m) count as one.
constexpr double kOneAxis = 1e-6;

}  // namespace

std::optional<Scara> Scara::match(const SerialGeometry& geometry, std::span<const Joint> joints) {
  const auto& rows = geometry.rows;
  if (rows.size() != kJoints || joints.size() != kJoints) return std::nullopt;
  if (std::ranges::count(rows, JointKind::kPrismatic, &DhRow::kind) != 1) return std::nullopt;
  const auto upright = [](const DhRow& row) { return is_zero(std::sin(row.alpha)); };
  if (!std::ranges::all_of(rows, upright)) return std::nullopt;
  const Scara arm(geometry, joints);
  if (arm.upper_arm_.length < kOneAxis || arm.forearm_.length < kOneAxis) return std::nullopt;
  return arm;
}

Scara::Scara(const SerialGeometry& geometry, std::span<const Joint> joints) : ranges_(joints) {
  const SerialChain chain(geometry);
  std::array<Vec3, kJoints> origin;
  PoseBF X;  // of the frame whose z axis the joint has
  for (std::size_t i = 0, turns = 0; i < kJoints; ++i) {
    origin[i] = X.p;
    sign_[i] = std::copysign(1, X.R.z.z);
    (chain.slides(i) ? sliding_ : turning_[turns++]) = i;
    X = relabel<frame::Base, frame::Base>(X) * chain.link(i, 0);
  }
  const PoseBT X_BT = X * geometry.X_FT;
  const auto plane = [](const Vec3& v) {
    return Plane{std::hypot(v.x, v.y), std::atan2(v.y, v.x)};
  };
  p_first_ = origin[turning_[0]];
  upper_arm_ = plane(origin[turning_[1]] - origin[turning_[0]]);
  forearm_ = plane(origin[turning_[2]] - origin[turning_[1]]);
  hand_ = plane(X_BT.p - origin[turning_[2]]);
  z_zero_ = X_BT.p.z;
  R_zero_ = X_BT.R;
}

/// The turn about the vertical that brings the tool at q = 0 nearest to this orientation, rad: the
/// trace of what is left is largest there.
double Scara::turn_of(const Rotation& R_BT) const {
  const Rotation M = R_BT * R_zero_.transposed();
  return std::atan2(M.x.y - M.y.x, M.x.x + M.y.y);
}

Rotation Scara::nearest(const Rotation& R_BT) const {
  return rotation_z(turn_of(R_BT)) * R_zero_;
}

Rotation Scara::turned(double rz) const {
  const Vec3 rpy = fixed_xyz(R_zero_);
  return rotation_from_fixed_xyz({rpy.x, rpy.y, rz});
}

Expected<IkBranches> Scara::inverse(const PoseBT& X_BT, std::span<const double> near,
                                    double tolerance) const {
  const double turn = turn_of(X_BT.R);
  const double a = upper_arm_.length, b = forearm_.length;
  const double x = X_BT.p.x - p_first_.x - hand_.length * std::cos(turn + hand_.angle);
  const double y = X_BT.p.y - p_first_.y - hand_.length * std::sin(turn + hand_.angle);
  const double r = std::hypot(x, y);
  if (r > a + b + kReachTolerance) {
    return std::unexpected(Error{ErrorCode::kOutOfReach, -1, r, a + b});
  }
  if (r < std::abs(a - b) - kReachTolerance) {
    return std::unexpected(Error{ErrorCode::kTooClose, -1, r, std::abs(a - b)});
  }
  if (const double off = angle_between(rotation_z(turn) * R_zero_, X_BT.R); off > tolerance) {
    return std::unexpected(Error{ErrorCode::kOrientationNotReachable, -1, off, tolerance});
  }
  const double cosine = std::clamp((r * r - a * a - b * b) / (2 * a * b), -1.0, 1.0);
  const double sine = std::sqrt(1 - cosine * cosine);
  IkBranches branches;
  for (const double side : {1.0, -1.0}) {
    IkBranch branch;
    branch.q.resize(kJoints);
    const double bend = std::atan2(side * sine, cosine);
    double along = std::atan2(y, x) - std::atan2(b * side * sine, a + b * cosine);
    if (r < kFreeDirection) {  // folded onto its own axis: the first joint stays where it is
      along = upper_arm_.angle + sign_[turning_[0]] * (near.empty() ? 0 : near[turning_[0]]);
    }
    const double first = along - upper_arm_.angle;
    const double second = bend + upper_arm_.angle - forearm_.angle;
    branch.q[turning_[0]] = sign_[turning_[0]] * first;
    branch.q[turning_[1]] = sign_[turning_[1]] * second;
    branch.q[turning_[2]] = sign_[turning_[2]] * (turn - first - second);
    branch.q[sliding_] = sign_[sliding_] * (X_BT.p.z - z_zero_);
    if (sine < kSingularSine) branch.singular |= kElbowBit;
    if (r < kSingularDistance) branch.singular |= kShoulderBit;
    ranges_.settle(branch, near);
    branches.push_back(branch);
  }
  return branches;
}

double Scara::elbow_sine(std::span<const double> q) const {
  SINEW_ASSERT(q.size() == kJoints);
  const std::size_t elbow = turning_[1];
  return std::sin(sign_[elbow] * q[elbow] + forearm_.angle - upper_arm_.angle);
}

}  // namespace sinew::kinematics
