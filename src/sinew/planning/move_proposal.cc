#include "sinew/planning/move_proposal.h"

#include <algorithm>
#include <cmath>

namespace sinew::planning {
namespace {

bool works(MovePathBuilder& builder, const RobotPlace& from, const Move& move,
           PlannedPath& scratch) {
  return builder.build(from, std::span(&move, 1), 0, scratch).has_value();
}

/// X with its tool tilted by `tilt` in the vertical plane through the base axis and the tool.
PoseBT tilted(const PoseBT& X_BT, double tilt) {
  const double yaw = std::atan2(X_BT.p.y, X_BT.p.x);
  const Vec3 across{-std::sin(yaw), std::cos(yaw), 0};
  return {rotation_from_vector(tilt * across) * X_BT.R, X_BT.p};
}

std::optional<MoveProposal::Tilted> find_tilt(MovePathBuilder& builder, const ToolSpace& space,
                                              const RobotPlace& from, const PoseBT& X_BT,
                                              PlannedPath& scratch) {
  constexpr double kStep = from_deg(5);
  constexpr int kSteps = 18;
  const Asked asked = space.task() == TaskSpace::kApproach ? Asked::kApproach : Asked::kPose;
  for (int i = 1; i <= kSteps; ++i) {
    for (const double sign : {1.0, -1.0}) {
      const double tilt = sign * i * kStep;
      const PoseBT X_tilted = tilted(X_BT, tilt);
      const Move line{.way = MoveL{{X_tilted, asked}}};
      if (works(builder, from, line, scratch)) return MoveProposal::Tilted{tilt, X_tilted};
    }
  }
  return std::nullopt;
}

}  // namespace

MoveProposal propose(MovePathBuilder& builder, const ToolSpace& space, const PathRefusal& refusal,
                     std::span<const Move> moves, PlannedPath& scratch) {
  MoveProposal proposal;
  proposal.nearest = refusal.nearest;
  Move move = moves[refusal.place.move];
  move.blend_radius = 0;
  move.blend_joints = 0;
  MoveWay way(space);
  if (refusal.error.code == ErrorCode::kMoveInput || way.make(move, refusal.from) ||
      way.straight_in_joints() || way.length() == 0) {
    return proposal;
  }
  const RobotPlace& from = refusal.from;
  const TaskPoint end = way.point_at(way.length());
  for (const JointArray& q : space.branches(end, from.q)) {
    if (!works(builder, from, {.way = MoveJ{q}}, scratch)) continue;
    proposal.move_j = q;
    break;
  }
  if (space.hexapod() != nullptr) return proposal;
  constexpr double kSameBranch = 1e-4;
  for (const JointArray& q : space.branches(space.point(from.X_BT), from.q)) {
    double apart = 0;
    for (std::size_t j = 0; j < kMaxJoints; ++j)
      apart = std::max(apart, std::abs(q[j] - from.q[j]));
    const auto place = builder.place_at(std::span(q.data(), space.size()), from.X_BT);
    if (apart < kSameBranch || !place || !works(builder, *place, move, scratch)) continue;
    proposal.other_start = q;
    break;
  }
  const bool five = space.task() == TaskSpace::kPitchRoll || space.task() == TaskSpace::kApproach;
  if (five && std::holds_alternative<MoveL>(move.way)) {
    proposal.tilted = find_tilt(builder, space, from, space.pose(end, from.X_BT.R), scratch);
  }
  return proposal;
}

}  // namespace sinew::planning
