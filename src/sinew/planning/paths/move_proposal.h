#pragma once

#include <functional>
#include <optional>
#include <span>

#include "sinew/planning/paths/move_path.h"

namespace sinew::planning {

/// What would work in the place of a refused move, each tried out before it is proposed.
struct MoveProposal {
  /// The same target by a joint move to these joints.
  std::optional<JointArray> move_j;
  /// The same move, started from these joints, which hold the tool where it is now.
  std::optional<JointArray> other_start;
  /// The tool at the same point, but turned, for an arm of five joints.
  struct Tilted {
    double tilt = 0;              ///< rad, in the arm's plane
    double roll = 0;              ///< rad, about the tool's axis
    double swing = 0;             ///< rad, out of the arm's plane
    PoseBT X_BT;                  ///< where it ends
    std::optional<JointArray> q;  ///< by a joint move to there; absent: along the line
  };
  std::optional<Tilted> tilted;
  /// The nearest orientation that the robot can have.
  std::optional<NearestPose> nearest;
  /// By a joint move to there; absent: by the same move.
  std::optional<JointArray> nearest_q;
  /// As far as a straight line can be gone, a little before the place of the refusal.
  struct Part {
    double length = 0;  ///< m from its beginning
    PoseBT X_BT;
  };
  std::optional<Part> part;
  /// As near as joint moves come to the target.
  struct Near {
    JointArray q{};
    double left = 0;  ///< m that the tool is short of it; of a joint row 0
  };
  std::optional<Near> near;
  /// Back inside the limits, for a robot that stands outside of them.
  std::optional<JointArray> back_inside;
  /// What is wrong with the target itself, wherever its way would break off before; no offer.
  std::optional<Error> at_target;
};

/// Whether nothing is hit on a path from where a robot stands.
using HitsNothing = std::function<bool(const RobotPlace& from, const PlannedPath& path)>;

/// Looks for ways around a refusal: plans up to some dozens of moves, so some milliseconds.
/// @param scratch  a path that is overwritten
MoveProposal propose(MovePathBuilder& builder, const ToolSpace& space, const PathRefusal& refusal,
                     std::span<const Move> moves, PlannedPath& scratch,
                     const HitsNothing& hits_nothing = {});

}  // namespace sinew::planning
