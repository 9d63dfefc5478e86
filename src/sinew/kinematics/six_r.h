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

  /// The same on any processor, in the version that inverse() takes where there are no wide
  /// vectors.
  Expected<IkBranches> inverse_portable(const PoseBF& X_BF,
                                        std::span<const double> near = {}) const;

 private:
  static constexpr std::size_t kArms = 4;
  /// A row per joint, a column per arm (two sides of two elbows), laid out flat so that one plain
  /// loop serves all.
  using Angles = std::array<double, 6 * kArms>;
  /// What is known of the arms before any arc tangent: sines and cosines up to a positive factor,
  /// and the measures that say which of them are singular or out of reach.
  struct Arms {
    Angles sine, cosine;
    std::array<double, kArms> spread, distance_squared;
  };
  /// Where joints stay that a singular pose leaves free.
  struct FreeJoints {
    SinCos first, second, fourth;
  };

  SixR(const SerialGeometry& geometry, std::span<const Joint> joints, const RegionalArm& arm);
  void solve(const Vec3& p_BW, const Rotation& R_B6, FreeJoints free, Arms& arms) const;
  std::array<std::uint8_t, kArms> singular_bits(const Arms& arms) const;
  Expected<IkBranches> branches(const Arms& arms, const std::array<std::uint8_t, kArms>& singular,
                                std::span<const double> near) const;
  Error refusal(const Vec3& p_BW) const;

  JointRanges ranges_;
  RegionalArm arm_;
  double sign4_, sign5_;  // sin(alpha_i) = +-1
  Vec3 p_6F_;             // flange in frame 6 before its twist
  double cos_alpha6_, sin_alpha6_;
  std::array<double, 6> theta_offset_{};
  std::array<double, 6> q_zero_{};  // what the angles of Arms count from: q = angle - this
  FreeJoints free_at_zero_{};
};

}  // namespace sinew::kinematics
