#include "sinew/program/plans/row_planner.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "sinew/control/path_motion.h"
#include "sinew/control/piece_motion.h"
#include "sinew/core/assert.h"
#include "sinew/core/error_code.h"
#include "sinew/planning/paths/chords.h"
#include "sinew/planning/paths/motion_limits.h"
#include "sinew/program/language/tool_goal.h"
#include "sinew/program/plans/nearest_pitch.h"
#include "sinew/program/plans/whole_moves.h"

namespace sinew::program {
namespace {

using kinematics::PoseBT;
using planning::Asked;
using planning::JointArray;
using planning::Move;
using planning::RobotPlace;
using planning::TaskPoint;
using planning::ToolSpace;
using planning::ToolTarget;

JointArray array_of(const JointVector& q) {
  JointArray array{};
  std::ranges::copy(q, array.begin());
  return array;
}

JointVector vector_of(const JointArray& q, std::size_t size) {
  return JointVector(std::span<const double>(q.data(), size));
}

/// A goal in the terms of the planner: what it does not name stays as it is at `from`.
/// @param ahead  m, as RowPlanner::tips_ahead_
ToolTarget target_of(const ToolGoal& goal, const RobotPlace& from, const ToolSpace& space,
                     double ahead) {
  ToolTarget target{from.X_BT, Asked::kPoint};
  Vec3& p = target.X_BT.p;
  p = {goal.p_BT[0].value_or(p.x), goal.p_BT[1].value_or(p.y), goal.p_BT[2].value_or(p.z)};
  if (goal.R_BT) {
    target.X_BT.R = *goal.R_BT;
    target.asked = Asked::kPose;
  }
  if (goal.pitch || goal.roll) {
    TaskPoint point = space.point(goal.R_BT ? target.X_BT : from.X_BT);
    point.p_BT = p;
    point.attitude[0] = goal.pitch.value_or(point.attitude[0]);
    point.attitude[1] = goal.roll.value_or(point.attitude[1]);
    target = {space.pose(point), Asked::kPose};
  }
  // The joints that were taught, whatever the jaws do.
  if (goal.of_joints && goal.R_BT) p = p + ahead * goal.R_BT->z;
  return with_offset(goal, target, space);
}

bool is_streamed(const RobotModel& robot) {
  return robot.device.capability.motion == MotionKind::kStream;
}

/// A host that makes the motion makes it as it likes; of the devices that do, only this one can be
/// told accelerations.
bool takes_acceleration(const RobotModel& robot) {
  return is_streamed(robot) || robot.device.settings->takes_acceleration();
}

Move move_of(const Step& row, const RobotPlace& from, const ToolSpace& space,
             const RobotModel& robot, double ahead) {
  const MotionOptions& how = *motion_of(row);
  const Unheard not_told = unheard(how, robot);
  Move move;
  if (!not_told.speed) {
    move.joint_share = how.joint_share;
    move.tool_speed = how.tool_speed;
  }
  if (!not_told.acceleration) move.tool_acceleration = how.tool_acceleration;
  if (!not_told.blend) {
    move.blend_radius = how.blend_radius;
    move.blend_joints = how.blend_joints;
  }
  if (const auto* joint = std::get_if<JointStep>(&row.what)) {
    const JointVector q = vector_of(from.q, space.size());
    move.way = planning::MoveJ{array_of(resolved(*joint, q))};
  } else if (const auto* tool = std::get_if<ToolMoveStep>(&row.what)) {
    const ToolTarget target = target_of(tool->to, from, space, ahead);
    using Way = ToolMoveStep::Way;
    if (tool->way == Way::kJoints) move.way = planning::MoveTo{target};
    if (tool->way == Way::kLine) move.way = planning::MoveL{target};
    if (tool->way == Way::kArc) move.way = planning::MoveC{tool->p_via_BT, target};
  } else {
    planning::MoveSpline spline;
    for (const Vec3& p : *std::get<SplineStep>(row.what).through) {
      spline.through.push_back({{from.X_BT.R, p}, Asked::kPoint});
    }
    move.way = spline;
  }
  return move;
}

bool names_orientation(const ToolGoal& goal) {
  return goal.R_BT || goal.pitch || goal.roll || (goal.offset && goal.offset->turns());
}

void turn_to(const kinematics::PoseBT& X_BT, Move& move) {
  if (auto* to = std::get_if<planning::MoveTo>(&move.way)) to->to = {X_BT, Asked::kPose};
  if (auto* line = std::get_if<planning::MoveL>(&move.way)) line->to = {X_BT, Asked::kPose};
}

double tips_ahead(const ToolState& tool, const RobotModel& robot) {
  const auto* serial = std::get_if<SerialGeometry>(&robot.geometry);
  if (serial == nullptr || !serial->gripper || !tool.jaws) return 0;
  return jaw_reach(*serial->gripper, *tool.jaws) - serial->gripper->reach_open;
}

SeparateMoves::Move times_of(SeparateMoves& times, const JointVector& from, const JointVector& to,
                             const RobotModel& robot) {
  const auto limits = planning::motion_limits(robot);
  JointVector own;
  for (std::size_t j = 0; j < from.size(); ++j) {
    const double way = times.target(j, to[j]) - times.target(j, from[j]);
    own.push_back(way == 0 ? 0 : motion::plan_axis(std::abs(way), limits[j]).duration());
  }
  return times.next({own.data(), own.size()});
}

/// A motion that cannot take `asked` s but `limit`: told with three digits that work.
Error time_error(double asked, double limit) {
  const double unit = std::pow(10, std::floor(std::log10(limit)) - 2);
  const double told = asked < limit ? std::ceil(limit / unit) : std::floor(limit / unit);
  return {ErrorCode::kSegmentTime, -1, asked, told * unit};
}

/// When a law comes to s.
double time_at(const planning::TimeLaw& law, double s) {
  double before = 0, after = law.duration();
  if (s >= law.sample(after).s) return after;
  while (after - before > 1e-6) {
    const double middle = (before + after) / 2;
    (law.sample(middle).s < s ? before : after) = middle;
  }
  return after;
}

RobotModel with_limits(RobotModel robot, const JointShares& shares) {
  for (std::size_t j = 0; j < robot.joints.size(); ++j) {
    Joint& joint = robot.joints[j];
    joint.velocity_max *= shares.velocity[j];
    joint.acceleration_max *= shares.acceleration[j];
    // A ramp keeps its shape.
    joint.jerk_max *= shares.acceleration[j];
  }
  return robot;
}

}  // namespace

Unheard unheard(const MotionOptions& how, const RobotModel& robot) {
  const bool paced =
      how.joint_share != 1 || std::isfinite(how.tool_speed) || how.limits || how.time > 0;
  return {.speed = paced && !robot.device.capability.takes_speed,
          .acceleration = std::isfinite(how.tool_acceleration) && !takes_acceleration(robot),
          .blend = how.blends() && !is_streamed(robot),
          .beyond = how.limits && (std::ranges::max(how.limits->velocity) > 1 ||
                                   std::ranges::max(how.limits->acceleration) > 1)};
}

RowPlanner::RowPlanner(const RobotModel& robot)
    : robot_(robot),
      delay_(robot.device.settings->motion_delay()),
      wire_(robot),
      planner_(robot),
      motion_(planner_.make_motion()) {}

struct RowPlanner::Limited {
  Limited(const RobotModel& whole, std::shared_ptr<const JointShares> asked)
      : shares(std::move(asked)), robot(with_limits(whole, *shares)), planner(robot) {}

