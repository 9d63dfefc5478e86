#include "sinew/kinematics/palletizer.h"

#include <algorithm>
#include <cmath>

#include "sinew/core/assert.h"
#include "sinew/core/error_code.h"
#include "sinew/core/units.h"
#include "sinew/kinematics/ik.h"

namespace sinew::kinematics {
namespace {

/// The turn of `angle` (rad) that lies nearest to the middle of the joint's range.
double nearest_turn(const Joint& joint, double angle) {
  const double middle = 0.5 * (joint.lower + joint.upper);
  // An angle that is already the right one passes through without a rounding.
  if (std::abs(angle - middle) <= kPi) return angle;
  return middle + std::remainder(angle - middle, 2 * kPi);
}

/// How far q is outside of the joint's limits, rad; <= 0 inside.
double excess(const Joint& joint, double q) {
  return std::max(joint.lower - q, q - joint.upper);
}

Expected<JointVector> refuse_outside_limits(std::span<const Joint> joints, const JointVector& q) {
  std::size_t worst = 0;
  for (std::size_t i = 1; i < q.size(); ++i) {
    if (excess(joints[i], q[i]) > excess(joints[worst], q[worst])) worst = i;
  }
  const Joint& joint = joints[worst];
  if (within_limits(joint, q[worst])) return q;
  const double limit = q[worst] < joint.lower ? joint.lower : joint.upper;
  return std::unexpected(
      Error{ErrorCode::kJointLimit, static_cast<std::int8_t>(worst), q[worst], limit});
}

}  // namespace

Pose<frame::Base, frame::Tool> forward(const PalletizerGeometry& geometry,
                                       std::span<const double> q) {
  SINEW_ASSERT(q.size() == kPalletizerJoints);
  const double r = geometry.shoulder_offset - geometry.upper_arm * std::cos(q[1]) +
                   geometry.forearm * std::cos(q[2]) + geometry.tool_offset;
  const double z = geometry.base_height + geometry.upper_arm * std::sin(q[1]) -
                   geometry.forearm * std::sin(q[2]);
  const Rotation R_BT = rotation_z(geometry.base_front - q[0]);
  return {R_BT, -r * R_BT.y + Vec3{0, 0, z}};
}

Expected<JointVector> inverse(const PalletizerGeometry& geometry, std::span<const Joint> joints,
                              const Vec3& p_BT) {
  SINEW_ASSERT(joints.size() == kPalletizerJoints);
  const double upper_arm = geometry.upper_arm;
  const double forearm = geometry.forearm;
  const double radius = std::hypot(p_BT.x, p_BT.y);
  const double r = radius - geometry.shoulder_offset - geometry.tool_offset;
  const double h = p_BT.z - geometry.base_height;
  const double d = std::hypot(r, h);
  const double stretched = upper_arm + forearm;
  const double folded = std::abs(upper_arm - forearm);
  // Written so that a target that is not a number fails.
  if (!(d <= stretched + kReachTolerance)) {
    return std::unexpected(Error{ErrorCode::kOutOfReach, -1, d, stretched});
  }
  if (radius < geometry.radius_min - kReachTolerance) {
    return std::unexpected(Error{ErrorCode::kTooClose, -1, radius, geometry.radius_min});
  }
  if (d < folded - kReachTolerance) {
    return std::unexpected(Error{ErrorCode::kTooClose, -1, d, folded});
  }
  const double cos_elbow = std::clamp(
      (upper_arm * upper_arm + forearm * forearm - d * d) / (2 * upper_arm * forearm), -1.0, 1.0);
  const double sin_elbow = std::sqrt((1 - cos_elbow) * (1 + cos_elbow));
  const double elbow = std::atan2(sin_elbow, cos_elbow);
  // Two-argument arc tangents all the way: behind the shoulder (r < 0) the arm leans back, it does
  // not fold over to the front, and near d = 0 nothing is divided.
  const double shoulder =
      std::atan2(h, r) + std::atan2(forearm * sin_elbow, upper_arm - forearm * cos_elbow);
  const double turn = radius > 0 ? std::atan2(p_BT.x, -p_BT.y) : 0;
  const JointVector q{nearest_turn(joints[0], geometry.base_front - turn),
                      nearest_turn(joints[1], kPi - shoulder),
                      nearest_turn(joints[2], kPi - (shoulder + elbow))};
  return refuse_outside_limits(joints, q);
}

PalletizerLinks palletizer_links(const PalletizerGeometry& geometry, std::span<const double> q) {
  const Pose<frame::Base, frame::Tool> X_BT = forward(geometry, q);
  const Vec3 outward_B = -X_BT.R.y;
  const Vec3 up_B = X_BT.R.z;
  const auto along = [&](double outward, double up) {
    return Rotation{X_BT.R.x, -outward * outward_B - up * up_B, outward * up_B - up * outward_B};
  };
  const Rotation R_upper = along(-std::cos(q[1]), std::sin(q[1]));
  const Rotation R_forearm = along(std::cos(q[2]), -std::sin(q[2]));
  const Vec3 shoulder = geometry.shoulder_offset * outward_B + geometry.base_height * up_B;
  const Vec3 elbow = shoulder - geometry.upper_arm * R_upper.y;
  return {{{X_BT.R, {}}, {R_upper, shoulder}, {R_forearm, elbow}, {X_BT.R, X_BT.p}}};
}

PalletizerJacobian jacobian(const PalletizerGeometry& geometry, std::span<const double> q) {
  const Pose<frame::Base, frame::Tool> X_BT = forward(geometry, q);
  const Vec3 outward_B = -X_BT.R.y;
  const auto in_plane = [&](double r_rate, double z_rate) {
    return r_rate * outward_B + Vec3{0, 0, z_rate};
  };
  return {Vec3{X_BT.p.y, -X_BT.p.x, 0},
          in_plane(geometry.upper_arm * std::sin(q[1]), geometry.upper_arm * std::cos(q[1])),
          in_plane(-geometry.forearm * std::sin(q[2]), -geometry.forearm * std::cos(q[2]))};
}

}  // namespace sinew::kinematics
