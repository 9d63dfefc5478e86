#pragma once

#include <array>
#include <span>

#include "sinew/planning/jog/jog_joint.h"
#include "sinew/planning/jog/jog_space.h"
#include "sinew/planning/jog/platform_walls.h"

namespace sinew::planning {

/// What stands in the way of a tool's velocity, and where.
struct JogObstacle {
  enum class Kind : std::uint8_t { kNone, kJointLimit, kSingular, kPoseLimit };
  Kind kind = Kind::kNone;
  std::int8_t joint = -1;  ///< joint or leg, where there is one
};

/// Velocities of the joints for a velocity of the tool, also beside limits and singularities.
///
/// A joint that is near its limit goes towards it only as fast as it can still brake; what it does
/// not do the others are asked for, and what they cannot do either is left out: the tool slides
/// along. A direction that a singularity takes away fades out in the same way, unless it leads away
/// from the singularity: then the joints go the quick way out of it, which the tool's own velocity
/// would not tell them there. @rt
class JogResolver {
 public:
  JogResolver(const JogSpace& space, std::span<const JogJoint> joints);
  /// Nothing of what was before counts any more: the same motion begins in the same way.
  void forget();

  /// Looks around at q and decides which joints must be held back for this task. @param X_BT  the
  /// last pose; then the one at q. @return false: a hexapod's legs have no pose
  bool look(JogFrame frame, const JointArray& q, const TaskArray& task, PoseBT& X_BT);

  /// What the joints have to do for a task, with those held back that look() found. Linear but for
  /// a platform at its walls.
  JointArray joints_for(const TaskArray& task) const;
  /// The same for what is really driven: out of singularities too, and with no joint faster towards
  /// its limit than it may be. @param dt  s since the last time
  JointArray drive(const TaskArray& task, double dt);
  /// What the tool does while the joints move.
  TaskArray task_of(const JointArray& qd) const;

  JogObstacle obstacle(const TaskArray& task) const;
  /// Joints that are held back, one bit each.
  unsigned held() const { return held_; }
  /// Something stands in the way of this task, so that the joints' velocities change with where
  /// they are and not only with how the way is bent.
  bool in_the_way(const TaskArray& task) const;

  /// Shares of a joint's acceleration and jerk that a tool's velocity counts on: the rest is for
  /// what changes on the way.
  static constexpr double kShare = 0.5;

 private:
  struct Escape {
    FixedVector<JointArray, 4> directions;  ///< orthonormal
  };
  void look_at_caps(const JointArray& q);
  void look_for_singularities();
  void hold(const TaskArray& task);
  TaskArray rest_of(const TaskArray& task) const;
  const TaskSolver& solver() const { return solvers_[holds_]; }
  TaskArray lost_part(const TaskArray& task, Escape& escape) const;
  void add_free_directions(Escape& escape) const;
  void escape(const TaskArray& task, double dt, JointArray& u);
  double way_out(const TaskArray& lost, const Escape& escape, JointArray& d) const;

  const JogSpace* space_;
  std::span<const JogJoint> joints_;
  PlatformWalls walls_;
  JogFrame frame_ = JogFrame::kBase;
  JointArray q_{};
  TaskJacobian J_;
  JointArray cap_lower_{}, cap_upper_{};
  std::array<TaskSolver, kMaxJoints + 1> solvers_;  ///< by number of joints held
  std::size_t holds_ = 0;
  unsigned held_ = 0;
  JointArray fixed_{};
  motion::AxisState escape_;      ///< velocity and acceleration along the way out
  bool escapes_ = false;          ///< the last drive() went it
  motion::JointProfile profile_;  ///< workspace
  double room_to_axis_ = 0;
  TaskArray away_{};
};

}  // namespace sinew::planning
