#pragma once

#include <optional>
#include <span>

#include "sinew/planning/move_path.h"

namespace sinew::planning {

/// What would work in the place of a refused move, each tried out before it is proposed.
struct MoveProposal {
  /// The same target by a joint move to these joints.
  std::optional<JointArray> move_j;
  /// The same move, started from these joints, which hold the tool where it is now.
  std::optional<JointArray> other_start;
  /// A straight line to the same point with the tool tilted, for an arm of five joints.
  struct Tilted {
    double tilt = 0;  ///< rad, towards the target where > 0
    PoseBT X_BT;
  };
  std::optional<Tilted> tilted;
  /// The nearest orientation that the robot can have.
  std::optional<NearestPose> nearest;
};

/// Looks for ways around a refusal: plans up to some dozens of moves, so some milliseconds.
/// @param scratch  a path that is overwritten
MoveProposal propose(MovePathBuilder& builder, const ToolSpace& space, const PathRefusal& refusal,
                     std::span<const Move> moves, PlannedPath& scratch);

}  // namespace sinew::planning
