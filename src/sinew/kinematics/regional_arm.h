#pragma once

#include <array>
#include <optional>
#include <span>

#include "sinew/core/error.h"
#include "sinew/core/rotation.h"
#include "sinew/model/robot_model.h"

namespace sinew::kinematics {

/// Below this the direction of a vector (m, or a sine) is only noise, and its joint is free.
inline constexpr double kFreeDirection = 1e-11;

/// One side of the first axis: theta1 as cosine and sine, and the target in the arm's plane, from
/// joint 2 along frame 1's axes x and y; m.
struct ShoulderSide {
  double c1 = 1, s1 = 0;
  double x = 0, y = 0;
  std::uint8_t singular = 0;  ///< Singularity bits of ik.h
};

/// Shoulder and elbow of one branch. theta2 and the elbow's bend (0 where the arm is straight) as
/// cosine and sine up to a positive factor.
struct ArmSide {
  double c1 = 1, s1 = 0;
  double c2 = 1, s2 = 0;
  double cos_bend = 1, sin_bend = 0;
  Rotation R_B3;
  std::uint8_t singular = 0;
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

  /// Why no elbow reaches the wrist, from the side that comes nearest; `sides` may be empty.
  Error refusal(const Vec3& p_BW, std::span<const ShoulderSide> sides) const;

  /// theta3 is the bend less this.
  double forearm_angle() const { return forearm_angle_; }
  /// sin(alpha1) = +-1: frame 1's y axis is this much up.
  double up() const { return sign1_; }

 private:
  RegionalArm(std::span<const DhRow> rows, double forearm_d);
  bool elbows(const ShoulderSide& side, double theta2_near, std::array<ArmSide, 2>& out) const;

  double d1_, a1_, lateral_, upper_arm_, forearm_;
  double forearm_cos_, forearm_sin_, forearm_angle_;
  double sign1_, sign3_, cos3_;
};

/// |value| is zero to the rounding of a robot's file.
bool is_zero(double value);
/// alpha is an odd multiple of 90 degrees.
bool is_right_angle(double alpha);

}  // namespace sinew::kinematics
