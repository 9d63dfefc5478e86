#include "sinew/planning/motion_planner.h"

#include <algorithm>

namespace sinew::planning {
MotionPlanner::MotionPlanner(const RobotModel& model)
    : model_(model),
      space_(model),
      builder_(space_),
      collision_(model),
      limits_(motion_limits(model)),
      shared_velocity_(shared_velocity(model)),
      X_near_(space_.home()),
      scratch_(model.joints.size()),
      scratch_law_(timing_.phases_max()) {}

Expected<RobotPlace> MotionPlanner::place_at(std::span<const double> q) {
  auto place = builder_.place_at(q, X_near_);
  if (place) X_near_ = place->X_BT;
  return place;
}

std::expected<void, PathRefusal> MotionPlanner::plan(const RobotPlace& start,
                                                     std::span<const Move> moves, std::size_t first,
                                                     PlannedMotion& out) {
  out.stop.reset();
  if (const auto refusal = make(start, moves, first, out)) return std::unexpected(*refusal);
  if (out.stretch.moves > 1) leave_out_blends(start, moves, first, out);
  return {};
}

std::optional<PathRefusal> MotionPlanner::make(const RobotPlace& start, std::span<const Move> moves,
                                               std::size_t first, PlannedMotion& out) {
  out.law.clear();
  out.limits = {};
  const auto stretch = builder_.build(start, moves, first, out.path);
  if (!stretch) return stretch.error();
  out.stretch = *stretch;
  X_near_ = stretch->end.X_BT;
  if (out.empty()) return std::nullopt;
  if (const auto refusal = check_contacts(start, first, out.path, out.clearance_min))
    return refusal;
  auto trouble = timing_.prepare(out.path, limits_, 1, LawUse::kQuickest, shared_velocity_);
  if (!trouble) trouble = timing_.plan({}, 1, out.law);
  if (trouble) {
    out.law.clear();
    return PathRefusal{*trouble, {.move = first}, std::nullopt, start};
  }
  out.limits = timing_.limit_times();
  return std::nullopt;
}

std::optional<PathRefusal> MotionPlanner::check_contacts(const RobotPlace& start, std::size_t first,
                                                         const PlannedPath& path,
                                                         double& clearance_min) const {
  const auto X_BP = relabel<frame::Base, frame::Platform>(start.X_BT);
  const std::span q(start.q.data(), space_.size());
  const double here = collision_.distance(q, &X_BP).distance;
  // What counts as at the margin is that much nearer than the start, so that it can leave.
  const double nearest = here - 2 * CollisionModel::kResolution;
  clearance_min = std::clamp(nearest, 0.0, model_.collision.margin);
  const auto contact =
      collision_.check_path(path.joints, clearance_min, 0, path.joints.length(), &X_BP);
  if (!contact) return std::nullopt;
  const PathProgress at = Trajectory::progress_at(path, contact->s);
  const double begin = path.sections[at.move - first].begin;
  return PathRefusal{contact_error(model_, contact->nearest),
                     {at.move, contact->s - begin, at.move_share},
                     std::nullopt,
                     start};
}

std::expected<RobotPlace, PathRefusal> MotionPlanner::end_of(const RobotPlace& start, Move move) {
  move.blend_radius = 0;
  move.blend_joints = 0;
  const auto stretch = builder_.build(start, std::span(&move, 1), 0, scratch_);
  if (!stretch) return std::unexpected(stretch.error());
  return stretch->end;
}

MoveProposal MotionPlanner::propose(const PathRefusal& refusal, std::span<const Move> moves) {
  MoveProposal proposal = planning::propose(builder_, space_, refusal, moves, scratch_);
  const RobotPlace& from = refusal.from;
  Move same = moves[refusal.place.move];
  if (proposal.move_j && !hits_nothing(from, {.way = MoveJ{*proposal.move_j}})) {
    proposal.move_j.reset();
  }
  if (proposal.other_start) {
    const auto place = builder_.place_at({proposal.other_start->data(), space_.size()}, from.X_BT);
    if (!place || !hits_nothing(*place, same)) proposal.other_start.reset();
  }
  if (proposal.tilted) {
    const Asked asked = space_.task() == TaskSpace::kApproach ? Asked::kApproach : Asked::kPose;
    same.way = MoveL{{proposal.tilted->X_BT, asked}};
    if (!hits_nothing(from, same)) proposal.tilted.reset();
  }
  return proposal;
}

bool MotionPlanner::hits_nothing(const RobotPlace& from, Move move) {
  move.blend_radius = 0;
  move.blend_joints = 0;
  if (!builder_.build(from, std::span(&move, 1), 0, scratch_)) return false;
  const auto X_BP = relabel<frame::Base, frame::Platform>(from.X_BT);
  return !collision_.check_path(scratch_.joints, model_.collision.margin, 0,
                                scratch_.joints.length(), &X_BP);
}

}  // namespace sinew::planning
