#pragma once

#include <expected>
#include <span>
#include <vector>

#include "sinew/planning/collision/collision.h"
#include "sinew/planning/paths/motion_limits.h"
#include "sinew/planning/paths/move_path.h"
#include "sinew/planning/paths/move_proposal.h"
#include "sinew/planning/timing/path_timing.h"
#include "sinew/planning/timing/trajectory.h"

namespace sinew::planning {

/// A corner that is driven as a stop although a blend was asked for and fits: with it the moves
/// would take longer.
struct CornerStop {
  std::size_t move = 0;  ///< at whose end
  double lost = 0;       ///< s that the moves would have taken longer than from stop to stop
};

/// A motion from rest to rest, checked and timed, ready to be followed.
struct PlannedMotion {
  explicit PlannedMotion(std::size_t joints, std::size_t phases_max)
      : path(joints), law(phases_max) {}

  PlannedPath path;
  TimeLaw law;
  LimitTimes limits;               ///< what held it back
  PathStretch stretch;             ///< the moves that it took
  std::optional<CornerStop> stop;  ///< why it ends where another move would have blended in
  double clearance_min = 0;  ///< m that it was held against: the robot's margin, or less at a start
                             ///< that was nearer, below 0 at one that overlapped
  /// Where nothing moves: the robot stands there already.
  bool empty() const { return path.joints.empty(); }
  Trajectory trajectory() const { return {path, law}; }
};

/// From moves to motions: the way with all its checks (MovePathBuilder), nothing hit on it
/// (CollisionModel), and the time along it (PathTiming). Holds its workspace; one planner serves
/// one thread.
class MotionPlanner {
 public:
  /// @param model  outlives this.
  explicit MotionPlanner(const RobotModel& model);
  MotionPlanner(const MotionPlanner&) = delete;
  MotionPlanner& operator=(const MotionPlanner&) = delete;

  /// What the gripper is like in all that is planned from now on: where its tips are, and what it
  /// fills. Open, and anywhere, at first.
  void fit(const ToolState& tool);

  /// As CollisionModel::surround(): what is beside the robot in all that is planned from now on.
  void surround(std::span<const Surrounding> bodies) { collision_.surround(bodies); }

  const ToolSpace& space() const { return space_; }
  /// A motion that fits any plan() of this robot.
  PlannedMotion make_motion() const { return PlannedMotion(space_.size(), timing_.phases_max()); }

  /// Where the robot stands at q. A hexapod's pose is looked for near the last one that this was
  /// asked for, its home at first.
  /// Its joints may be outside of their limits.
  /// @error as MovePathBuilder::stand_at
  Expected<RobotPlace> place_at(std::span<const double> q);

  /// The motion of moves[first] and of those that blend into each other behind it.
  ///
  /// A start that is nearer to something than the robot's margin may go on, never nearer; from an
  /// overlap what overlaps only comes apart. A joint that starts outside of its limits only comes
  /// in.
  /// A blend with which its two moves take longer than with stops is left out: the motion ends
  /// there. So it takes no longer than its moves one by one would, but for moves that cannot be
  /// made from stop to stop.
  /// @error as MovePathBuilder::build; kCollision (index, other: links); kProgramTooLong
  std::expected<void, PathRefusal> plan(const RobotPlace& start, std::span<const Move> moves,
                                        std::size_t first, PlannedMotion& out);

  /// What is hit on a path that the device makes by itself, from rest to rest; nothing where it is
  /// clear. A start that is too near to something counts as in plan().
  std::optional<PathContact> contact_on(const RobotPlace& start, const JointPath& path) const;

  /// As CollisionModel::jaws_contact(). @error kJawsContact, kCollision
  Expected<void> check_jaws(std::span<const double> q, const ToolState& from, double to);

  /// Where a move ends that comes to a stop there; only its way is checked.
  std::expected<RobotPlace, PathRefusal> end_of(const RobotPlace& start, Move move);

  /// What would work instead of a refused move, without hitting anything.
  MoveProposal propose(const PathRefusal& refusal, std::span<const Move> moves);

 private:
  std::optional<PathRefusal> make(const RobotPlace& start, std::span<const Move> moves,
                                  std::size_t first, PlannedMotion& out);
  std::optional<PathRefusal> check_contacts(const RobotPlace& start, std::size_t first,
                                            const PlannedPath& path, double& clearance_min) const;
  std::optional<PathContact> contact_on(const RobotPlace& start, const JointPath& path,
                                        double& clearance_min) const;

  double nearest_behind(const PlannedPath& path, double s, kinematics::PoseBP X_BP) const;
  void leave_out_blends(const RobotPlace& start, std::span<const Move> moves, std::size_t first,
                        PlannedMotion& out);
  double quickest_alone(std::size_t k, const Move& move) const;
  double alone(std::size_t k, Move move);
  double cost(std::size_t from, std::size_t to, std::span<const Move> moves);
  std::optional<CornerStop> costliest(std::span<const Move> moves);
  bool can_stop_at(std::size_t k, std::span<const Move> moves, std::size_t first);

  const RobotModel& model_;
  ToolSpace space_;
  MovePathBuilder builder_;
  CollisionModel collision_;
  ToolState tool_;
  PathTiming timing_;
  std::vector<motion::AxisLimits> limits_;
  double shared_velocity_;
  PoseBT X_near_;
  PlannedPath scratch_;

  // Of the motion at hand, whose moves k counts.
  TimeLaw scratch_law_;
  std::vector<RobotPlace> corners_;            ///< where each begins, and the last one ends
  std::vector<double> section_times_, alone_;  ///< s, in the motion and from stop to stop
  std::vector<bool> needed_;                   ///< blends at their ends without which nothing goes
};

}  // namespace sinew::planning
