#pragma once

#include <array>
#include <expected>
#include <vector>

#include "sinew/planning/paths/moves.h"
#include "sinew/planning/paths/tool_way.h"

namespace sinew::planning {

/// No joint turns as far, rad (a leg: m).
inline constexpr double kFarTurn = 1e3;

/// Where the robot stands before a move.
struct RobotPlace {
  JointArray q{};
  PoseBT X_BT;
};

/// What is wrong with a move before any way is looked for.
struct MoveFault {
  Error error;
  std::optional<NearestPose> nearest;  ///< where another orientation would do
};

/// The whole way of one move, blends aside: along a tool's way, or straight through joint space.
/// s runs from 0 to length(). @rt, apart from its construction.
class MoveWay {
 public:
  /// @param space  outlives this.
  explicit MoveWay(const ToolSpace& space) : space_(space), tool_(space.task()) {
    through_.reserve(MoveSpline::kPointsMax + 1);
  }

  /// @error kMoveInput, kArcCollinear, kProgramTooLong (way points); of the task space:
  ///        kApproachOutOfPlane, kRollNotFree, kOrientationNotReachable; a hexapod's forward
  std::optional<MoveFault> make(const Move& move, const RobotPlace& from);

  /// Where the tool shall be at the end of a move, if it can be asked for that; of a joint row
  /// nothing.
  std::optional<TaskPoint> end_of(const Move& move, const RobotPlace& from) const;

  /// m, or its like where the tool hardly moves; 0 where nothing does.
  double length() const { return length_; }
  bool straight_in_joints() const { return joints_; }
  /// s counts the tool's way, not its turn or that of its joints.
  bool counts_metres() const { return joints_ ? joints_metres_ : tool_.counts_metres(); }
  const ToolWay& tool() const { return tool_; }
  /// Joints at s, of a move that is straight in them.
  JointArray joints_at(double s) const;
  /// The tool at s.
  TaskPoint point_at(double s) const;
  /// Pose at the end of a move that is straight in joints.
  const PoseBT& joint_end() const { return X_end_; }

 private:
  std::optional<MoveFault> make_joints(const JointArray& q, const RobotPlace& from);
  std::optional<Error> limit_broken(const JointArray& q) const;
  std::optional<MoveFault> make_joints_to(const ToolTarget& target, const RobotPlace& from);
  std::optional<MoveFault> make_tool(const Move& move, const RobotPlace& from);
  std::expected<TaskPoint, MoveFault> resolve(const ToolTarget& target, const RobotPlace& from,
                                              const TaskPoint& last) const;

  const ToolSpace& space_;
  ToolWay tool_;
  bool joints_ = false;
  bool joints_metres_ = false;
  double length_ = 0;
  JointArray q_from_{};
  JointArray q_to_{};
  PoseBT X_from_;
  PoseBT X_end_;
  std::vector<TaskPoint> through_;
};

}  // namespace sinew::planning
