#include "sinew/kinematics/regional_arm.h"

#include <algorithm>
#include <cmath>

#include "sinew/core/trig.h"
#include "sinew/kinematics/ik.h"

namespace sinew::kinematics {

bool is_zero(double value) {
  return std::abs(value) < 1e-12;
}
bool is_right_angle(double alpha) {
  return is_zero(std::cos(alpha));
}

std::optional<RegionalArm> RegionalArm::match(std::span<const DhRow> rows, double forearm_d) {
  if (rows.size() < 3) return std::nullopt;
  const bool plane = is_right_angle(rows[0].alpha) && is_zero(std::sin(rows[1].alpha)) &&
                     std::cos(rows[1].alpha) > 0;
  const bool third = is_right_angle(rows[2].alpha) ||
                     (is_zero(std::sin(rows[2].alpha)) && std::cos(rows[2].alpha) > 0);
  const bool has_arm = rows[1].a > 1e-9 && std::hypot(rows[2].a, forearm_d) > 1e-9;
  if (!plane || !third || !has_arm) return std::nullopt;
  return RegionalArm(rows, forearm_d);
}

RegionalArm::RegionalArm(std::span<const DhRow> rows, double forearm_d)
    : d1_(rows[0].d),
      a1_(rows[0].a),
      lateral_(rows[1].d + rows[2].d),
      upper_arm_(rows[1].a),
      forearm_(std::hypot(rows[2].a, forearm_d)),
      sign1_(std::copysign(1, std::sin(rows[0].alpha))),
      sign3_(is_right_angle(rows[2].alpha) ? std::copysign(1, std::sin(rows[2].alpha)) : 0),
      cos3_(is_right_angle(rows[2].alpha) ? 0 : 1) {
  forearm_cos_ = rows[2].a / forearm_;
  forearm_sin_ = -sign3_ * forearm_d / forearm_;
  forearm_angle_ = std::atan2(forearm_sin_, forearm_cos_);
}

std::size_t RegionalArm::shoulders(const Vec3& p_BW, double theta1_near,
                                   std::array<ShoulderSide, 2>& out) const {
  const double k = -sign1_ * lateral_;
  const double y = sign1_ * (p_BW.z - d1_);
  const double rho_squared = p_BW.x * p_BW.x + p_BW.y * p_BW.y;
  const double rho = std::sqrt(rho_squared);
  if (rho < std::abs(k) - kReachTolerance) return 0;
  const double u = std::sqrt(std::max(0.0, rho_squared - k * k));
  const std::uint8_t singular = u < kSingularDistance ? kShoulderBit : 0;
  if (rho < kFreeDirection) {
    const SinCos near = sin_cos(theta1_near);
    out = {ShoulderSide{near.cos, near.sin, -a1_, y, singular},
           ShoulderSide{-near.cos, -near.sin, -a1_, y, singular}};
    return 2;
  }
  const double scale = 1 / rho_squared;
  const double ux = scale * u * p_BW.x;
  const double uy = scale * u * p_BW.y;
  const double kx = scale * k * p_BW.x;
  const double ky = scale * k * p_BW.y;
  // Eq. (4): the turn that takes the vector (u, k) to (p.x, p.y), once for each sign of u.
  out = {ShoulderSide{ux + ky, uy - kx, u - a1_, y, singular},
         ShoulderSide{ky - ux, -uy - kx, -u - a1_, y, singular}};
  return 2;
}

bool RegionalArm::elbows(const ShoulderSide& side, double theta2_near,
                         std::array<ArmSide, 2>& out) const {
  const auto& [c1, s1, x, y, shoulder_singular] = side;
  const double reach = upper_arm_ + forearm_ + kReachTolerance;
  const double inner = std::abs(upper_arm_ - forearm_) - kReachTolerance;
  const double squared = x * x + y * y;
  if (!(squared <= reach * reach) || (inner > 0 && squared < inner * inner)) return false;
  const double cosine =
      (squared - upper_arm_ * upper_arm_ - forearm_ * forearm_) / (2 * upper_arm_ * forearm_);
  const double cos_bend = std::clamp(cosine, -1.0, 1.0);
  const double sine = std::sqrt(1 - cos_bend * cos_bend);
  const bool wrist_on_shoulder = squared < kFreeDirection * kFreeDirection;
  const auto singular = static_cast<std::uint8_t>(
      shoulder_singular | (sine < kSingularSine || wrist_on_shoulder ? kElbowBit : 0));
  const double scale = 1 / squared;
  for (std::size_t i = 0; i < 2; ++i) {
    const double sin_bend = i == 0 ? sine : -sine;
    const double along = upper_arm_ + forearm_ * cos_bend;
    const double across = forearm_ * sin_bend;
    double c2 = scale * (along * x + across * y);
    double s2 = scale * (along * y - across * x);
    if (wrist_on_shoulder) {
      const SinCos near = sin_cos(theta2_near);
      c2 = near.cos;
      s2 = near.sin;
    }
    // The forearm's direction, then frame 3's x axis, which it leads by a constant angle.
    const double c_forearm = c2 * cos_bend - s2 * sin_bend;
    const double s_forearm = s2 * cos_bend + c2 * sin_bend;
    const double c23 = c_forearm * forearm_cos_ + s_forearm * forearm_sin_;
    const double s23 = s_forearm * forearm_cos_ - c_forearm * forearm_sin_;
    const Vec3 x3{c23 * c1, c23 * s1, sign1_ * s23};
    const Vec3 y_untwisted{-s23 * c1, -s23 * s1, sign1_ * c23};
    const Vec3 z_untwisted{sign1_ * s1, -sign1_ * c1, 0};
    out[i] = {c1,
              s1,
              c2,
              s2,
              cos_bend,
              sin_bend,
              {x3, cos3_ * y_untwisted + sign3_ * z_untwisted,
               cos3_ * z_untwisted - sign3_ * y_untwisted},
              singular};
  }
  return true;
}

Error RegionalArm::refusal(const Vec3& p_BW, std::span<const ShoulderSide> sides) const {
  if (sides.empty()) {
    return {ErrorCode::kTooClose, -1, std::hypot(p_BW.x, p_BW.y), std::abs(lateral_)};
  }
  const double reach = upper_arm_ + forearm_;
  const double inner = std::abs(upper_arm_ - forearm_);
  const auto excess = [](const Error& e) { return std::abs(e.measured - e.limit); };
  std::optional<Error> nearest;
  for (const ShoulderSide& side : sides) {
    const double distance = std::hypot(side.x, side.y);
    const Error error = distance > reach ? Error{ErrorCode::kOutOfReach, -1, distance, reach}
                                         : Error{ErrorCode::kTooClose, -1, distance, inner};
    if (!nearest || excess(error) < excess(*nearest)) nearest = error;
  }
  return *nearest;
}

}  // namespace sinew::kinematics
