#pragma once

#include <array>
#include <cstddef>

#include "sinew/planning/paths/joint_path.h"

namespace sinew::planning {

inline constexpr std::size_t kTasksMax = 6;
/// Rates of what a tool is asked for: velocities and turns in some frame, or fewer.
using TaskArray = std::array<double, kTasksMax>;

/// What each joint does to the task, per rad/s or m/s of its own; scaled so that lengths and turns
/// can be compared. What is not used is 0.
struct TaskJacobian {
  std::size_t joints = 0;
  std::array<TaskArray, kMaxJoints> column{};

  TaskArray times(const JointArray& qd) const;
};

/// Joint velocities for task rates, also where the arm is singular: there the direction that is
/// lost fades out and all others stay exact. Inverts J along its singular directions: u =
/// sum of (U_k . task) / (s_k^2 + d_k^2) s_k v_k, with a damping d_k that is 0 where the singular
/// value s_k is at least kNearSingular.
///
/// What a direction does not do has to come out of the task somewhere. Out of its turns (numbers 3
/// to 5) wherever they can make up for it: the tool's tip goes on as asked. Where they would have
/// to be larger than the whole task for that, out of the translation (0 to 2) along itself: the tip
/// goes on more slowly, and not aside. Only where joints are held it also slides aside, as little
/// as can be.
///
/// Source: Hestenes 1958 for the directions, by one-sided Jacobi rotations which begin with those
/// of the last call; Nakamura and Hanafusa 1986 and Maciejewski and Klein 1988 for the damping,
/// here only of the directions that need it. @rt
class TaskSolver {
 public:
  /// Below this a singular value of the scaled Jacobian counts as small.
  static constexpr double kNearSingular = 0.02;
  /// At a singularity itself, how strongly the direction is damped.
  static constexpr double kDamping = 0.03;

  TaskSolver();

  /// @param held  bit j: joint j does not take part.
  void factor(const TaskJacobian& J, unsigned held);

  /// From here to the next factor() the joints go along direction k, in the sense of
  /// joints_along(k), only at a speed in [lower, upper] (of all joints together, as a vector's
  /// length). @param lower <= 0 <= upper
  void limit(std::size_t k, double lower, double upper);

  JointArray solve(const TaskArray& task) const;
  /// Whether a limit makes solve() leave out more than a thousandth of what it would do.
  bool limited(const TaskArray& task) const;
  /// How much of the task is left out there, 0 to 1 of its length.
  double lost_share(const TaskArray& task) const;

  double singular_value(std::size_t k) const { return value_[k]; }
  const TaskArray& direction(std::size_t k) const { return U_[k]; }
  /// J^T U_k: what the joints do along direction k, singular_value(k) long.
  const JointArray& joints_along(std::size_t k) const { return G_[k]; }

 private:
  void start_again();
  double speed_along(std::size_t k, const TaskArray& task) const;
  TaskArray driven(const TaskArray& task) const;
  TaskArray left_out(const TaskArray& lost, const TaskArray& onward) const;
  TaskArray possible(const TaskArray& task, const TaskArray& lost) const;

  std::array<TaskArray, kTasksMax> U_;
  std::array<JointArray, kTasksMax> G_{};
  TaskArray value_{};
  TaskArray gain_{};  ///< 1 / (s^2 + d^2)
  TaskArray lower_{}, upper_{};
  unsigned calls_ = 0;
  bool held_ = false;  ///< some joint does not take part
};

}  // namespace sinew::planning
