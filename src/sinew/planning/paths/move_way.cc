#include "sinew/planning/paths/move_way.h"

#include <algorithm>
#include <cmath>

#include "sinew/core/error_code.h"
#include "sinew/model/joint_value.h"

namespace sinew::planning {
namespace {

/// Joints that differ by less than this (rad or m) are the same.
constexpr double kNoTurn = 1e-10;
/// A move that hardly moves the tool counts as this much of a way for each rad, m.
constexpr double kJointWay = 0.01;
/// Pieces in which a joint move's tool way is measured.
constexpr int kWayParts = 32;

/// No robot is as large as this, m.
constexpr double kFarAway = 1e3;
/// What a sweep over a path can tell from standing.
constexpr double kToolMin = 1e-6;  // m/s, m/s^2
constexpr double kShareMin = 1e-3;

/// The one of its numbers that cannot be, or is too far away.
std::optional<double> far_away(const Vec3& v) {
  for (const double x : {v.x, v.y, v.z}) {
    if (!(std::abs(x) <= kFarAway)) return x;
  }
  return std::nullopt;
}

bool is_rotation(const Rotation& R) {
  constexpr double kRounding = 1e-6;
  const auto unit = [](const Vec3& v) { return std::abs(dot(v, v) - 1) <= kRounding; };
  return unit(R.x) && unit(R.y) && unit(R.z) && std::abs(dot(R.x, R.y)) <= kRounding &&
         norm(cross(R.x, R.y) - R.z) <= kRounding;
}

MoveFault bad_input(double measured = 0, double limit = 0) {
  return {{ErrorCode::kMoveInput, -1, measured, limit}, {}};
}

std::optional<MoveFault> fault_in(const ToolTarget& target) {
  if (const auto x = far_away(target.X_BT.p)) return bad_input(*x, kFarAway);
  if (target.asked != Asked::kPoint && !is_rotation(target.X_BT.R)) return bad_input();
  return std::nullopt;
}

/// Written so that what is no number fails.
std::optional<MoveFault> fault_in(const Move& move) {
  if (!(move.tool_speed >= kToolMin)) return bad_input(move.tool_speed, kToolMin);
  if (!(move.tool_acceleration >= kToolMin)) return bad_input(move.tool_acceleration, kToolMin);
  if (!(move.joint_share >= kShareMin)) return bad_input(move.joint_share, kShareMin);
  if (!(move.joint_share <= 1)) return bad_input(move.joint_share, 1);
  if (!(move.blend_radius >= 0)) return bad_input(move.blend_radius, 0);
  if (!(move.blend_joints >= 0)) return bad_input(move.blend_joints, 0);
  return std::nullopt;
}

/// R turned the shortest way so that its z axis is `z`.
Rotation turned_to(const Rotation& R, const Vec3& z) {
  const Vec3 across = cross(R.z, z);
  const double sine = norm(across);
  const double angle = std::atan2(sine, dot(R.z, z));
  const Vec3 axis = sine > 1e-12 ? (1 / sine) * across : R.x;
  return rotation_from_vector(angle * axis) * R;
}

}  // namespace

std::expected<TaskPoint, MoveFault> MoveWay::resolve(const ToolTarget& target,
                                                     const RobotPlace& from,
                                                     const TaskPoint& last) const {
  if (const auto fault = fault_in(target)) return std::unexpected(*fault);
  TaskPoint kept = last;
  kept.p_BT = target.X_BT.p;
  const TaskSpace task = space_.task();
  if (target.asked == Asked::kPoint) return kept;
  if (target.asked == Asked::kApproach) {
    if (task == TaskSpace::kPoint) return kept;
    const Rotation R = turned_to(space_.pose(last, from.X_BT.R).R, target.X_BT.R.z);
    TaskPoint point = space_.point({R, target.X_BT.p});
    if (task != TaskSpace::kPitchRoll) return point;
    // The pitch as asked for, if it is one, and the roll as it is.
    point.attitude[1] = last.attitude[1];
    const PoseBT X_BT = space_.pose(point);
    const double off = norm(cross(X_BT.R.z, target.X_BT.R.z));
    if (off <= kTaskTolerance) return point;
    const Error error{ErrorCode::kApproachOutOfPlane, -1, off, kTaskTolerance};
    return std::unexpected(MoveFault{error, NearestPose{X_BT, point, error}});
  }
  const auto point = space_.asked(target.X_BT, std::span(from.q.data(), space_.size()));
  if (point) return *point;
  return std::unexpected(MoveFault{point.error().error, point.error()});
}

std::optional<TaskPoint> MoveWay::end_of(const Move& move, const RobotPlace& from) const {
  const ToolTarget* target = nullptr;
  if (const auto* to = std::get_if<MoveTo>(&move.way)) target = &to->to;
  if (const auto* line = std::get_if<MoveL>(&move.way)) target = &line->to;
  if (const auto* arc = std::get_if<MoveC>(&move.way)) target = &arc->to;
  if (const auto* spline = std::get_if<MoveSpline>(&move.way); spline && !spline->through.empty()) {
    target = &spline->through.back();
  }
  if (target == nullptr) return std::nullopt;
  const auto point = resolve(*target, from, space_.point(from.X_BT));
  return point ? std::optional(*point) : std::nullopt;
}

std::optional<MoveFault> MoveWay::make(const Move& move, const RobotPlace& from) {
  if (const auto fault = fault_in(move)) return fault;
  q_from_ = from.q;
  X_from_ = from.X_BT;
  const auto* joints = std::get_if<MoveJ>(&move.way);
  const auto* to = std::get_if<MoveTo>(&move.way);
  joints_ = joints != nullptr || to != nullptr;
  if (joints != nullptr) return make_joints(joints->q, from);
  return to != nullptr ? make_joints_to(to->to, from) : make_tool(move, from);
}

std::optional<MoveFault> MoveWay::make_joints_to(const ToolTarget& target, const RobotPlace& from) {
  const auto point = resolve(target, from, space_.point(from.X_BT));
  if (!point) return point.error();
  const auto branches = space_.branches(*point, from.q);
  if (!branches.empty()) return make_joints(branches[0], from);
  // With its limits aside, so that whoever checks them can say which one is in the way.
  const auto q = space_.inverse_near(*point, from.q);
  if (!q) return MoveFault{q.error(), {}};
  return make_joints(*q, from);
}

/// What a pose that cannot be is told as, where a joint beyond its limit is the reason.
std::optional<Error> MoveWay::limit_broken(const JointArray& q) const {
  for (std::size_t j = 0; j < space_.size(); ++j) {
    if (!within_limits(space_.joints()[j], q[j])) return beyond_limit(space_.joints()[j], j, q[j]);
  }
  return std::nullopt;
}

std::optional<MoveFault> MoveWay::make_joints(const JointArray& q, const RobotPlace& from) {
  q_to_ = {};
  double largest = 0;
  for (std::size_t j = 0; j < space_.size(); ++j) {
    if (!std::isfinite(q[j])) return bad_input(q[j], kFarTurn);
    if (std::abs(q[j]) > kFarTurn) return MoveFault{beyond_limit(space_.joints()[j], j, q[j]), {}};
    q_to_[j] = q[j];
    largest = std::max(largest, std::abs(q_to_[j] - from.q[j]));
  }
  X_end_ = from.X_BT;
  length_ = largest;
  if (largest < kNoTurn) {
    length_ = 0;
    return std::nullopt;
  }
  double way = 0;
  double metres = 0;
  for (int k = 1; k <= kWayParts; ++k) {
    const JointArray q_on_way = joints_at(length_ * k / kWayParts);
    const auto X_BT = space_.forward(std::span(q_on_way.data(), space_.size()), X_end_);
    if (!X_BT) return MoveFault{limit_broken(q_to_).value_or(X_BT.error()), {}};
    metres += norm(X_BT->p - X_end_.p);
    way += std::max(norm(X_BT->p - X_end_.p),
                    kTurnRadius *
                        norm(cross(X_BT->R.x, X_end_.R.x) + cross(X_BT->R.y, X_end_.R.y) +
                             cross(X_BT->R.z, X_end_.R.z)) /
                        2);
    X_end_ = *X_BT;
  }
  length_ = std::max({way, kJointWay * largest, kNoWay});
  constexpr double kSame = 0.999;
  joints_metres_ = metres >= kSame * length_;
  return std::nullopt;
}

std::optional<MoveFault> MoveWay::make_tool(const Move& move, const RobotPlace& from) {
  const TaskPoint begin = space_.point(from.X_BT);
  const auto fault_of = [](const auto& point) { return std::optional<MoveFault>(point.error()); };
  if (const auto* line = std::get_if<MoveL>(&move.way)) {
    const auto to = resolve(line->to, from, begin);
    if (!to) return fault_of(to);
    tool_.make_line(begin, *to);
  } else if (const auto* arc = std::get_if<MoveC>(&move.way)) {
    if (const auto x = far_away(arc->p_via_BT)) return bad_input(*x, kFarAway);
    const auto to = resolve(arc->to, from, begin);
    if (!to) return fault_of(to);
    if (const auto error = tool_.make_arc(begin, arc->p_via_BT, *to)) return MoveFault{*error, {}};
  } else {
    const auto& spline = std::get<MoveSpline>(move.way);
    if (spline.through.empty()) return bad_input();
    if (spline.through.size() > MoveSpline::kPointsMax) {
      return MoveFault{{ErrorCode::kProgramTooLong, -1, static_cast<double>(spline.through.size()),
                        static_cast<double>(MoveSpline::kPointsMax)},
                       {}};
    }
    through_.assign(1, begin);
    for (const ToolTarget& target : spline.through) {
      const auto to = resolve(target, from, through_.back());
      if (!to) return fault_of(to);
      through_.push_back(*to);
    }
    tool_.make_spline(through_);
  }
  length_ = tool_.length();
  return std::nullopt;
}

JointArray MoveWay::joints_at(double s) const {
  if (length_ == 0) return q_from_;
  if (s == length_) return q_to_;
  JointArray q{};
  for (std::size_t j = 0; j < space_.size(); ++j) {
    q[j] = q_from_[j] + s / length_ * (q_to_[j] - q_from_[j]);
  }
  return q;
}

TaskPoint MoveWay::point_at(double s) const {
  if (!joints_) return tool_.at(s);
  const JointArray q = joints_at(s);
  // A hexapod's pose is looked for from the nearer end.
  const PoseBT& X_near = s < length_ / 2 ? X_from_ : X_end_;
  const auto X_BT = space_.forward(std::span(q.data(), space_.size()), X_near);
  return space_.point(X_BT ? *X_BT : X_near);
}

}  // namespace sinew::planning
