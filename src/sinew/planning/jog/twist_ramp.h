#pragma once

#include "sinew/motion/joint_profile.h"
#include "sinew/planning/jog/task_solver.h"

namespace sinew::planning {

/// A tool's velocity on its way to another one, jerk-limited. From rest it keeps its direction: all
/// its numbers then change in proportion. @rt
class TwistRamp {
 public:
  const TaskArray& velocity() const { return velocity_; }
  /// From here on, with no regard to what was before.
  void begin(const TaskArray& velocity, const TaskArray& acceleration);

  /// Unit vector in which the velocity changes next.
  TaskArray direction(const TaskArray& target, double acceleration, double jerk) const;
  /// `dt` s go by. @param acceleration, jerk  > 0: limits along direction().
  void step(const TaskArray& target, double acceleration, double jerk, double dt);
  /// Slower by itself, where the joints had to be.
  void shrink(double share);

 private:
  TaskArray velocity_{};
  TaskArray acceleration_{};
  motion::JointProfile profile_;  ///< workspace
};

}  // namespace sinew::planning
