#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <span>

#include "sinew/core/error.h"
#include "sinew/core/rotation.h"
#include "sinew/core/trig.h"
#include "sinew/kinematics/ik.h"
#include "sinew/model/robot_model.h"

namespace sinew::kinematics {

/// Below this the direction of a vector (m, or a sine) is only noise, and its joint is free.
inline constexpr double kFreeDirection = 1e-11;

/// One side of the first axis: theta1 as cosine and sine, and the target in the arm's plane, from
/// joint 2 along frame 1's axes x and y; m.
struct ShoulderSide {
  double c1 = 1, s1 = 0;
  double x = 0, y = 0;
  double spread = 0;  ///< m, half the way between the two sides: 0 where they meet
};

/// One elbow of a side. theta2, and the elbow's bend (0 where the arm is straight), as cosine and
/// sine up to a positive factor.
struct Elbow {
  double c2 = 1, s2 = 0;
  double cos_bend = 1, sin_bend = 0;
  double c23 = 1, s23 = 0;      ///< direction of frame 3's x axis in the arm's plane
  double distance_squared = 0;  ///< m^2, target from joint 2
};

/// Shoulder and elbow of one branch.
struct ArmSide {
  double c1 = 1, s1 = 0;
  double c2 = 1, s2 = 0;
  double cos_bend = 1, sin_bend = 0;
  Rotation R_B3;
  std::uint8_t singular = 0;  ///< Singularity bits of ik.h
};

/// The first three joints of most arms: a vertical axis and two parallel ones, which place the
/// wrist. Offsets between the first axis and the arm's plane (d2 + d3), along it (a1), and at the
/// elbow (a3 beside d4) are free. Derivation: docs/kinematics/six_r.md, eq. (3) to (9). @rt
class RegionalArm {
 public:
  /// @param forearm_d  length along the fourth axis that belongs to the forearm (d4), m.
  /// Nothing where the chain's first three rows are not such an arm.
  static std::optional<RegionalArm> match(std::span<const DhRow> rows, double forearm_d);

  /// Both sides from which the arm's plane can hold the point p_BW (m), or none.
  std::size_t shoulders(const Vec3& p_BW, double theta1_near,
                        std::array<ShoulderSide, 2>& out) const;

  /// Appends both elbows that put the wrist at (side.x, side.y), or none.
  template <std::size_t N>
  void append_elbows(const ShoulderSide& side, double theta2_near, std::array<ArmSide, N>& out,
                     std::size_t& count) const {
    std::array<ArmSide, 2> pair;
    if (!elbows(side, theta2_near, pair)) return;
    out[count++] = pair[0];
    out[count++] = pair[1];
  }

  /// Whether the arm's plane can hold p_BW: it may be too near to the first axis for the offset.
  bool plane_holds(const Vec3& p_BW) const {
    const double distance_min = std::max(0.0, std::abs(lateral_) - kReachTolerance);
    return p_BW.x * p_BW.x + p_BW.y * p_BW.y >= distance_min * distance_min;
  }

  /// One side of the first axis, `sign` +1 or -1, eq. (3) and (4); plane_holds() must be true.
  /// Without a branch in the code, so that a loop over sides works on several at once.
  /// @param free1  theta1 where p_BW stands on the first axis.
  ShoulderSide shoulder(const Vec3& p_BW, double sign, SinCos free1) const {
    const double k = -sign1_ * lateral_;
    const double rho_squared = p_BW.x * p_BW.x + p_BW.y * p_BW.y;
    const double spread_squared = rho_squared - k * k;
    const double spread = std::sqrt(spread_squared > 0 ? spread_squared : 0.0);
    const bool is_free = rho_squared < kFreeDirection * kFreeDirection;
    const double scale = 1 / rho_squared;
    const double u = sign * spread;
    // The turn that takes the vector (u, k) to (p.x, p.y).
    return {is_free ? sign * free1.cos : scale * (u * p_BW.x + k * p_BW.y),
            is_free ? sign * free1.sin : scale * (u * p_BW.y - k * p_BW.x), u - a1_,
            sign1_ * (p_BW.z - d1_), spread};
  }

  /// One elbow, `sign` +1 or -1, eq. (5) to (9), without a branch too; bent or straight as far as
  /// it goes where within_reach() is false.
  /// @param free2  theta2 where the target stands on joint 2.
  Elbow elbow(const ShoulderSide& side, double sign, SinCos free2) const {
    const double x = side.x;
    const double y = side.y;
    const double squared = x * x + y * y;
    const double cosine = (squared - lengths_squared_) * inverse_product_;
    const double below_1 = cosine < 1 ? cosine : 1.0;
    const double cos_bend = below_1 > -1 ? below_1 : -1.0;
    const double sin_bend = sign * std::sqrt(1 - cos_bend * cos_bend);
    const double along = upper_arm_ + forearm_ * cos_bend;
    const double across = forearm_ * sin_bend;
    const bool is_free = squared < kFreeDirection * kFreeDirection;
    const double scale = 1 / squared;
    const double c2 = is_free ? free2.cos : scale * (along * x + across * y);
    const double s2 = is_free ? free2.sin : scale * (along * y - across * x);
    // The forearm's direction, then frame 3's x axis, which it leads by a constant angle.
    const double c_forearm = c2 * cos_bend - s2 * sin_bend;
    const double s_forearm = s2 * cos_bend + c2 * sin_bend;
    return {c2,
            s2,
            cos_bend,
            sin_bend,
            c_forearm * forearm_cos_ + s_forearm * forearm_sin_,
            s_forearm * forearm_cos_ - c_forearm * forearm_sin_,
            squared};
  }

  bool within_reach(double distance_squared) const {
    return distance_squared <= squared_max_ && distance_squared >= squared_min_;
  }

  /// Shoulder and elbow bits of ik.h.
  static std::uint8_t singular_bits(double spread, double sin_bend, double distance_squared);

  /// Why no elbow reaches the wrist, from the side that comes nearest; `sides` may be empty.
  Error refusal(const Vec3& p_BW, std::span<const ShoulderSide> sides) const;

  /// theta3 is the bend less this.
  double forearm_angle() const { return forearm_angle_; }
  /// sin(alpha1) = +-1: frame 1's y axis is this much up.
  double up() const { return sign1_; }
  /// sin(alpha3): +-1, or 0 where the third axis is parallel to the fourth.
  double third_twist() const { return sign3_; }

 private:
  RegionalArm(std::span<const DhRow> rows, double forearm_d);
  bool elbows(const ShoulderSide& side, double theta2_near, std::array<ArmSide, 2>& out) const;

  double d1_, a1_, lateral_, upper_arm_, forearm_;
  double lengths_squared_, inverse_product_;  // of the law of cosines
  double squared_min_, squared_max_;          // m^2, reach
  double forearm_cos_, forearm_sin_, forearm_angle_;
  double sign1_, sign3_, cos3_;
};

/// |value| is zero to the rounding of a robot's file.
bool is_zero(double value);
/// alpha is an odd multiple of 90 degrees.
bool is_right_angle(double alpha);

}  // namespace sinew::kinematics
