#pragma once

#include <optional>
#include <span>

#include "sinew/kinematics/ik.h"
#include "sinew/kinematics/regional_arm.h"
#include "sinew/kinematics/serial_chain.h"

namespace sinew::kinematics {

/// Closed-form inverse of six revolute joints with a spherical wrist: a vertical first axis, two
/// parallel arm axes, three wrist axes through one point; any shoulder, lateral and elbow offset,
/// lengths, signs of the 90-degree twists and tool row.
///
/// Source: decoupled wrist (D. Pieper, 1968); derivation in docs/kinematics/six_r.md. @rt
class SixR {
 public:
  /// The solver of a chain that has this structure, else nothing.
  static std::optional<SixR> match(const SerialGeometry& geometry, std::span<const Joint> joints);

  /// Joint angles that put the flange at X_BF: all branches, up to 8.
  ///
  /// @param X_BF  flange F in base B; m.
  /// @param near  rad, one per joint or empty (zeros): picks full turns, and the free joint where
  ///              the pose is singular.
  /// @return      |forward(q) - X_BF| <= 1e-9 m and 1e-9 rad for every branch.
  /// @error       kOutOfReach, kTooClose (m, of the wrist from the shoulder)
  Expected<IkBranches> inverse(const PoseBF& X_BF, std::span<const double> near = {}) const;

 private:
  /// Sine and cosine of every angle, one row per joint and one column per arm, so that all angles
  /// come from one loop of arc tangents.
  struct Lanes {
    std::array<std::array<double, 4>, 6> sine{};
    std::array<std::array<double, 4>, 6> cosine{};
  };
  using Angles = std::array<std::array<double, 4>, 6>;  // a row per joint, a column per arm

  SixR(const SerialGeometry& geometry, std::span<const Joint> joints, const RegionalArm& arm);
  std::uint8_t wrist(const ArmSide& arm, const Rotation& R_B6, double theta4_near, std::size_t i,
                     Lanes& lanes) const;
  void write_branches(const Angles& theta, const std::array<ArmSide, 4>& arms,
                      std::size_t arm_count, std::span<const double> near,
                      IkBranches& branches) const;

  JointRanges ranges_;
  RegionalArm arm_;
  double sign4_, sign5_;  // sin(alpha_i) = +-1
  Vec3 p_6F_;             // flange in frame 6 before its twist
  double cos_alpha6_, sin_alpha6_;
  std::array<double, 6> theta_offset_{};
  std::array<double, 6> q_zero_{};  // what the angles above count from: q = angle - this
};

}  // namespace sinew::kinematics
