#include "sinew/planning/paths/move_path.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "sinew/core/assert.h"
#include "sinew/core/error_code.h"
#include "sinew/core/units.h"
#include "sinew/model/joint_value.h"
#include "sinew/planning/paths/tool_rate.h"

namespace sinew::planning {
namespace {

/// Shorter blends (m) are stops.
constexpr double kBlendMin = 1e-5;
/// A tool that would have to creep below this part of the speed that was asked for, or below this
/// speed (m/s; a slow machine: a tenth of its own), is refused.
constexpr double kCreepShare = 0.01;
constexpr double kCreepSpeed = 0.5e-3;
constexpr double kSlowMachine = 0.1;
/// Where nobody asked for a speed, places below this part of the speed elsewhere are told.
constexpr double kSlowShare = 0.2;
/// A refused way is looked at so closely for an earlier place where something is wrong, m.
constexpr double kLookStep = 0.25e-3;
/// Places of a straight piece or of a blend where its tool is looked at.
constexpr std::size_t kLooks = 32;

/// How far two places are apart by the joint that differs most: rad, and m of legs. 0.1 m of an
/// arm's joint that slides count as 1 rad.
double farthest_joint(const ToolSpace& space, const JointArray& a, const JointArray& b) {
  double largest = 0;
  for (std::size_t j = 0; j < space.size(); ++j) {
    const bool slides = space.serial() != nullptr && space.joints()[j].slides();
    const double apart = std::abs(a[j] - b[j]);
    largest = std::max(largest, slides ? apart / kTurnRadius : apart);
  }
  return largest;
}

}  // namespace

bool slows_down(const Error& singularity) {
  constexpr double kNearSine = 0.2;
  constexpr double kNearValue = 0.02;
  constexpr double kNearDistance = 0.03;  // m
  if (singularity.code == ErrorCode::kShoulderSingular) return singularity.measured < kNearDistance;
  return singularity.measured < (singularity.code == ErrorCode::kSingular ? kNearValue : kNearSine);
}

MovePathBuilder::MovePathBuilder(const ToolSpace& space, const BuildLimits& limits)
    : space_(space),
      limits_(limits),
      way_(space),
      ahead_(space),
      spline_(space, limits.pieces),
      line_(space.size(), 1) {
  legs_.reserve(limits.moves);
  blends_.reserve(limits.moves);
}

Expected<RobotPlace> MovePathBuilder::place_at(std::span<const double> q,
                                               const PoseBT& X_near) const {
  const auto place = stand_at(q, X_near);
  if (!place) return place;
  if (const auto error = limit_broken(place->q)) return std::unexpected(*error);
  return place;
}

Expected<RobotPlace> MovePathBuilder::stand_at(std::span<const double> q,
                                               const PoseBT& X_near) const {
  SINEW_ASSERT(q.size() == space_.size());
  RobotPlace place;
  for (std::size_t j = 0; j < q.size(); ++j) {
    if (!std::isfinite(q[j])) return std::unexpected(Error{.code = ErrorCode::kMoveInput});
    if (std::abs(q[j]) > kFarTurn)
      return std::unexpected(beyond_limit(space_.joints()[j], j, q[j]));
    place.q[j] = q[j];
  }
  const auto X_BT = space_.forward(q, X_near);
  if (!X_BT) return std::unexpected(limit_broken(place.q).value_or(X_BT.error()));
  place.X_BT = *X_BT;
  return place;
}

std::expected<PathStretch, PathRefusal> MovePathBuilder::build(const RobotPlace& start,
                                                               std::span<const Move> moves,
                                                               std::size_t first,
                                                               PlannedPath& out) {
  SINEW_ASSERT(first < moves.size() && out.joints.joints() == space_.size());
  SINEW_ASSERT(out.joints.capacity() >= limits_.pieces);
  out.clear();
  legs_.clear();
  blends_.clear();
  legs_.push_back({.move = first, .from = start, .blend_max = kInfinity});
  legs_.back().room = JointRoom(space_.joints(), start.q);
  if (const auto at = stand_at(joints(start.q), start.X_BT); !at) {
    return std::unexpected(refusal(legs_.back(), at.error(), 0));
  }
  while (true) {
    const Result result = add(moves, out);
    if (!result) return std::unexpected(result.error());
    if (*result == Outcome::kStop) break;
    if (*result == Outcome::kBack) go_back(out);
  }
  PathStretch stretch{.moves = legs_.size(), .end = corner_, .slowdowns = {}};
  for (const Leg& leg : legs_) {
    if (leg.slowdown.tool_speed > 0 && !stretch.slowdowns.full()) {
      stretch.slowdowns.push_back(leg.slowdown);
    }
  }
  return stretch;
}

/// The last leg into the path; where another one follows, that becomes the last.
MovePathBuilder::Result MovePathBuilder::add(std::span<const Move> moves, PlannedPath& out) {
  Leg& leg = legs_.back();
  const Move& move = moves[leg.move];
  if (const auto fault = way_.make(move, leg.from)) {
    PathRefusal refused = refusal(leg, fault->error, 0);
    refused.nearest = fault->nearest;
    return std::unexpected(refused);
  }
  corner_ = leg.from;
  if (way_.length() == 0) return Outcome::kStop;
  if (!way_.straight_in_joints()) {
    // A tool's way says nothing of which joint comes in: only a move of the joints does.
    if (const auto outside = limit_broken(leg.from.q)) {
      return std::unexpected(refusal(leg, *outside, 0));
    }
  }
  if (const auto refused = find_corner(leg, move)) return std::unexpected(*refused);
  double blend = 0;
  const bool wanted = move.blend_radius > 0 || move.blend_joints > 0;
  if (wanted && leg.blend_max > 0 && leg.move + 1 < moves.size()) {
    if (const auto fault = ahead_.make(moves[leg.move + 1], corner_)) {
      PathRefusal refused = refusal({.move = leg.move + 1, .from = corner_}, fault->error, 0);
      refused.nearest = fault->nearest;
      return std::unexpected(refused);
    }
    blend = blend_length(leg, move);
  }
  const double end = way_.length() - blend;
  if (const auto refused = lay(leg, move, end)) return std::unexpected(*refused);
  if (out.joints.size() + 1 + laid().size() > limits_.pieces || legs_.size() == limits_.moves) {
    const auto pieces = static_cast<double>(limits_.pieces);
    return std::unexpected(
        refusal(leg, {ErrorCode::kProgramTooLong, -1, pieces + 1, pieces}, leg.lead));
  }
  if (leg.lead > 0 && !join(leg, moves[leg.move - 1], out)) return Outcome::kBack;
  append(leg, move, end, out);
  if (blend == 0) return Outcome::kStop;
  JointRoom room(space_.joints(), corner_.q);
  for (std::size_t j = 0; j < space_.size(); ++j) {
    room.lower[j] = std::max(room.lower[j], leg.room.lower[j]);
    room.upper[j] = std::min(room.upper[j], leg.room.upper[j]);
  }
  legs_.push_back({.move = leg.move + 1,
                   .from = corner_,
                   .lead = blend,
                   .blend_max = kInfinity,
                   .pieces = out.joints.size(),
                   .slowdown = {},
                   .room = room});
  return Outcome::kGoOn;
}

/// The blend before the last leg did not fit: the leg before it is laid anew with one half as long.
void MovePathBuilder::go_back(PlannedPath& out) {
  const double shorter = legs_.back().lead / 2;
  legs_.pop_back();
  Leg& leg = legs_.back();
  leg.blend_max = shorter >= kBlendMin ? shorter : 0;
  leg.slowdown = {};
  out.joints.truncate(leg.pieces);
  out.tool.resize(leg.pieces);
  out.sections.resize(legs_.size() - 1);
  blends_.resize(legs_.size() > 1 ? legs_.size() - 2 : 0);
}

PathRefusal MovePathBuilder::refusal(const Leg& leg, const Error& error, double s) const {
  const double length = way_.length();
  const double share = length > 0 ? std::clamp(s / length, 0.0, 1.0) : 0;
  return {error, {leg.move, s, share, way_.counts_metres()}, std::nullopt, leg.from};
}

std::optional<Error> MovePathBuilder::limit_broken(const JointArray& q) const {
  for (std::size_t j = 0; j < space_.size(); ++j) {
    if (!within_limits(space_.joints()[j], q[j])) return beyond_limit(space_.joints()[j], j, q[j]);
  }
  return std::nullopt;
}

/// What is wrong at one place of a tool's way.
std::optional<Error> MovePathBuilder::broken_at(const TaskPoint& point, const JointArray& q) const {
  if (const auto error = limit_broken(q)) return error;
  if (const auto* hexapod = space_.hexapod()) {
    const auto X_BP = relabel<frame::Base, frame::Platform>(space_.pose(point));
    const auto wrong = hexapod->check(X_BP, space_.joints());
    if (!wrong.empty()) return wrong[0];
  }
  return std::nullopt;
}

/// A way that cannot be followed at one place may be forbidden at an earlier one: that is what has
/// to be told.
PathRefusal MovePathBuilder::earliest(const Leg& leg, const WayFault& fault) const {
  const ToolWay& way = way_.tool();
  const auto knots = spline_.knots();
  const auto points = spline_.points();
  double good = spline_.begin();
  JointArray q_good = points[0];
  for (std::size_t i = 0; i + 1 < knots.size(); ++i) {
    // Closer than the knots: what leaves and comes back between two of them counts too.
    const double h = knots[i + 1] - knots[i];
    const int parts = static_cast<int>(std::ceil(h / kLookStep));
    for (int k = 1; k <= parts; ++k) {
      const double s = spline_.begin() + knots[i] + h * k / parts;
      if (s > fault.s) return refusal(leg, fault.error, fault.s);
      const auto q = space_.inverse_near(way.at(s), k == parts ? points[i + 1] : q_good);
      if (!q) break;
      if (const auto broken = broken_at(way.at(s), *q)) {
        return narrowed(leg, good, q_good, {*broken, s}, points.subspan(i + 1));
      }
      good = s;
      q_good = *q;
    }
  }
  return refusal(leg, fault.error, fault.s);
}

/// @param good, q_good  the last place where nothing is wrong
/// @param behind        knots behind it, for how far a joint goes out
PathRefusal MovePathBuilder::narrowed(const Leg& leg, double good, JointArray q_good, WayFault bad,
                                      std::span<const JointArray> behind) const {
  const ToolWay& way = way_.tool();
  while (bad.s - good > 1e-7) {
    const double middle = (good + bad.s) / 2;
    const auto q = space_.inverse_near(way.at(middle), q_good);
    if (!q) break;
    if (const auto broken = broken_at(way.at(middle), *q)) {
      bad = {*broken, middle};
    } else {
      good = middle;
      q_good = *q;
    }
  }
  Error& error = bad.error;
  if (error.code == ErrorCode::kJointLimit || error.code == ErrorCode::kLegLength) {
    const auto j = static_cast<std::size_t>(error.index);
    const bool below = error.measured < error.limit;
    for (const JointArray& q : behind) {
      error.measured = below ? std::min(error.measured, q[j]) : std::max(error.measured, q[j]);
    }
  }
  return refusal(leg, error, bad.s);
}

std::optional<PathRefusal> MovePathBuilder::find_corner(const Leg& leg, const Move& move) {
  const double length = way_.length();
  if (way_.straight_in_joints()) {
    corner_ = {way_.joints_at(length), way_.joint_end()};
    return std::nullopt;
  }
  if (const auto fault = spline_.march(way_.tool(), leg.from.q)) return earliest(leg, *fault);
  // Most refusals show here already, before anything is fitted.
  for (const JointArray& q : spline_.points()) {
    if (const auto broken = limit_broken(q)) return earliest(leg, {*broken, length});
  }
  const TaskPoint end = way_.tool().at(length);
  corner_.q = spline_.points().back();
  const auto X_BT = space_.forward(joints(corner_.q), space_.pose(end));
  if (!X_BT) return earliest(leg, {X_BT.error(), length});
  corner_.X_BT = *X_BT;
  // The roll that a rolling forearm leaves the tool with shows only here.
  const ToolTarget* target = nullptr;
  if (const auto* line = std::get_if<MoveL>(&move.way)) target = &line->to;
  if (const auto* arc = std::get_if<MoveC>(&move.way)) target = &arc->to;
  if (const auto* way = std::get_if<MoveSpline>(&move.way)) target = &way->through.back();
  if (space_.task() == TaskSpace::kApproach && target->asked == Asked::kPose) {
    const double off = angle_between(X_BT->R, target->X_BT.R);
    if (off > kTaskTolerance) {
      const Error error{ErrorCode::kRollNotFree, -1, off, kTaskTolerance};
      PathRefusal refused = refusal(leg, error, length);
      refused.nearest = NearestPose{*X_BT, end, error};
      return refused;
    }
  }
  return std::nullopt;
}

/// How far (m) before its end the path leaves way_, and as far behind its begin joins ahead_.
double MovePathBuilder::blend_length(const Leg& leg, const Move& move) const {
  const double length = way_.length();
  double most = std::min({(length - leg.lead) / 2, ahead_.length() / 2, leg.blend_max});
  const TaskPoint corner = space_.point(corner_.X_BT);
  const auto within = [&](const TaskPoint& point) {
    const double apart = std::max(norm(point.p_BT - corner.p_BT),
                                  kTurnRadius * turn_between(space_.task(), point, corner));
    return move.blend_radius == 0 || apart <= move.blend_radius;
  };
  const auto joints_within = [&](const MoveWay& way, double s) {
    return move.blend_joints == 0 || !way.straight_in_joints() ||
           farthest_joint(space_, way.joints_at(s), corner_.q) <= move.blend_joints;
  };
  const auto fits = [&](double d) {
    return within(way_.point_at(length - d)) && within(ahead_.point_at(d)) &&
           joints_within(way_, length - d) && joints_within(ahead_, d);
  };
  if (!(most >= kBlendMin)) return 0;
  if (fits(most)) return most;
  double fitting = 0;
  while (most - fitting > 1e-10) {
    const double middle = (fitting + most) / 2;
    (fits(middle) ? fitting : most) = middle;
  }
  return fitting >= kBlendMin ? fitting : 0;
}

/// The move between its blends, with everything checked that one move can be refused for.
std::optional<PathRefusal> MovePathBuilder::lay(Leg& leg, const Move& move, double end) {
  if (way_.straight_in_joints()) {
    line_.clear();
    const JointArray from = way_.joints_at(leg.lead);
    const JointArray to = way_.joints_at(end);
    const bool appended = line_.append_line(joints(from), joints(to), end - leg.lead);
    SINEW_ASSERT(appended);
    return check(leg);
  }
  if (const auto fault = spline_.cut(way_.tool(), leg.lead, end)) return earliest(leg, *fault);
  if (const auto fault = spline_.fit(way_.tool())) return earliest(leg, *fault);
  if (const auto refused = check(leg)) return refused;
  return check_speed(leg, move);
}

std::optional<PathRefusal> MovePathBuilder::check(const Leg& leg) {
  const JointPath& path = laid();
  const PieceRange all{0, path.size()};
  auto fault = first_limit_break(path, all, space_.joints(), leg.room);
  if (space_.hexapod() != nullptr) {
    PoseBT X_BT = space_.pose(way_.point_at(leg.lead));
    const auto platform = first_hexapod_refusal(space_, path, all, X_BT);
    if (platform && (!fault || platform->s < fault->s)) fault = platform;
  }
  if (!fault) return std::nullopt;
  return refusal(leg, fault->error, leg.lead + fault->s);
}

std::optional<PathRefusal> MovePathBuilder::check_speed(Leg& leg, const Move& move) {
  const JointPath& path = laid();
  const SlowestPlace slowest = slowest_place(path, {0, path.size()}, space_.joints(),
                                             move.joint_share, space_.shared_velocity());
  const double usual = std::min(move.tool_speed, slowest.rate_elsewhere);
  const bool asked = std::isfinite(move.tool_speed);
  const double creep =
      std::max(asked ? kCreepShare * usual : 0, std::min(kCreepSpeed, kSlowMachine * usual));
  if (slowest.rate >= (asked ? usual : kSlowShare * usual)) return std::nullopt;
  PathPoint at;
  path.sample(slowest.s, at);
  const double s = leg.lead + slowest.s;
  const auto X_BT = space_.forward(joints(at.q), space_.pose(way_.point_at(s)));
  const Error near = X_BT ? space_.singularity(joints(at.q), *X_BT) : X_BT.error();
  if (slowest.rate < creep) {
    const bool joint = slowest.by.kind == LimitKind::kJointVelocity;
    if (!joint || slows_down(near)) return refusal(leg, near, s);
    return refusal(leg, {ErrorCode::kVelocityLimit, slowest.by.joint, creep / slowest.rate, 1}, s);
  }
  const double tool_rate_there = spline_.rates()[path.piece_at(slowest.s)].speed;
  leg.slowdown = {refusal(leg, near, s).place, slowest.rate * tool_rate_there, slowest.by, near};
  return std::nullopt;
}

/// Rounds the corner before `leg`. @return false where the blend leaves what was asked for, or
/// what the robot can do
bool MovePathBuilder::join(const Leg& leg, const Move& before, PlannedPath& out) {
  const std::size_t piece = out.joints.size();
  PathPoint from;
  PathPoint to;
  out.joints.sample(out.joints.length(), from);
  laid().sample_piece(0, 0, to);
  // As long as both cut-off ends together: then the tool's velocity goes over evenly from one
  // direction to the other.
  const double length = 2 * leg.lead;
  const bool appended = out.joints.append_quintic(from, to, length);
  SINEW_ASSERT(appended);
  std::array<Vec3, kLooks + 1> p;
  PoseBT X_near = leg.from.X_BT;
  const double radius = before.blend_radius > 0 ? before.blend_radius : kInfinity;
  const double tolerance = before.blend_joints > 0 ? before.blend_joints : kInfinity;
  bool good = true;
  for (std::size_t k = 0; k <= kLooks && good; ++k) {
    PathPoint at;
    out.joints.sample_piece(piece, length * static_cast<double>(k) / kLooks, at);
    const auto X_BT = space_.forward(joints(at.q), X_near);
    good = X_BT.has_value();
    if (!good) break;
    X_near = *X_BT;
    p[k] = X_BT->p;
    good = norm(p[k] - leg.from.X_BT.p) <= radius + kPathTolerance &&
           farthest_joint(space_, at.q, leg.from.q) <= tolerance * (1 + 1e-9);
  }
  const PieceRange blend{piece, piece + 1};
  good = good &&
         !first_limit_break(out.joints, blend, space_.joints(), JointRoom(space_.joints(), from.q));
  if (good && space_.hexapod() != nullptr) {
    PoseBT X_BT = leg.from.X_BT;
    good = !first_hexapod_refusal(space_, out.joints, blend, X_BT);
  }
  if (!good) {
    out.joints.truncate(piece);
    return false;
  }
  out.tool.push_back(tool_rate(p, length / kLooks));
  blends_.push_back({leg.move - 1, leg.lead});
  return true;
}

void MovePathBuilder::append(const Leg& leg, const Move& move, double end, PlannedPath& out) {
  out.sections.push_back({.begin = std::max(out.joints.length() - leg.lead, 0.0),
                          .move = leg.move,
                          .tool_speed = move.tool_speed,
                          .tool_acceleration = move.tool_acceleration,
                          .joint_share = move.joint_share,
                          .metres = way_.counts_metres()});
  bool appended = false;
  if (way_.straight_in_joints()) {
    const JointArray from = way_.joints_at(leg.lead);
    const JointArray to = way_.joints_at(end);
    std::array<Vec3, kLooks + 1> p;
    PoseBT X_near = space_.pose(way_.point_at(leg.lead), leg.from.X_BT.R);
    for (std::size_t k = 0; k <= kLooks; ++k) {
      const double s = leg.lead + (end - leg.lead) * static_cast<double>(k) / kLooks;
      const auto X_BT = space_.forward(joints(way_.joints_at(s)), X_near);
      if (X_BT) X_near = *X_BT;
      p[k] = X_near.p;
    }
    appended = out.joints.append_line(joints(from), joints(to), end - leg.lead);
    out.tool.push_back(tool_rate(p, (end - leg.lead) / kLooks));
  } else {
    appended = spline_.append_to(out.joints);
    for (const ToolRate& rate : spline_.rates()) out.tool.push_back(rate);
  }
  SINEW_ASSERT(appended);
}

}  // namespace sinew::planning
