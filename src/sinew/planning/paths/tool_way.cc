#include "sinew/planning/paths/tool_way.h"

#include <algorithm>
#include <cmath>

#include "sinew/core/assert.h"
#include "sinew/core/error_code.h"
#include "sinew/planning/paths/moves.h"

namespace sinew::planning {
namespace {

/// A via point this near (m) to the line through start and end makes no arc: its radius would be
/// beyond what the tool's position can tell.
constexpr double kArcOffsetMin = 1e-5;

double inner(const std::array<double, 4>& a, const std::array<double, 4>& b) {
  return a[0] * b[0] + a[1] * b[1] + a[2] * b[2] + a[3] * b[3];
}

/// Any unit vector across v, of the first three rows: half a turn of a direction goes over it.
std::array<double, 4> any_across(const std::array<double, 4>& v) {
  const Vec3 axis{v[0], v[1], v[2]};
  const Vec3 other = std::abs(axis.z) < 0.9 ? Vec3{0, 0, 1} : Vec3{1, 0, 0};
  const Vec3 across = normalized(other - dot(other, axis) * axis);
  return {across.x, across.y, across.z, 0};
}

void normalise(std::array<double, 4>& attitude) {
  const double scale = 1 / std::sqrt(inner(attitude, attitude));
  for (double& value : attitude) value *= scale;
}

}  // namespace

ToolWay::ToolWay(TaskSpace task) : task_(task) {
  constexpr std::size_t kKnots = MoveSpline::kPointsMax + 1;
  knots_.reserve(kKnots);
  rows_.reserve(kKnots);
  curvature_.reserve(kKnots);
  diagonal_.reserve(kKnots);
}

/// @return the turn, rad
double ToolWay::set_turn(const TaskPoint& from, const TaskPoint& to) {
  first_ = from.attitude;
  across_ = {};
  const double angle = turn_between(task_, from, to);
  turn_ = angle;
  if (task_ == TaskSpace::kPoint) return 0;
  if (task_ == TaskSpace::kPitchRoll) {
    for (std::size_t i = 0; i < 2; ++i) across_[i] = wrap_near(to.attitude[i] - first_[i], 0);
    return angle;
  }
  std::array<double, 4> goal = to.attitude;
  if (task_ == TaskSpace::kPose) {
    turn_ = angle / 2;
    if (inner(first_, goal) < 0) {
      for (double& value : goal) value = -value;
    }
  }
  const double along = inner(first_, goal);
  for (std::size_t i = 0; i < 4; ++i) across_[i] = goal[i] - along * first_[i];
  const double size = std::sqrt(inner(across_, across_));
  if (size > 1e-12) {
    for (double& value : across_) value /= size;
  } else {
    across_ = any_across(first_);
  }
  return angle;
}

void ToolWay::attitude_at(double share, std::array<double, 4>& attitude) const {
  if (task_ == TaskSpace::kPoint) return;
  const bool linear = task_ == TaskSpace::kPitchRoll;
  const SinCos turn = linear ? SinCos{share, 1} : sin_cos(share * turn_);
  for (std::size_t i = 0; i < 4; ++i) attitude[i] = turn.cos * first_[i] + turn.sin * across_[i];
}

void ToolWay::make_line(const TaskPoint& from, const TaskPoint& to) {
  kind_ = Kind::kLine;
  p_from_ = from.p_BT;
  p_to_ = to.p_BT;
  const double angle = set_turn(from, to);
  metres_ = norm(p_to_ - p_from_);
  length_ = std::max(metres_, kTurnRadius * angle);
  if (!(length_ >= kNoWay)) length_ = 0;
}

std::optional<Error> ToolWay::make_arc(const TaskPoint& from, const Vec3& p_via_BT,
                                       const TaskPoint& to) {
  make_line(from, to);
  kind_ = Kind::kArc;
  const Vec3 chord = to.p_BT - from.p_BT;
  const Vec3 via = p_via_BT - from.p_BT;
  const Vec3 normal = cross(via, chord);
  const double chord_length = norm(chord);
  const double off = chord_length > kArcOffsetMin ? norm(normal) / chord_length : 0;
  if (!(off >= kArcOffsetMin)) return Error{ErrorCode::kArcCollinear, -1, off, kArcOffsetMin};
  // The circle's centre from its start, from the two chords.
  const double square = dot(normal, normal);
  const Vec3 centre = (1 / (2 * square)) * (dot(via, via) * cross(chord, normal) -
                                            dot(chord, chord) * cross(via, normal));
  p_centre_ = from.p_BT + centre;
  radius_from_ = -centre;
  radius_across_ = cross(normalized(normal), radius_from_);
  const Vec3 end = to.p_BT - p_centre_;
  sweep_ = std::atan2(dot(end, radius_across_), dot(end, radius_from_));
  if (sweep_ <= 0) sweep_ += 2 * kPi;
  metres_ = norm(radius_from_) * sweep_;
  length_ = std::max(metres_, kTurnRadius * turn_between(task_, from, to));
  return std::nullopt;
}

void ToolWay::make_spline(std::span<const TaskPoint> through) {
  SINEW_ASSERT(!through.empty() && through.size() <= MoveSpline::kPointsMax + 1);
  kind_ = Kind::kSpline;
  p_from_ = through.front().p_BT;
  first_ = through.front().attitude;
  knots_.clear();
  rows_.clear();
  metres_ = 0;
  const TaskPoint* last = nullptr;
  for (const TaskPoint& point : through) {
    const auto& a = point.attitude;
    Row row{point.p_BT.x, point.p_BT.y, point.p_BT.z, a[0], a[1], a[2], a[3]};
    if (last != nullptr) {
      const double chord =
          std::max(norm(point.p_BT - last->p_BT), kTurnRadius * turn_between(task_, *last, point));
      if (!(chord >= kNoWay)) continue;
      metres_ += norm(point.p_BT - last->p_BT);
      const Row& before = rows_.back();
      if (task_ == TaskSpace::kPitchRoll) {
        for (std::size_t i = 3; i < 5; ++i) row[i] = wrap_near(row[i], before[i]);
      } else if (task_ == TaskSpace::kPose &&
                 row[3] * before[3] + row[4] * before[4] + row[5] * before[5] + row[6] * before[6] <
                     0) {
        for (std::size_t i = 3; i < kRows; ++i) row[i] = -row[i];
      }
      knots_.push_back(knots_.back() + chord);
    } else {
      knots_.push_back(0);
    }
    rows_.push_back(row);
    last = &point;
  }
  length_ = knots_.back();
  // Natural ends: no second derivative there. Thomas' elimination for all rows at once.
  const std::size_t n = knots_.size();
  curvature_.assign(n, Row{});
  diagonal_.assign(n, 1);
  for (std::size_t i = 1; i + 1 < n; ++i) {
    const double before = knots_[i] - knots_[i - 1];
    const double behind = knots_[i + 1] - knots_[i];
    const double factor = i > 1 ? before / diagonal_[i - 1] : 0;
    diagonal_[i] = 2 * (before + behind) - factor * before;
    for (std::size_t r = 0; r < kRows; ++r) {
      const double slopes =
          (rows_[i + 1][r] - rows_[i][r]) / behind - (rows_[i][r] - rows_[i - 1][r]) / before;
      curvature_[i][r] = 6 * slopes - factor * curvature_[i - 1][r];
    }
  }
  for (std::size_t i = n - 1; i-- > 1;) {
    const double behind = knots_[i + 1] - knots_[i];
    for (std::size_t r = 0; r < kRows; ++r) {
      curvature_[i][r] = (curvature_[i][r] - behind * curvature_[i + 1][r]) / diagonal_[i];
    }
  }
}

TaskPoint ToolWay::spline_at(double s) const {
  const auto after = std::upper_bound(knots_.begin() + 1, knots_.end() - 1, s);
  const auto i = static_cast<std::size_t>(after - knots_.begin()) - 1;
  const double h = knots_[i + 1] - knots_[i];
  const double b = (s - knots_[i]) / h;
  const double a = 1 - b;
  Row row{};
  for (std::size_t r = 0; r < kRows; ++r) {
    row[r] =
        a * rows_[i][r] + b * rows_[i + 1][r] +
        ((a * a * a - a) * curvature_[i][r] + (b * b * b - b) * curvature_[i + 1][r]) * h * h / 6;
  }
  TaskPoint at{{row[0], row[1], row[2]}, {row[3], row[4], row[5], row[6]}};
  if (task_ == TaskSpace::kPose || task_ == TaskSpace::kApproach) normalise(at.attitude);
  return at;
}

TaskPoint ToolWay::at(double s) const {
  if (length_ == 0) return {p_from_, first_};
  if (kind_ == Kind::kSpline) return spline_at(s);
  const double share = s / length_;
  TaskPoint at;
  if (kind_ == Kind::kLine) {
    at.p_BT = (1 - share) * p_from_ + share * p_to_;
  } else {
    const SinCos turned = sin_cos(share * sweep_);
    at.p_BT = p_centre_ + turned.cos * radius_from_ + turned.sin * radius_across_;
  }
  attitude_at(share, at.attitude);
  return at;
}

}  // namespace sinew::planning
