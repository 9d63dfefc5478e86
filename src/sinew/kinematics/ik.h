#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <span>

#include "sinew/core/error.h"
#include "sinew/core/fixed_vector.h"
#include "sinew/core/trig.h"
#include "sinew/model/robot_model.h"

namespace sinew::kinematics {

/// Ways in which a pose can be singular, as bits. At each of them some joint is free or two
/// branches meet; the pose of the answer stays exact, its joints may jump between neighbours.
enum Singularity : std::uint8_t {
  kShoulderBit = 1,  ///< wrist on the first axis, or its two shoulder branches meet
  kElbowBit = 2,     ///< arm straight or folded: the elbow's two branches meet
  kWristBit = 4,     ///< two wrist axes in line
};

/// Below these measures an answer is flagged singular: the sine of the wrist's and the elbow's
/// bend, and the distance (m) of the wrist in the arm's plane from the first axis. Outside of them
/// joints come back to 1e-6 rad.
inline constexpr double kSingularSine = 1e-4;
inline constexpr double kSingularDistance = 1e-4;

/// A target this far (m) outside of the reach still counts as on its edge, for rounding's sake.
inline constexpr double kReachTolerance = 1e-10;

/// One set of joint angles that puts the tool where it was asked for.
struct IkBranch {
  JointVector q;
  bool within_limits = false;
  std::uint8_t singular = 0;  ///< Singularity bits
};

/// All branches of one closed form; order is fixed (shoulder, elbow, wrist), not by preference.
using IkBranches = FixedVector<IkBranch, 8>;

/// Orders branches: those within their limits first, then by the largest joint move from `near`.
void sort_by_distance(IkBranches& branches, std::span<const double> near);

/// The limits that `q` breaks, one kJointLimit (kLegLength of a prismatic joint) each with the
/// joint, its value and the limit.
using LimitViolations = FixedVector<Error, kMaxJoints>;
LimitViolations limit_violations(std::span<const Joint> joints, std::span<const double> q);

/// The refusal for an answer with no branch inside its limits: the smallest violation among those
/// that are the worst of their branch, so "which joint, by how many degrees" names the nearest way.
Error nearest_violation(std::span<const Joint> joints, const IkBranches& branches);

/// Joint limits as plain arrays, and the choice of the full turn that suits them. @rt
class JointRanges {
 public:
  explicit JointRanges(std::span<const Joint> joints);

  /// Turns each angle by whole turns to the one nearest to `near` (0 where `near` is empty), and
  /// by one more turn where only that lies inside the limits. Prismatic joints stay. Sets
  /// `within_limits`.
  void settle(IkBranch& branch, std::span<const double> near) const;

  /// The same for N branches of revolute joints at once, as lanes: a row per joint, a column per
  /// branch.
  /// @return  of each branch, how far (rad) its worst joint is outside of its limits; <= 0 inside.
  template <std::size_t Joints, std::size_t N>
  std::array<double, N> settle(std::array<std::array<double, N>, Joints>& q,
                               std::span<const double> near) const {
    std::array<double, Joints> near_q{};
    for (std::size_t j = 0; j < std::min(near.size(), Joints); ++j) near_q[j] = near[j];
    std::array<double, N> outside;
    // Joints inside, branches outside: one plain loop over the lanes is left for the vectoriser.
    for (std::size_t i = 0; i < N; ++i) {
      double worst = -2 * kPi;
      for (std::size_t j = 0; j < Joints; ++j) {
        const double angle = turned(q[j][i], near_q[j], j);
        const double below = lower_[j] - angle;
        const double above = angle - upper_[j];
        worst = below > worst ? below : worst;
        worst = above > worst ? above : worst;
        q[j][i] = angle;
      }
      outside[i] = worst;
    }
    return outside;
  }

  bool contains(std::span<const double> q) const;
  std::size_t size() const { return size_; }
  double lower(std::size_t joint) const { return lower_[joint]; }
  double upper(std::size_t joint) const { return upper_[joint]; }

 private:
  double turned(double angle, double near, std::size_t joint) const {
    const double q = wrap_near(angle, near);
    const double up = q < turn_up_below_[joint] ? 2 * kPi : 0;
    const double down = q > turn_down_above_[joint] ? 2 * kPi : 0;
    return q + up - down;
  }

  std::size_t size_ = 0;
  std::array<double, kMaxJoints> lower_{};
  std::array<double, kMaxJoints> upper_{};
  // Outside of these an angle has left its limits on one side and a turn brings it back inside.
  std::array<double, kMaxJoints> turn_up_below_{};
  std::array<double, kMaxJoints> turn_down_above_{};
  std::array<bool, kMaxJoints> slides_{};
};

}  // namespace sinew::kinematics
