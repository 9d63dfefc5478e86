#pragma once

#include <optional>
#include <span>
#include <variant>

#include "sinew/kinematics/five_r.h"
#include "sinew/kinematics/numeric_ik.h"
#include "sinew/kinematics/scara.h"
#include "sinew/kinematics/six_r.h"

namespace sinew::kinematics {

/// Tool on the flange, the reach of the gripper's jaws included.
/// @param jaw_width  m between the jaws; open where absent, ignored without a gripper.
PoseFT tool_pose(const SerialGeometry& geometry, std::optional<double> jaw_width = {});

/// A serial robot with the best inverse that its structure allows: closed form for six joints with
/// a spherical wrist, for both kinds of five joints and for a SCARA, else damped least squares. @rt
class SerialArm {
 public:
  SerialArm(const SerialGeometry& geometry, std::span<const Joint> joints, const PoseFT& X_FT);

  /// The inverse that the structure allows.
  enum class Solver : std::uint8_t { kNumeric, kSixR, kFiveRPitch, kFiveRRoll, kScara };
  Solver solver() const { return static_cast<Solver>(solver_.index()); }

  /// Nothing where the structure is another one.
  const Scara* scara() const { return std::get_if<Scara>(&solver_); }

  const SerialChain& chain() const { return chain_; }
  const PoseFT& tool() const { return X_FT_; }

  /// Tool in base at q (rad, m).
  PoseBT forward(std::span<const double> q) const { return chain_.forward(q) * X_FT_; }

  /// Joint angles that bring the tool to X_BT; all branches where a closed form exists, else one.
  /// @param tolerance  rad by which an orientation that this arm cannot have is bent to the
  ///                   nearest one that it can.
  /// @error kOutOfReach, kTooClose (m), kApproachOutOfPlane, kRollNotFree, kOrientationNotReachable
  ///        (rad), kNotConverged.
  Expected<IkBranches> inverse(const PoseBT& X_BT, std::span<const double> near = {},
                               double tolerance = kOrientationTolerance) const;

  /// Joint angles that bring the tool's tip to p_BT with its approach axis at `pitch` from straight
  /// up, in the vertical plane through the first axis; five-joint arms only.
  /// @error as inverse(), and kTaskNotSupported.
  Expected<IkBranches> inverse_at_pitch(const Vec3& p_BT, double pitch,
                                        std::span<const double> near = {}) const;

  /// Joint angles that bring the tool's tip to p_BT with its z axis along approach_B (unit vector
  /// in base), whatever roll follows; arms with a rolling forearm only.
  /// @error as inverse(), and kTaskNotSupported.
  Expected<IkBranches> inverse_along(const Vec3& p_BT, const Vec3& approach_B,
                                     std::span<const double> near = {}) const;

  struct PitchedBranches {
    double pitch = 0;  ///< rad from straight up
    IkBranches branches;
  };
  /// The same with the pitch chosen: the smallest tilt from `preferred` at which a branch lies
  /// inside its limits, and 1e-5 rad more where there is room.
  /// @error the refusal of the pitch that came nearest.
  Expected<PitchedBranches> inverse_nearest_pitch(const Vec3& p_BT, double preferred,
                                                  std::span<const double> near = {}) const;

 private:
  Expected<IkBranches> inverse_rolling(const FiveRRoll& solver, const PoseBT& X_BT,
                                       std::span<const double> near, double tolerance) const;
  Expected<IkBranches> inverse_general(const PoseBT& X_BT, std::span<const double> near) const;

  SerialChain chain_;
  std::span<const Joint> joints_;  ///< of the model, which outlives its arm
  PoseFT X_FT_;
  std::variant<std::monostate, SixR, FiveRPitch, FiveRRoll, Scara>
      solver_;  // in the order of Solver
};

}  // namespace sinew::kinematics
