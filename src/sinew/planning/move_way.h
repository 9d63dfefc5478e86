#pragma once

#include <array>
#include <expected>
#include <vector>

#include "sinew/planning/moves.h"
#include "sinew/planning/tool_way.h"

namespace sinew::planning {

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

  /// m, or its like where the tool hardly moves; 0 where nothing does.
  double length() const { return length_; }
  bool straight_in_joints() const { return joints_; }
  const ToolWay& tool() const { return tool_; }
  /// Joints at s, of a move that is straight in them.
  JointArray joints_at(double s) const;
  /// The tool at s.
  TaskPoint point_at(double s) const;
  /// Pose at the end of a move that is straight in joints.
  const PoseBT& joint_end() const { return X_end_; }

 private:
  std::optional<MoveFault> make_joints(const JointArray& q, const RobotPlace& from);
  std::optional<MoveFault> make_joints_to(const ToolTarget& target, const RobotPlace& from);
  std::optional<MoveFault> make_tool(const Move& move, const RobotPlace& from);
  std::expected<TaskPoint, MoveFault> resolve(const ToolTarget& target, const RobotPlace& from,
                                              const TaskPoint& last) const;

  const ToolSpace& space_;
  ToolWay tool_;
  bool joints_ = false;
  double length_ = 0;
  JointArray q_from_{};
  JointArray q_to_{};
  PoseBT X_from_;
  PoseBT X_end_;
  std::vector<TaskPoint> through_;
};

}  // namespace sinew::planning
