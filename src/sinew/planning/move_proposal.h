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
    PoseBT X_BT;      ///< where that line ends
  };
  std::optional<Tilted> tilted;
  /// The nearest orientation that the robot can have.
  std::optional<NearestPose> nearest;
  /// As far as a straight line can be gone, a little before the place of the refusal.
  struct Part {
    double length = 0;  ///< m from its beginning
    PoseBT X_BT;
  };
  std::optional<Part> part;
  /// What is wrong with the target itself, wherever its way would break off before; no offer.
  std::optional<Error> at_target;
};

/// Looks for ways around a refusal: plans up to some dozens of moves, so some milliseconds.
/// @param scratch  a path that is overwritten
MoveProposal propose(MovePathBuilder& builder, const ToolSpace& space, const PathRefusal& refusal,
                     std::span<const Move> moves, PlannedPath& scratch);

}  // namespace sinew::planning
