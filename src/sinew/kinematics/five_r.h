#pragma once

#include <optional>
#include <span>

#include "sinew/kinematics/ik.h"
#include "sinew/kinematics/regional_arm.h"
#include "sinew/kinematics/serial_chain.h"

namespace sinew::kinematics {

using PoseBT = Pose<frame::Base, frame::Tool>;
using PoseFT = Pose<frame::Flange, frame::Tool>;

/// How far (rad) an orientation may be from what five joints can do before it is refused.
inline constexpr double kOrientationTolerance = 1e-9;

/// What an arm whose last four axes are parallel, parallel, parallel and along the tool can be
/// asked for. Its tool stays in the vertical plane through the first axis.
struct PitchTarget {
  Vec3 p_BT;         ///< tool tip in base, m
  double pitch = 0;  ///< approach axis from straight up, towards the target: 0 up, pi/2 level
  double roll = 0;   ///< R_BT = Rz(yaw) Ry(pitch) Rz(roll), yaw the direction of the plane
  double yaw = 0;    ///< of the plane; used only where p_BT stands on the first axis
};

/// Closed-form inverse of five revolute joints: a yaw, three parallel pitches, a roll along the
/// tool. Source: docs/kinematics/learm.md, both families of its section 3. @rt
class FiveRPitch {
 public:
  static std::optional<FiveRPitch> match(const SerialGeometry& geometry,
                                         std::span<const Joint> joints);

  /// All branches, up to 4: two families (plane and turned plane) of two elbows.
  /// @param X_FT  tool on flange: any length along the flange's z axis and any turn about it.
  /// @return |forward(q) - target| <= 1e-9 m and 1e-9 rad.
  /// @error  kOutOfReach, kTooClose (m, wrist from shoulder)
  Expected<IkBranches> inverse(const PitchTarget& target, const PoseFT& X_FT,
                               std::span<const double> near = {}) const;

  /// Pitch and roll of a full pose.
  /// @error kApproachOutOfPlane where the approach axis leaves the plane by over `tolerance` rad.
  Expected<PitchTarget> target(const PoseBT& X_BT, double tolerance = kOrientationTolerance) const;

  /// True where this tool can be used with the closed form.
  static bool suits(const PoseFT& X_FT);

 private:
  FiveRPitch(const SerialGeometry& geometry, std::span<const Joint> joints, const RegionalArm& arm);

  JointRanges ranges_;
  RegionalArm arm_;
  double a4_, d5_, sign1_, sign4_;
  std::array<double, 5> theta_offset_{};
};

/// What an arm with a rolling forearm and a bending wrist can be asked for: a point, and the
/// direction of the approach axis; the roll about that axis follows.
struct ApproachTarget {
  Vec3 p_BT;        ///< tool tip in base, m
  Vec3 approach_B;  ///< unit vector of the tool's z axis in base
};

/// Closed-form inverse of five revolute joints: a regional arm, a roll along the forearm and a
/// bend across it. Source: docs/kinematics/bigrobotarm.md. @rt
class FiveRRoll {
 public:
  /// Nothing where the tool does not point straight away from the wrist.
  static std::optional<FiveRRoll> match(const SerialGeometry& geometry,
                                        std::span<const Joint> joints);

  /// All branches, up to 8: two sides of the base, two elbows, two flips of the wrist.
  /// @return tip to 1e-9 m, approach axis to 1e-9 rad.
  /// @error  kOutOfReach, kTooClose (m, wrist from shoulder)
  Expected<IkBranches> inverse(const ApproachTarget& target,
                               std::span<const double> near = {}) const;

 private:
  FiveRRoll(const SerialGeometry& geometry, std::span<const Joint> joints, const RegionalArm& arm);

  JointRanges ranges_;
  RegionalArm arm_;
  double sign4_, tool_length_, tool_angle_;
  std::array<double, 5> theta_offset_{};
};

}  // namespace sinew::kinematics
