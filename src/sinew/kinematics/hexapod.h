#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>

#include "sinew/core/error.h"
#include "sinew/core/fixed_vector.h"
#include "sinew/core/pose.h"
#include "sinew/core/units.h"
#include "sinew/kinematics/hexapod_linear.h"
#include "sinew/kinematics/leg_blocks.h"
#include "sinew/model/robot_model.h"

namespace sinew::kinematics {

using PoseBP = Pose<frame::Base, frame::Platform>;

/// forward() has found the pose when no leg is off by more than this, m.
inline constexpr double kHexapodResidual = 1e-12;

/// Factorisations that forward() spends at most; within 20 mm and 0.2 rad of the answer 4
/// are enough but for one start in a million.
inline constexpr int kHexapodIterationsMax = 16;

/// An answer turned by more than this from the last pose may be another assembly: refused, rad.
inline constexpr double kHexapodTurnMax = from_deg(30);

/// Row i turns the platform's twist into the rate of leg i, m/s: [s_i, R a_i x s_i] times
/// [velocity of P's origin, angular velocity], both in base B; s_i is the unit vector along leg i.
using HexapodJacobian = std::array<TwistArray, kLegs>;

/// How far a pose is from a singularity, with rotations scaled by the platform's radius so that a
/// number without a unit comes out.
struct HexapodDexterity {
  double singular_value_min = 0;
  double condition = 0;  ///< largest over smallest singular value; infinite at a singularity
};

/// Everything that is wrong with one pose: length, cardan and ball of each leg, the condition.
using HexapodViolations = FixedVector<Error, 3 * kLegs + 1>;

/// The pose that forward() found.
struct HexapodSolution {
  PoseBP X_BP;
  int iterations = 0;   ///< factorisations spent
  double residual = 0;  ///< m, bound of the largest leg error
};

/// Kinematics of a 6-UPS platform, with the constants of its geometry laid out once as lanes, one
/// lane per leg, so that the compiler works on several legs at a time. @rt
class Hexapod {
 public:
  explicit Hexapod(const HexapodGeometry& geometry);

  /// Leg lengths, anchor to anchor, m, at a pose of the platform; to 1e-15 m. Any pose has an
  /// answer; check() says whether the machine can take it.
  ///
  /// Source: docs/kinematics/hexapod.md, eq. (1) and (2).
  JointVector inverse(const PoseBP& X_BP) const;

  /// Pose of the platform at these legs, the one that continues X_BP_last: Newton's method with
  /// two corrections per factorisation, on squared lengths, rotations updated on SO(3).
  ///
  /// Source: docs/kinematics/hexapod.md, eq. (8) to (13).
  /// @param legs       six lengths, anchor to anchor, m.
  /// @param X_BP_last  the last pose known; its R a rotation to 1e-6 or better.
  /// @return           a pose whose legs are `legs` to kHexapodResidual; against the true pose
  ///                   1e-9 m and 1e-9 rad up to a condition number of 100. Near a singularity
  ///                   two assemblies meet: hold the answer against check().
  /// @error            kLegLength (a length that is not positive), kSingular (a platform on a
  ///                   singularity, with its smallest singular value), kNotConverged (remaining
  ///                   leg error, m), kAmbiguousAssembly (the answer is turned by more than
  ///                   kHexapodTurnMax from X_BP_last, or leg `index` swung farther than its
  ///                   cardan can)
  Expected<HexapodSolution> forward(const JointVector& legs, const PoseBP& X_BP_last) const;

  /// What stops the machine from taking this pose; empty where nothing does.
  ///
  /// Source: docs/kinematics/hexapod.md, eq. (3) to (5) and (7).
  /// @param legs  the six legs with their shortest and longest length, inclusive.
  /// @return      in the order of the legs kLegLength (m), kCardanAngle and kBallAngle (rad), each
  ///              with its leg, then kConditionNumber.
  HexapodViolations check(const PoseBP& X_BP, std::span<const Joint> legs) const;

  /// Source: docs/kinematics/hexapod.md, eq. (6).
  HexapodJacobian jacobian(const PoseBP& X_BP) const;

  /// Source: docs/kinematics/hexapod.md, eq. (7).
  HexapodDexterity dexterity(const PoseBP& X_BP) const;

 private:
  struct LaneVectors {
    LegLanes x, y, z;
  };
  /// A pose with what it does to the legs: vectors along them (u) and to the platform's anchors
  /// from its origin (r), both in B.
  struct Placement {
    LaneVectors u;
    LaneVectors r;
  };

  static LaneVectors lanes(const std::array<Vec3, kLegs>& vectors);
  Placement place(const PoseBP& X_BP) const;
  static LegLanes squared_lengths(const LaneVectors& u);
  static LegColumns squared_length_gradient(const Placement& placement);
  std::optional<Error> other_assembly(const PoseBP& X_BP, const PoseBP& X_BP_last,
                                      const LaneVectors& u, const LaneVectors& u_last) const;
  Error singular(const PoseBP& X_BP) const;

  LaneVectors p_BA_;
  LaneVectors p_PA_;
  std::array<Vec3, kLegs> motor_axis_B_;
  std::array<Vec3, kLegs> skewer_axis_P_;
  double cardan_angle_max_;
  double ball_angle_max_;
  double condition_max_;
  double platform_radius_;
  double cos_cardan_min_;
  double sin_ball_max_;
  double cos_turn_min_;
  double cos_swing_min_;
  LegSplit split_;
};

}  // namespace sinew::kinematics
