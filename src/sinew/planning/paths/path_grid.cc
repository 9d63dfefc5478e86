#include "sinew/planning/paths/path_grid.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "sinew/core/assert.h"

namespace sinew::planning {
namespace {

// How much of a limit the speed alone may take on a bend; the rest is left for changing it.
constexpr double kBendShare = 0.75;  // of an acceleration, for q'' v^2
constexpr double kTwistShare = 0.4;  // of a jerk, for q''' v^3
constexpr double kCrossShare = 0.5;  // of what is left of a jerk, for 3 q'' v a
constexpr double kLittle = 0.1;
constexpr double kSame = 1e-9;
constexpr double kSpeedReserve = 1.5;   // how much quicker a refined cell may become
constexpr std::size_t kSplitsMax = 5;   // halvings of a piece
constexpr double kSplitGain = 1.25;     // a half that may be so much quicker is worth a cell
constexpr double kCurvedCellsMin = 64;  // over a whole path
// Where nothing moves, s still needs some end to its speed; per s, s^2, s^3.
constexpr double kFastest = 1e4;
constexpr double kFastestAcceleration = 1e7;
constexpr double kFastestJerk = 1e10;

}  // namespace

/// Upper bounds within one cell, as shares of the limits per v, v^2 (or a), v^3 (or v a, or u).
struct PathGrid::Bounds {
  JointArray v1, a1, a2, j1, j2, j3;
  double shared = 0;  ///< of what all joints share, per v
  double tool1 = 0, tool2 = 0;
};

PathGrid::PathGrid(std::size_t capacity) {
  cells_.reserve(capacity);
}

void PathGrid::bound(const PathCell& cell, double end, Bounds& out) const {
  const std::size_t i = cell.piece;
  const double from = path_->joints.begin(i);
  PathPoint d;
  path_->joints.bound_piece(i, cell.begin - from, end - from, d);
  out.shared = 0;
  for (std::size_t j = 0; j < kMaxJoints; ++j) {
    out.shared += d.dq[j] * per_shared_;
    out.v1[j] = d.dq[j] * per_velocity_[j];
    out.a1[j] = d.dq[j] * per_acceleration_[j];
    out.a2[j] = d.ddq[j] * per_acceleration_[j];
    out.j1[j] = d.dq[j] * per_jerk_[j];
    out.j2[j] = d.ddq[j] * per_jerk_[j];
    out.j3[j] = d.dddq[j] * per_jerk_[j];
  }
  const double per_tool = 1 / path_->sections[cell.section].tool_acceleration;
  out.tool1 = path_->tool[i].speed * per_tool;
  out.tool2 = path_->tool[i].curvature * per_tool;
}

void PathGrid::box(const Bounds& bounds, PathCell& cell) const {
  const auto largest = [](const JointArray& values) {
    return static_cast<std::size_t>(std::max_element(values.begin(), values.end()) -
                                    values.begin());
  };
  const std::size_t quick = largest(bounds.v1);
  cell.velocity_joint = static_cast<std::int8_t>(quick);
  cell.v_joints = std::min(kFastest, 1 / bounds.v1[quick]);
  // One joint alone may have the wire's whole speed as its own limit.
  if (bounds.shared * (1 + kSame) >= bounds.v1[quick]) {
    cell.velocity_joint = -1;
    cell.v_joints = std::min(cell.v_joints, 1 / bounds.shared);
  }
  const PathSection& section = path_->sections[cell.section];
  const double speed = path_->tool[cell.piece].speed;
  cell.v_tool = speed > 0 ? section.tool_speed / speed : kFastest;
  cell.share = section.joint_share;

  const std::size_t bend = largest(bounds.a2);
  const std::size_t twist = largest(bounds.j3);
  const double by_bend = std::sqrt(kBendShare / bounds.a2[bend]);
  const double by_twist = std::cbrt(kTwistShare / bounds.j3[twist]);
  const double by_tool = std::sqrt(kBendShare / bounds.tool2);
  cell.v_shape = std::min({kFastest, by_bend, by_twist, by_tool});
  cell.shape = {LimitKind::kToolAcceleration, -1};
  if (by_bend <= cell.v_shape) {
    cell.shape = {LimitKind::kJointAcceleration, static_cast<std::int8_t>(bend)};
  }
  if (by_twist <= cell.v_shape) {
    cell.shape = {LimitKind::kJointJerk, static_cast<std::int8_t>(twist)};
  }
  share_out(bounds, cell);
}

void PathGrid::share_out(const Bounds& bounds, PathCell& cell) const {
  const double v = std::min({cell.v_joints, cell.v_shape});
  double a = kFastestAcceleration;
  cell.acceleration = {LimitKind::kJointAcceleration, -1};
  for (std::size_t j = 0; j < kMaxJoints; ++j) {
    const double left = 1 - bounds.a2[j] * v * v;
    if (left < a * bounds.a1[j]) {
      a = left / bounds.a1[j];
      cell.acceleration = {LimitKind::kJointAcceleration, static_cast<std::int8_t>(j)};
    }
    const double jerk_left = kCrossShare * (1 - bounds.j3[j] * v * v * v);
    if (jerk_left < a * 3 * v * bounds.j2[j]) {
      a = jerk_left / (3 * v * bounds.j2[j]);
      cell.acceleration = {LimitKind::kJointJerk, static_cast<std::int8_t>(j)};
    }
  }
  const double tool_left = 1 - bounds.tool2 * v * v;
  if (tool_left < a * bounds.tool1) {
    a = tool_left / bounds.tool1;
    cell.acceleration = {LimitKind::kToolAcceleration, -1};
  }
  double u = kFastestJerk;
  for (std::size_t j = 0; j < kMaxJoints; ++j) {
    const double left = 1 - bounds.j3[j] * v * v * v - 3 * bounds.j2[j] * v * a;
    if (left < u * bounds.j1[j]) {
      u = left / bounds.j1[j];
      cell.jerk_joint = static_cast<std::int8_t>(j);
    }
  }
  cell.a = a;
  cell.u = u;
}

void PathGrid::append(PathCell cell, double end, std::size_t depth, std::size_t spare) {
  Bounds bounds;
  bound(cell, end, bounds);
  box(bounds, cell);
  double sum = 0;
  for (std::size_t j = 0; j < kMaxJoints; ++j) sum += bounds.v1[j] + bounds.a2[j] + bounds.j3[j];
  if (!std::isfinite(sum)) cell.v_shape = std::numeric_limits<double>::quiet_NaN();
  const double middle = cell.begin + (end - cell.begin) / 2;
  const std::size_t room = cells_.capacity() - cells_.size();
  const bool can_split =
      depth < kSplitsMax && room > spare + kSplitsMax + 1 && middle > cell.begin && middle < end;
  const bool curved = cell.v_shape < kFastest;
  if (can_split && curved) {
    PathCell halves[2] = {cell, cell};
    halves[1].begin = middle;
    bool worth = end - cell.begin > cell_length_max_;
    for (PathCell& half : halves) {
      bound(half, &half == halves ? middle : end, bounds);
      box(bounds, half);
      const auto gains = [&](double whole, double part) { return part > kSplitGain * whole; };
      const double v = std::min(cell.v_joints, cell.v_shape);
      worth = worth || gains(v, std::min(half.v_joints, half.v_shape)) || gains(cell.a, half.a) ||
              gains(cell.u, half.u);
    }
    if (worth) {
      append(halves[0], middle, depth + 1, spare + 1);
      append(halves[1], end, depth + 1, spare);
      return;
    }
  }
  curved_ = curved_ || curved;
  if (!cells_.empty()) {
    // Equal but for rounding: one number, so that what it bounds stays one phase.
    const PathCell& last = cells_.back();
    for (double PathCell::* number :
         {&PathCell::v_joints, &PathCell::v_tool, &PathCell::v_shape, &PathCell::a, &PathCell::u}) {
      if (std::abs(cell.*number - last.*number) < 1e-12 * last.*number) cell.*number = last.*number;
    }
  }
  cells_.push_back(cell);
}

bool PathGrid::build(const PlannedPath& path, std::span<const motion::AxisLimits> limits,
                     double shared_velocity) {
  path_ = &path;
  cells_.clear();
  curved_ = false;
  length_ = path.joints.length();
  cell_length_max_ = length_ / kCurvedCellsMin;
  per_velocity_ = per_acceleration_ = per_jerk_ = {};
  per_shared_ = 1 / shared_velocity;
  for (std::size_t j = 0; j < limits.size(); ++j) {
    per_velocity_[j] = 1 / limits[j].velocity;
    per_acceleration_[j] = 1 / limits[j].acceleration;
    per_jerk_[j] = 1 / limits[j].jerk;
  }
  const std::size_t pieces = path.joints.size();
  const std::size_t least = pieces + path.sections.size();
  if (least > capacity()) return false;
  std::size_t section = 0;
  for (std::size_t i = 0; i < pieces; ++i) {
    double from = path.joints.begin(i);
    const double end = path.joints.begin(i + 1);
    while (from < end) {
      while (section + 1 < path.sections.size() && path.sections[section + 1].begin <= from) {
        ++section;
      }
      const bool cut = section + 1 < path.sections.size() && path.sections[section + 1].begin < end;
      const double to = cut ? path.sections[section + 1].begin : end;
      PathCell cell;
      cell.begin = from;
      cell.piece = static_cast<std::uint32_t>(i);
      cell.section = static_cast<std::uint32_t>(section);
      append(cell, to, 0, least - i - section);
      from = to;
    }
  }
  set_feed(1);
  return true;
}

void PathGrid::refine(std::span<const double> speeds) {
  SINEW_ASSERT(speeds.size() == size());
  Bounds bounds;
  for (std::size_t i = 0; i < size(); ++i) {
    PathCell& cell = cells_[i];
    // Nothing to gain where the path is straight in joint space.
    if (cell.v_shape >= kFastest) continue;
    bound(cell, begin(i + 1), bounds);
    const double bend = *std::max_element(bounds.a2.begin(), bounds.a2.end());
    const double twist = *std::max_element(bounds.j3.begin(), bounds.j3.end());
    // So slow that it costs little is never forbidden.
    const double slow = std::min(std::sqrt(kLittle / bend), std::cbrt(kLittle / twist));
    const double v = std::max(kSpeedReserve * speeds[i], slow);
    if (v >= std::min(cell.v_joints, cell.v_shape)) continue;
    cell.v_shape = v;
    share_out(bounds, cell);
  }
  set_feed(feed_);
}

void PathGrid::set_feed(double feed) {
  feed_ = feed;
  for (std::size_t i = 0; i < size(); ++i) cells_[i].v = speed_at(i, feed);
}

double PathGrid::speed_at(std::size_t i, double feed) const {
  const PathCell& cell = cells_[i];
  return std::min({cell.v_joints * std::min(1.0, cell.share * feed), cell.v_tool * feed,
                   cell.v_shape, kFastest});
}

std::size_t PathGrid::cell_at(double s) const {
  const auto after =
      std::upper_bound(cells_.begin(), cells_.end(), s,
                       [](double at, const PathCell& cell) { return at < cell.begin; });
  return after == cells_.begin() ? 0 : static_cast<std::size_t>(after - cells_.begin()) - 1;
}

PathLimit PathGrid::speed_limit(std::size_t i) const {
  const PathCell& cell = cells_[i];
  if (cell.v >= cell.v_shape) return cell.shape;
  const double share = cell.share * feed_;
  const PathLimit joints{cell.velocity_joint < 0 ? LimitKind::kWire : LimitKind::kJointVelocity,
                         cell.velocity_joint};
  if (cell.v >= cell.v_joints) return joints;
  if (feed_ < 1) return {LimitKind::kFeed, -1};
  if (cell.v >= cell.v_joints * share) return joints;
  return {LimitKind::kToolSpeed, -1};
}

}  // namespace sinew::planning