  std::shared_ptr<const JointShares> shares;
  RobotModel robot;
  RowPlanner planner;
};

RowPlanner::~RowPlanner() = default;

const planning::PlannedMotion& RowPlanner::motion() const {
  return limited_now_ ? limited_->planner.motion_ : motion_;
}

const RobotModel& RowPlanner::robot() const {
  return limited_now_ ? limited_->robot : robot_;
}

void RowPlanner::propose(bool wanted) {
  proposes_ = wanted;
  if (limited_) limited_->planner.propose(wanted);
}

void RowPlanner::show_to(WayLook look) {
  look_ = std::move(look);
  limited_.reset();
}

std::expected<RowMotion, Refusal> RowPlanner::plan_limited(const JointVector& q_start,
                                                           const ToolState& tool,
                                                           std::span<const Step> rows) {
  const auto& shares = motion_of(rows[0])->limits;
  if (!limited_ || !(*limited_->shares == *shares)) {
    limited_ = std::make_unique<Limited>(robot_, shares);
    limited_->planner.show_to(look_);
    limited_->planner.propose(proposes_);
  }
  limited_->planner.around_ = around_;
  return limited_->planner.plan_rows(q_start, tool, rows);
}

std::expected<RowMotion, Refusal> RowPlanner::plan(const JointVector& q_start,
                                                   const ToolState& tool,
                                                   std::span<const Step> rows,
                                                   std::span<const planning::Surrounding> around) {
  SINEW_ASSERT(!rows.empty());
  around_ = around;
  const auto& limits = motion_of(rows[0])->limits;
  // Rows of other limits do not blend with these, nor does one that has a time of its own.
  const auto others = std::ranges::find_if_not(rows, [&](const Step& row) {
    const auto& own = motion_of(row)->limits;
    if (&row != rows.data() && motion_of(row)->time > 0) return false;
    return own == limits || (own && limits && *own == *limits);
  });
  const auto alike = rows.first(static_cast<std::size_t>(others - rows.begin()));
  auto planned = plan_alike(q_start, tool, alike);
  if (planned || !planned.error().way) return planned;
  WayRefusal& why = *planned.error().way;
  why.tool = tool;
  if (planned.error().error.code == ErrorCode::kCollision && !tool.jaws) {
    why.jaws_first = jaws_first(q_start, alike);
  }
  return planned;
}

std::expected<RowMotion, Refusal> RowPlanner::plan_alike(const JointVector& q_start,
                                                         const ToolState& tool,
                                                         std::span<const Step> rows) {
  limited_now_ = motion_of(rows[0])->limits != nullptr;
  return limited_now_ ? plan_limited(q_start, tool, rows) : plan_rows(q_start, tool, rows);
}

std::optional<double> RowPlanner::jaws_first(const JointVector& q_start,
                                             std::span<const Step> rows) {
  const auto* serial = std::get_if<SerialGeometry>(&robot_.geometry);
  if (serial == nullptr || !serial->gripper) return std::nullopt;
  const double open = serial->gripper->width_max;
  if (!check_jaws(q_start, {}, open, around_)) return std::nullopt;
  if (!plan_alike(q_start, {open, std::nullopt}, rows)) return std::nullopt;
  return open;
}

std::expected<RowMotion, Refusal> RowPlanner::plan_rows(const JointVector& q_start,
                                                        const ToolState& tool,
                                                        std::span<const Step> rows) {
  planner_.fit(tool);
  planner_.surround(around_);
  tips_ahead_ = tips_ahead(tool, robot_);
  const auto start = planner_.place_at({q_start.data(), q_start.size()});
  if (!start) return std::unexpected(Refusal{rows[0].line, start.error(), std::nullopt});
  attitudes_.assign(rows.size(), {});
  for (std::optional<Refusal> kept;;) {
    auto made = make_moves(*start, rows);
    if (made) made = plan_moves(*start, rows);
    if (made) break;
    keep_refusal(made.error(), kept);
    if (!choose_attitude(rows, made.error())) return std::unexpected(std::move(*kept));
  }
  RowMotion out;
  out.rows = motion_.stretch.moves;
  out.q_end = vector_of(motion_.stretch.end.q, robot_.joints.size());
  // To the last bit where the row said it.
  if (const auto* last = std::get_if<planning::MoveJ>(&moves_[out.rows - 1].way)) {
    out.q_end = vector_of(last->q, robot_.joints.size());
  }
  tell_stop(rows, out);
  if (motion_.empty()) return out;
  const MotionOptions& how = *motion_of(rows[0]);
  out.time = unheard(how, robot_).speed ? 0 : how.time;
  if (out.time > 0) {
    if (const auto error = take_time(out)) return std::unexpected(Refusal{rows[0].line, *error});
  }
  const std::span<const double> from(q_start.data(), q_start.size());
  if (const auto error = wire_.refusal({out.q_end.data(), out.q_end.size()}, from)) {
    const double end = motion_.path.joints.length();
    return std::unexpected(unsayable(rows, *start, end, out.q_end, *error));
  }
  if (is_streamed(robot_)) {
    if (auto cut = cut_into_segments(rows, *start, out); !cut) return std::unexpected(cut.error());
  } else {
    if (auto cut = cut_into_moves(rows, *start, out); !cut) return std::unexpected(cut.error());
  }
  if (const auto error = shown(q_start, out)) return std::unexpected(Refusal{rows[0].line, *error});
  return out;
}

/// Led along a way it is as slow as that: by a law that can be paused, as a running cell's is.
std::optional<Error> RowPlanner::take_time(const RowMotion& out) {
  if (!is_streamed(robot_)) return std::nullopt;
  if (!follower_) follower_ = std::make_unique<planning::PathFollower>();
  const auto error = follower_->start(motion_.path, planning::motion_limits(robot_), 1,
                                      planning::shared_velocity(robot_), out.time);
  if (error && error->code == ErrorCode::kSegmentTime) return time_error(out.time, error->limit);
  if (error) return error;
  motion_.law = follower_->law();
  motion_.limits = follower_->limit_times();
  return std::nullopt;
}

/// From stop to stop each move is slowed alike; the last one's report comes behind that time.
std::optional<Error> RowPlanner::slow_down(RowMotion& out) const {
  double own = 0;
  for (const JointMove& piece : out.pieces) own += to_seconds(piece.duration);
  const double stops = static_cast<double>(out.pieces.size() - 1) * to_seconds(delay_.report);
  constexpr double kRounding = 1e-6;  // s
  if (out.time < own + stops - kRounding) return time_error(out.time, own + stops);
  const double slower = std::max(1.0, (out.time - stops) / own);
  for (JointMove& piece : out.pieces) {
    piece.duration = from_seconds(slower * to_seconds(piece.duration));
  }
  out.arrival += (slower - 1) * own;
  out.duration += (slower - 1) * own;
  return std::nullopt;
}

std::optional<Error> RowPlanner::shown(const JointVector& q_start, const RowMotion& motion) const {
  if (!look_) return std::nullopt;
  if (is_streamed(robot_)) return look_(planning::CellWay(motion_.path.joints));
  const auto way = control::PieceMotion(q_start, motion.pieces, robot_).way();
  return way ? look_(*way) : std::nullopt;
}

/// The rows that go into one motion; each one's target depends on where the one before it ends.
std::expected<void, Refusal> RowPlanner::make_moves(const RobotPlace& start,
                                                    std::span<const Step> rows) {
  moves_.clear();
  RobotPlace at = start;
  for (std::size_t i = 0; i < std::min(rows.size(), kRowsMax); ++i) {
    Move& move = moves_.emplace_back(move_of(rows[i], at, planner_.space(), robot_, tips_ahead_));
    if (attitudes_[i].X_BT) turn_to(*attitudes_[i].X_BT, move);
    const bool blended = move.blend_radius > 0 || move.blend_joints > 0;
    if (!blended || i + 1 == std::min(rows.size(), kRowsMax)) break;
    const auto end = planner_.end_of(at, move);
    if (!end) {
      planning::PathRefusal why = end.error();
      why.place.move = i;
      return std::unexpected(refusal(rows, why));
    }
    at = *end;
  }
  return {};
}

std::expected<void, Refusal> RowPlanner::plan_moves(const RobotPlace& start,
                                                    std::span<const Step> rows) {
  for (std::size_t tries = 0;; ++tries) {
    const auto planned = planner_.plan(start, moves_, 0, motion_);
    if (planned) return {};
    Refusal why = refusal(rows, planned.error());
    if (tries == rows.size() || !come_nearer(*why.way)) return std::unexpected(std::move(why));
  }
}

/// Of one row with several orientations: of what is in reach the obstacle counts, of what is in
/// reach with none the orientation that comes nearest; and the nearest place of all.
void RowPlanner::keep_refusal(Refusal now, std::optional<Refusal>& kept) const {
  if (!kept) {
    kept = std::move(now);
    return;
  }
  const bool nearest = now.way && attitudes_[now.way->refusal.place.move].nearest;
  if (nearest || now.error.code == ErrorCode::kCollision) std::swap(now, *kept);
  if (!now.way || !kept->way || now.line != kept->line) return;
  auto& near = kept->way->proposal.near;
  const auto& other = now.way->proposal.near;
  if (other && (!near || other->left < near->left)) near = other;
}

/// Where a row leaves the orientation open and the one at hand is refused: first the pitch that the
/// arm's inverse chooses for a point, then the least turn that works; where no pitch reaches the
/// point, the one that comes nearest.
/// @return  false where there is no other one to try
bool RowPlanner::choose_attitude(std::span<const Step> rows, const Refusal& refusal) {
  if (!refusal.way) return false;
  const std::size_t k = refusal.way->refusal.place.move;
  const auto* row = std::get_if<ToolMoveStep>(&rows[k].what);
  if (row == nullptr || names_orientation(row->to)) return false;
  const planning::ToolTarget* target = nullptr;
  if (const auto* to = std::get_if<planning::MoveTo>(&moves_[k].way)) target = &to->to;
  if (const auto* line = std::get_if<planning::MoveL>(&moves_[k].way)) target = &line->to;
  if (target == nullptr) return false;
  Attitude& attitude = attitudes_[k];
  const ToolSpace& space = planner_.space();
  const auto* serial = std::get_if<SerialGeometry>(&robot_.geometry);
  if (attitude.tries++ == 0 && serial != nullptr && space.task() != planning::TaskSpace::kPose) {
    const RobotPlace& from = refusal.way->refusal.from;
    const auto pitched = space.serial()->inverse_nearest_pitch(
        target->X_BT.p, serial->pitch_preferred, {from.q.data(), space.size()});
    if (pitched && space.task() == planning::TaskSpace::kPitchRoll) {
      const double roll = space.point(from.X_BT).attitude[1];
      attitude.X_BT = space.pose({target->X_BT.p, {pitched->pitch, roll}});
      return true;
    }
    const auto& near = refusal.way->proposal.near;
    if (!pitched && near) {
      const auto X_BT = space.forward({near->q.data(), space.size()}, from.X_BT);
      attitude = {3, space.pose({target->X_BT.p, space.point(*X_BT).attitude}, X_BT->R), true};
      return true;
    }
    const auto best = nearest_pitch(*space.serial(), target->X_BT.p);
    if (!pitched && best && space.task() == planning::TaskSpace::kPitchRoll) {
      const double roll = space.point(from.X_BT).attitude[1];
      attitude = {3, space.pose({target->X_BT.p, {*best, roll}}), true};
      return true;
    }
  }
  const auto& tilted = refusal.way->proposal.tilted;
  const bool joints_only = tilted && tilted->q && row->way != ToolMoveStep::Way::kJoints;
  if (attitude.tries > 2 || !tilted || joints_only) return false;
  attitude.tries = 3;
  attitude.X_BT = tilted->X_BT;
  return true;
}

/// A target that is no farther away than kReachTolerance becomes the nearest place in reach.
bool RowPlanner::come_nearer(const WayRefusal& why) {
  const auto& near = why.proposal.near;
  Move& move = moves_[why.refusal.place.move];
  if (!near || near->left > kReachTolerance) return false;
  if (std::holds_alternative<planning::MoveTo>(move.way)) {
    move.way = planning::MoveJ{near->q};
    return true;
  }
  auto* line = std::get_if<planning::MoveL>(&move.way);
  const std::span<const double> q(near->q.data(), robot_.joints.size());
  const auto X_BT = planner_.space().forward(q, why.refusal.from.X_BT);
  if (line == nullptr || !X_BT) return false;
  line->to = {*X_BT, Asked::kPose};
  return true;
}

Refusal RowPlanner::refusal(std::span<const Step> rows, const planning::PathRefusal& why) {
  return {rows[why.place.move].line, why.error,
          WayRefusal{why, proposes_ ? planner_.propose(why, moves_) : planning::MoveProposal{}}};
}

/// Why it ends where another one of its moves would have gone on.
void RowPlanner::tell_stop(std::span<const Step> rows, RowMotion& out) {
  if (out.rows == moves_.size() || out.rows == rows.size()) return;
  if (motion_.stop) {
    out.stop = CornerStopReason::kCostsTime;
    out.stop_saves = motion_.stop->lost;
    return;
  }
  const RobotPlace corner = motion_.stretch.end;
  const auto next = planner_.end_of(corner, moves_[out.rows]);
  const bool stays = motion_.empty() || (next && next->q == corner.q);
  out.stop = stays ? CornerStopReason::kNoWay : CornerStopReason::kNoFit;
}

/// The wire cannot say q, which is at s of the motion at hand.
Refusal RowPlanner::unsayable(std::span<const Step> rows, const RobotPlace& start, double s,
                              const JointVector& q, const Error& error) const {
  const planning::PathProgress at = planning::Trajectory::progress_at(motion_.path, s);
  planning::PathSection of_move;
  for (const planning::PathSection& section : motion_.path.sections) {
    if (section.move == at.move) of_move = section;
  }
  const planning::MovePlace place{at.move, s - of_move.begin, at.move_share, of_move.metres};
  Refusal refusal{rows[at.move].line, error,
                  WayRefusal{{error, place, std::nullopt, start}, {}, std::nullopt}};
  if (error.index < 0) return refusal;
  const auto joint = static_cast<std::size_t>(error.index);
  Unsayable& what = refusal.way->unsayable.emplace(Unsayable{joint, q[joint], std::nullopt});
  if (s == motion_.path.joints.length()) {
    what.nearest = wire_.nearest({q.data(), q.size()});
  } else {
    refusal.way->proposal.move_j = motion_.stretch.end.q;
  }
  return refusal;
}

/// Equal times, none longer than the device's segment.
std::expected<void, Refusal> RowPlanner::cut_into_segments(std::span<const Step> rows,
                                                           const RobotPlace& start,
                                                           RowMotion& out) const {
  const double duration = motion_.law.duration();
  const double longest = to_seconds(robot_.device.capability.segment);
  const double most = longest * static_cast<double>(kPiecesMax);
  if (!(duration <= most)) {
    const Error error{ErrorCode::kSegmentTime, -1, duration, most};
    return std::unexpected(Refusal{rows[0].line, error, std::nullopt});
  }
  const auto count = static_cast<std::size_t>(std::max(1.0, std::ceil(duration / longest)));
  // A motion shorter than one segment is one: no wire says less.
  const double segment =
      count == 1 ? longest : control::piece_time(duration / static_cast<double>(count));
  const planning::Trajectory trajectory = motion_.trajectory();
  const std::span<const double> from(start.q.data(), robot_.joints.size());
  planning::JointMotion at;
  out.pieces.reserve(count);
  for (std::size_t k = 1; k <= count; ++k) {
    const bool last = k == count;
    const double t = last ? duration : std::min(duration, segment * static_cast<double>(k));
    trajectory.sample(t, at);
    JointMove piece{.q = {}, .qd = {}, .duration = from_seconds(segment)};
    for (std::size_t j = 0; j < robot_.joints.size(); ++j) {
      piece.q.push_back(last ? out.q_end[j] : at.q[j]);
      piece.qd.push_back(last ? 0 : at.qd[j]);
    }
    if (const auto error = wire_.refusal({piece.q.data(), piece.q.size()}, from)) {
      const double s = motion_.law.sample(t).s;
      return std::unexpected(unsayable(rows, start, s, piece.q, *error));
    }
    out.pieces.push_back(piece);
  }
  const double whole = segment * static_cast<double>(count);
  out.arrival = whole + to_seconds(delay_.arrival);
  out.duration = whole + to_seconds(delay_.report);
  return {};
}

/// From rest to rest, and no faster than the tool was asked to be.
/// @param in_motion  s that the motion without stops takes for this piece
double RowPlanner::piece_duration(const JointVector& from, const JointVector& to, const Move& move,
                                  double in_motion) const {
  double duration = whole_move_duration(from, to, robot_, move.joint_share);
  if (std::isfinite(move.tool_acceleration)) {
    // A profile that takes k times as long has a k-th of its speeds, and accelerations of those;
    // but the device's settings are whole numbers, and its joints go together only nearly.
    constexpr double kShare = 0.8;
    const double own = tool_acceleration(from, to, move.joint_share);
    duration *= std::max(1.0, std::sqrt(own / (kShare * move.tool_acceleration)));
  }
  return std::isfinite(move.tool_speed) ? std::max(duration, in_motion) : duration;
}

/// The greatest one of the tool on a whole move at the joints' own pace, m/s^2.
double RowPlanner::tool_acceleration(const JointVector& from, const JointVector& to,
                                     double share) const {
  constexpr int kLooks = 400;
  const motion::RestToRest profile = profile_between(from, to, robot_, share);
  if (!(profile.duration() > 0)) return 0;
  const double dt = profile.duration() / kLooks;
  PoseBT X_near = planner_.space().home();
  motion::AxisStates at{};
  const auto tool = [&](double t) {
    profile.sample(t, at);
    const auto X_BT = planner_.space().forward({at.q.data(), from.size()}, X_near);
    if (X_BT) X_near = *X_BT;
    return X_near.p;
  };
  double greatest = 0;
  Vec3 before = tool(0), here = tool(dt);
  for (int k = 2; k <= kLooks; ++k) {
    const Vec3 next = tool(k * dt);
    greatest = std::max(greatest, norm(next - 2 * here + before) / (dt * dt));
    before = here;
    here = next;
  }
  return greatest;
}

JointVector RowPlanner::joints_at(double s) const {
  planning::PathPoint at;
  motion_.path.joints.sample(s, at);
  return vector_of(at.q, robot_.joints.size());
}

/// How far the tool leaves the way on one straight move of the joints, m; as chords() measures.
double RowPlanner::off_way(double begin, double end, const PoseBT& X_near) const {
  constexpr int kLooks = 8;
  const JointVector from = joints_at(begin), to = joints_at(end);
  double farthest = 0;
  for (int k = 1; k < kLooks; ++k) {
    const double share = static_cast<double>(k) / kLooks;
    const JointVector on = joints_at(begin + share * (end - begin));
    JointVector beside = from;
    for (std::size_t j = 0; j < beside.size(); ++j) beside[j] += share * (to[j] - from[j]);
    const auto X_on = planner_.space().forward({on.data(), on.size()}, X_near);
    const auto X_beside = planner_.space().forward({beside.data(), beside.size()}, X_near);
    if (!X_on || !X_beside) return std::numeric_limits<double>::infinity();
    farthest = std::max({farthest, norm(X_on->p - X_beside->p),
                         planning::kTurnRadius * angle_between(X_on->R, X_beside->R)});
  }
  return farthest;
}

/// Where the moves end that follow the way. A gap that the wire cannot say is crossed by one move
/// where that stays near the way; then it may be longer than kChordMax.
std::expected<std::vector<double>, Refusal> RowPlanner::chord_places(
    std::span<const Step> rows, const RobotPlace& start) const {
  const planning::PlannedPath& path = motion_.path;
  const double length = path.joints.length();
  const bool joints_straight = std::holds_alternative<planning::MoveJ>(moves_[0].way) ||
                               std::holds_alternative<planning::MoveTo>(moves_[0].way);
  if (joints_straight) return std::vector<double>{length};
  const auto refused_at = [&](double s) {
    const JointVector q = joints_at(s);
    return wire_.refusal({q.data(), q.size()}, {start.q.data(), q.size()});
  };
  constexpr double kLook = 0.1e-3;  // m
  double last = 0;
  std::vector<double> out;
  for (const double s :
       planning::chords(planner_.space(), path, kWayTolerance, kChordMax, start.X_BT)) {
    if (s <= last) continue;  // skipped with a gap
    const auto error = s == length ? std::nullopt : refused_at(s);
    if (!error) {
      out.push_back(last = s);
      continue;
    }
    double before = s, behind = s;
    while (before > last && refused_at(before)) before = std::max(last, before - kLook);
    while (behind < length && refused_at(behind)) behind = std::min(length, behind + kLook);
    if (before > last && off_way(last, behind, start.X_BT) > kWayTolerance) {
      out.push_back(last = before);
    }
    if (off_way(last, behind, start.X_BT) > kWayTolerance) {
      return std::unexpected(unsayable(rows, start, s, joints_at(s), *error));
    }
    out.push_back(last = behind);
  }
  return out;
}

/// Point-to-point moves from stop to stop; where joints do not arrive together, what they really
/// pass on each of them has to be clear as well.
std::expected<void, Refusal> RowPlanner::cut_into_moves(std::span<const Step> rows,
                                                        const RobotPlace& start, RowMotion& out) {
  auto places = chord_places(rows, start);
  if (!places) return std::unexpected(places.error());
  std::optional<Refusal> contact;
  for (int halvings = 0; halvings <= kHalvingsMax; ++halvings) {
    out.pieces.clear();
    out.arrival = out.duration = 0;
    cut_into_chords(start, *places, out);
    contact = driven_contact(rows, start, *places, out);
    if (!contact) break;
    std::vector<double> halved;
    for (const double place : *places) {
      const double before = halved.empty() ? 0 : halved.back();
      halved.insert(halved.end(), {(before + place) / 2, place});
    }
    *places = std::move(halved);
  }
  if (contact) return std::unexpected(std::move(*contact));
  if (out.time > 0) {
    if (const auto error = slow_down(out)) return std::unexpected(Refusal{rows[0].line, *error});
  }
  const double longest = to_seconds(robot_.device.settings->move_times().second);
  for (std::size_t k = 0; k < out.pieces.size(); ++k) {
    const double duration = to_seconds(out.pieces[k].duration);
    if (duration <= longest) continue;
    const Error error{ErrorCode::kSegmentTime, -1, duration, longest};
    return std::unexpected(unsayable(rows, start, (*places)[k], out.pieces[k].q, error));
  }
  return {};
}

/// What joints hit that go separately, each at its own pace from when it was commanded.
std::optional<Refusal> RowPlanner::driven_contact(std::span<const Step> rows,
                                                  const RobotPlace& start,
                                                  std::span<const double> places,
                                                  const RowMotion& out) const {
  if (!robot_.device.settings->separate_moves(robot_)) return std::nullopt;
  constexpr double kKnots = 0.1;  // s
  const WholeMoves driven(vector_of(start.q, robot_.joints.size()), out, 1, robot_);
  const auto count = static_cast<std::size_t>(std::ceil(driven.duration() / kKnots)) + 1;
  std::vector<double> knots;
  std::vector<JointArray> points;
  planning::JointMotion at;
  for (std::size_t k = 0; k <= count; ++k) {
    knots.push_back(driven.duration() * static_cast<double>(k) / static_cast<double>(count));
    driven.sample(knots.back(), at);
    points.push_back(at.q);
  }
  planning::JointPath path(robot_.joints.size(), knots.size());
  path.append_spline(knots, points, {}, {});
  const auto contact = planner_.contact_on(start, path);
  if (!contact) return std::nullopt;
  // The move under way then.
  std::size_t move = 0;
  for (double t = 0; move + 1 < places.size(); ++move) {
    t += to_seconds(out.pieces[move].duration);
    if (t > contact->s) break;
  }
  const double length = motion_.path.joints.length();
  const Error error = planning::contact_error(robot_, contact->nearest);
  const double share = places[move] / length;
  const planning::MovePlace place{0, places[move], share, motion_.path.sections[0].metres};
  return Refusal{rows[0].line, error, WayRefusal{{error, place, std::nullopt, start}, {}, {}}};
}

void RowPlanner::cut_into_chords(const RobotPlace& start, std::span<const double> places,
                                 RowMotion& out) const {
  JointVector from = vector_of(start.q, robot_.joints.size());
  double t_from = 0;
  const auto times = robot_.device.settings->separate_moves(robot_);
  for (const double s : places) {
    const bool last = s == places.back();
    const JointVector to = last ? out.q_end : joints_at(s);
    const double t = time_at(motion_.law, s);
    const double duration = std::max(piece_duration(from, to, moves_[0], t - t_from),
                                     to_seconds(robot_.device.settings->move_times().first));
    constexpr double kForever = 1e6;  // s; what is refused must not overflow before
    JointMove piece{.q = to, .qd = {}, .duration = from_seconds(std::min(duration, kForever))};
    piece.qd.resize(to.size());
    out.pieces.push_back(piece);
    double arrival = duration + to_seconds(delay_.arrival);
    double report = duration + to_seconds(delay_.report);
    if (times) {
      const auto move = times_of(*times, from, to, robot_);
      arrival = move.arrival;
      report = move.report;
    }
    out.arrival = out.duration + arrival;
    out.duration += report;
    from = to;
    t_from = t;
  }
}

JointVector resolved(const JointStep& step, const JointVector& from) {
  JointVector q = from;
  for (std::size_t i = 0; i < q.size(); ++i) {
    if ((step.given >> i & 1) != 0) q[i] = step.q[i] + ((step.relative >> i & 1) != 0 ? q[i] : 0);
  }
  return q;
}

double whole_move_duration(const JointVector& from, const JointVector& to, const RobotModel& robot,
                           double speed) {
  if (const auto times = robot.device.settings->separate_moves(robot)) {
    return times_of(*times, from, to, robot).own;
  }
  return profile_between(from, to, robot, speed).duration();
}

motion::RestToRest profile_between(const JointVector& from, const JointVector& to,
                                   const RobotModel& robot, double speed) {
  auto limits = planning::straight_limits(robot, from, to);
  const double share = robot.device.capability.takes_speed ? speed : 1;
  for (motion::AxisLimits& limit : limits) {
    limit = {share * limit.velocity, share * limit.acceleration, share * limit.jerk};
  }
  const std::size_t size = robot.joints.size();
  return {std::span(from.data(), size), std::span(to.data(), size), limits};
}

}  // namespace sinew::program
