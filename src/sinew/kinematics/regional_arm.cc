#include "sinew/kinematics/regional_arm.h"

#include <algorithm>
#include <cmath>

#include "sinew/core/error_code.h"
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
  lengths_squared_ = upper_arm_ * upper_arm_ + forearm_ * forearm_;
  inverse_product_ = 1 / (2 * upper_arm_ * forearm_);
  const double reach = upper_arm_ + forearm_ + kReachTolerance;
  const double inner = std::max(0.0, std::abs(upper_arm_ - forearm_) - kReachTolerance);
  squared_max_ = reach * reach;
  squared_min_ = inner * inner;
}

std::size_t RegionalArm::shoulders(const Vec3& p_BW, double theta1_near,
                                   std::array<ShoulderSide, 2>& out) const {
  if (!plane_holds(p_BW)) return 0;
  const SinCos free1 = sin_cos(theta1_near);
  out = {shoulder(p_BW, 1, free1), shoulder(p_BW, -1, free1)};
  return 2;
}

std::uint8_t RegionalArm::singular_bits(double spread, double sin_bend, double distance_squared) {
  const bool elbow =
      std::abs(sin_bend) < kSingularSine || distance_squared < kFreeDirection * kFreeDirection;
  return static_cast<std::uint8_t>((spread < kSingularDistance ? kShoulderBit : 0) |
                                   (elbow ? kElbowBit : 0));
}

bool RegionalArm::elbows(const ShoulderSide& side, double theta2_near,
                         std::array<ArmSide, 2>& out) const {
  if (!within_reach(side.x * side.x + side.y * side.y)) return false;
  const SinCos free2 = sin_cos(theta2_near);
  const double c1 = side.c1;
  const double s1 = side.s1;
  const Vec3 z_untwisted{sign1_ * s1, -sign1_ * c1, 0};
  for (std::size_t i = 0; i < 2; ++i) {
    const Elbow bent = elbow(side, i == 0 ? 1 : -1, free2);
    const Vec3 x3{bent.c23 * c1, bent.c23 * s1, sign1_ * bent.s23};
    const Vec3 y_untwisted{-bent.s23 * c1, -bent.s23 * s1, sign1_ * bent.c23};
    out[i] = {c1,
              s1,
              bent.c2,
              bent.s2,
              bent.cos_bend,
              bent.sin_bend,
              {x3, cos3_ * y_untwisted + sign3_ * z_untwisted,
               cos3_ * z_untwisted - sign3_ * y_untwisted},
              singular_bits(side.spread, bent.sin_bend, bent.distance_squared)};
  }
  return true;
}

Error RegionalArm::refusal(const Vec3& p_BW, std::span<const ShoulderSide> sides) const {
  if (sides.empty()) {
    return {ErrorCode::kTooClose, -1, std::hypot(p_BW.x, p_BW.y), std::abs(lateral_)};
  }
  const double reach = upper_arm_ + forearm_;
  const double inner = std::abs(upper_arm_ - forearm_);
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
