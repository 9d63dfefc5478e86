#pragma once

#include <array>
#include <optional>
#include <span>

#include "sinew/kinematics/five_r.h"
#include "sinew/kinematics/ik.h"

namespace sinew::kinematics {

/// Closed-form inverse of a SCARA: four joints with vertical axes, three that turn and one that
/// slides, in any order. The tool turns about the vertical and keeps its tilt.
/// Source: docs/kinematics/scara.md. @rt
class Scara {
 public:
  /// @param geometry  with the tool on its flange
  /// @return nothing where the structure is another one, or two axes that turn coincide
  static std::optional<Scara> match(const SerialGeometry& geometry, std::span<const Joint> joints);

  /// Both elbows.
  /// @param tolerance  rad by which the tool's tilt may be off; it is bent to the arm's own
  /// @return |forward(q) - target| <= 1e-9 m and 1e-9 rad, of a target with the arm's tilt
  /// @error  kOutOfReach, kTooClose (m, wrist from the first axis that turns),
  ///         kOrientationNotReachable (rad)
  Expected<IkBranches> inverse(const PoseBT& X_BT, std::span<const double> near = {},
                               double tolerance = kOrientationTolerance) const;

  /// The orientation nearest to this one that the tool can have.
  Rotation nearest(const Rotation& R_BT) const;
  /// The orientation that it has where its turn about the vertical, the last of three about fixed
  /// axes, is `rz` (rad).
  Rotation turned(double rz) const;

  /// Sine of the elbow's bend at q: 0 where the arm is straight or folded.
  double elbow_sine(std::span<const double> q) const;

 private:
  /// A vector across the axes.
  struct Plane {
    double length = 0;
    double angle = 0;
  };

  Scara(const SerialGeometry& geometry, std::span<const Joint> joints);
  double turn_of(const Rotation& R_BT) const;

  JointRanges ranges_;
  std::array<std::size_t, 3> turning_{};  ///< the joints that turn, from the base outwards
  std::size_t sliding_ = 0;
  std::array<double, 4> sign_{};      ///< of each axis along the base's z
  Vec3 p_first_;                      ///< of the first axis that turns
  Plane upper_arm_, forearm_, hand_;  ///< from axis to axis, and to the tool's tip, at q = 0
  double z_zero_ = 0;                 ///< of the tool's tip at q = 0
  Rotation R_zero_;                   ///< of the tool at q = 0
};

}  // namespace sinew::kinematics
