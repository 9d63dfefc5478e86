#include "sinew/planning/motion_planner.h"

#include <algorithm>
#include <limits>

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

void MotionPlanner::fit(const ToolState& tool) {
  if (tool == tool_) return;
  tool_ = tool;
  space_ = ToolSpace(model_, tool.jaws);
  collision_.fit(tool);
}

Expected<void> MotionPlanner::check_jaws(std::span<const double> q, const ToolState& from,
                                         double to) {
  fit(from);
  if (const auto error = collision_.jaws_contact(q, from, to)) return std::unexpected(*error);
  return {};
}

Expected<RobotPlace> MotionPlanner::place_at(std::span<const double> q) {
  auto place = builder_.stand_at(q, X_near_);
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

std::optional<PathContact> MotionPlanner::contact_on(const RobotPlace& start,
                                                     const JointPath& path) const {
  double clearance_min = 0;
  return contact_on(start, path, clearance_min);
}

std::optional<PathContact> MotionPlanner::contact_on(const RobotPlace& start, const JointPath& path,
                                                     double& clearance_min) const {
  const auto X_BP = relabel<frame::Base, frame::Platform>(start.X_BT);
  const std::span q(start.q.data(), space_.size());
  const double here = collision_.distance(q, &X_BP).distance;
  // What counts as at the margin is that much nearer than the start, so that it can leave.
  clearance_min = std::min(here - 2 * CollisionModel::kResolution, collision_.margin());
  // What is beside the robot may be near at the start: that is no reason to come near to all else.
  const bool leaves = clearance_min < 0 || (collision_.surrounded() && here < collision_.margin());
  return leaves ? collision_.check_leaving(path, &X_BP)
                : collision_.check_path(path, clearance_min, 0, path.length(), &X_BP);
}

std::optional<PathRefusal> MotionPlanner::check_contacts(const RobotPlace& start, std::size_t first,
                                                         const PlannedPath& path,
                                                         double& clearance_min) const {
  const auto X_BP = relabel<frame::Base, frame::Platform>(start.X_BT);
  const auto contact = contact_on(start, path.joints, clearance_min);
  if (!contact) return std::nullopt;
  const PathProgress at = Trajectory::progress_at(path, contact->s);
  const PathSection& section = path.sections[at.move - first];
  const double begin = section.begin;
  return PathRefusal{contact_error(model_, contact->nearest),
                     {at.move, contact->s - begin, at.move_share, section.metres},
                     std::nullopt,
                     start,
                     nearest_behind(path, contact->s, X_BP)};
}

/// How near bodies come to each other from s on, m, looked at in some places.
double MotionPlanner::nearest_behind(const PlannedPath& path, double s,
                                     kinematics::PoseBP X_BP) const {
  constexpr int kLooks = 64;
  double nearest = std::numeric_limits<double>::infinity();
  for (int k = 0; k <= kLooks; ++k) {
    PathPoint at;
    path.joints.sample(s + (path.joints.length() - s) * k / kLooks, at);
    const std::span<const double> q(at.q.data(), space_.size());
    const auto X_BT = space_.forward(q, relabel<frame::Base, frame::Tool>(X_BP));
    if (!X_BT) break;
    X_BP = relabel<frame::Base, frame::Platform>(*X_BT);
    nearest = std::min(nearest, collision_.distance(q, &X_BP).distance);
  }
  return nearest;
}

std::expected<RobotPlace, PathRefusal> MotionPlanner::end_of(const RobotPlace& start, Move move) {
  move.blend_radius = 0;
  move.blend_joints = 0;
  const auto stretch = builder_.build(start, std::span(&move, 1), 0, scratch_);
  if (!stretch) return std::unexpected(stretch.error());
  return stretch->end;
}

MoveProposal MotionPlanner::propose(const PathRefusal& refusal, std::span<const Move> moves) {
  return planning::propose(builder_, space_, refusal, moves, scratch_,
                           [this](const RobotPlace& from, const PlannedPath& path) {
                             return !contact_on(from, path.joints);
                           });
}

}  // namespace sinew::planning
