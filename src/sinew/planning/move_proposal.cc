#include "sinew/planning/move_proposal.h"

#include <algorithm>
#include <cmath>

namespace sinew::planning {
namespace {

/// Where a move ends that can be made; nothing where it cannot.
std::optional<RobotPlace> end_of(MovePathBuilder& builder, const RobotPlace& from, const Move& move,
                                 PlannedPath& scratch) {
  const auto stretch = builder.build(from, std::span(&move, 1), 0, scratch);
  return stretch ? std::optional(stretch->end) : std::nullopt;
}

bool works(MovePathBuilder& builder, const RobotPlace& from, const Move& move,
           PlannedPath& scratch) {
  return end_of(builder, from, move, scratch).has_value();
}

/// The same move with another orientation at its end.
Move turned(Move move, const PoseBT& X_BT) {
  const ToolTarget target{X_BT, Asked::kPose};
  if (auto* to = std::get_if<MoveTo>(&move.way)) to->to = target;
  if (auto* line = std::get_if<MoveL>(&move.way)) line->to = target;
  if (auto* arc = std::get_if<MoveC>(&move.way)) arc->to = target;
  return move;
}

/// A line that cannot be gone to its end, up to where it can.
std::optional<MoveProposal::Part> find_part(MovePathBuilder& builder, const ToolSpace& space,
                                            const PathRefusal& refusal, const Move& move,
                                            const MoveWay& way, PlannedPath& scratch) {
  constexpr double kFirst = 1e-3;  // m before the refused place, then twice as far again and again
  for (double before = kFirst; before < refusal.place.at; before *= 2) {
    const double length = refusal.place.at - before;
    const PoseBT X_BT = space.pose(way.point_at(length), refusal.from.X_BT.R);
    const Asked asked = space.task() == TaskSpace::kPoint ? Asked::kPoint : Asked::kPose;
    Move shorter = move;
    shorter.way = MoveL{{X_BT, asked}};
    const auto end = end_of(builder, refusal.from, shorter, scratch);
    if (end) return MoveProposal::Part{length, end->X_BT};
  }
  return std::nullopt;
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
      if (const auto end = end_of(builder, from, line, scratch)) {
        return MoveProposal::Tilted{tilt, end->X_BT};
      }
    }
  }
  return std::nullopt;
}

}  // namespace

MoveProposal propose(MovePathBuilder& builder, const ToolSpace& space, const PathRefusal& refusal,
                     std::span<const Move> moves, PlannedPath& scratch) {
  MoveProposal proposal;
  Move move = moves[refusal.place.move];
  move.blend_radius = 0;
  move.blend_joints = 0;
  // The orientation alone may not be all that is wrong.
  const auto& nearest = refusal.nearest;
  if (nearest && works(builder, refusal.from, turned(move, nearest->X_BT), scratch)) {
    proposal.nearest = nearest;
  }
  MoveWay way(space);
  if (refusal.error.code == ErrorCode::kMoveInput || way.make(move, refusal.from) ||
      way.straight_in_joints() || way.length() == 0) {
    return proposal;
  }
  const RobotPlace& from = refusal.from;
  const TaskPoint end = way.point_at(way.length());
  if (const auto q = space.inverse_near(end, from.q); !q) proposal.at_target = q.error();
  if (std::holds_alternative<MoveL>(move.way)) {
    proposal.part = find_part(builder, space, refusal, move, way, scratch);
  }
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
