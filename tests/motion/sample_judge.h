#pragma once

#include <string>

#include "motion/motion_sums.h"
#include "sinew/model/robot_model.h"
#include "sinew/planning/timing/trajectory.h"

namespace sinew::planning {

/// Holds every sample of a robot's joints against the model's own limits and against the sample
/// before, with nothing that a planner says. The limits of velocity, acceleration and jerk are the
/// model's times what its device leaves of them.
///
/// Between two samples acceleration can change by jerk * dt at most, however many phases lie
/// between; what that makes of velocity and position is bounded in the same way. So no tolerance is
/// needed but rounding's.
class SampleJudge {
 public:
  /// @param model, sums  outlive this.
  SampleJudge(const RobotModel& model, MotionSums& sums);

  /// A new robot, so to say: it stands (or moves) as said, also outside its limits of position.
  void begin(const JointMotion& at);
  /// `dt` s later. Empty where nothing is wrong, else what is.
  std::string judge(const JointMotion& now, double dt);

  const JointMotion& last() const { return last_; }
  /// Every joint has come to rest.
  bool rests() const;
  std::size_t joints() const { return joints_; }

 private:
  void come_back(std::size_t j, const JointMotion& now);
  std::string judge_limits(std::size_t j, const JointMotion& now);
  std::string judge_change(std::size_t j, const JointMotion& now, double dt);

  const RobotModel& model_;
  MotionSums& sums_;
  std::size_t joints_;
  double share_;
  JointMotion last_;
  /// Where it may be: its limits, or as far out as it stood.
  JointArray lower_{};
  JointArray upper_{};
};

}  // namespace sinew::planning
