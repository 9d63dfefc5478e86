#include "sinew/planning/paths/way_spline.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "sinew/core/assert.h"
#include "sinew/core/error_code.h"
#include "sinew/planning/paths/tool_rate.h"

namespace sinew::planning {
namespace {

/// Between knots at most, m: cubics over longer steps are mostly exact enough, but their third
/// derivative, which becomes jerk, is not.
constexpr double kStepMax = 8e-3;
/// Knots nearer than this (m) do not help: a joint that needs them turns so fast that the tool
/// would creep.
constexpr double kStepMin = 4e-6;
/// The march may miss where it thought to come by this much (rad or m), or it looks closer: a
/// branch that swings past a singularity must not be mistaken for the other one.
constexpr double kSurpriseMax = 0.02;
/// The inverse gives the joints back that it was asked about to this, rad or m.
constexpr double kSameJoints = 1e-6;
/// Joints that move farther between two knots (rad or m) get one between them.
constexpr double kStrideMax = 0.2;
/// The spline keeps to this part of the tolerances at the places where it is looked at.
constexpr double kTightness = 0.5;

double largest_difference(const JointArray& a, const JointArray& b) {
  double largest = 0;
  for (std::size_t j = 0; j < kMaxJoints; ++j) largest = std::max(largest, std::abs(a[j] - b[j]));
  return largest;
}

}  // namespace

WaySpline::WaySpline(const ToolSpace& space, std::size_t capacity)
    : space_(space), capacity_(capacity), spline_(space.size(), capacity) {
  knots_.reserve(capacity);
  points_.reserve(capacity);
  rates_.reserve(capacity);
  off_.reserve(capacity);
  knots_next_.reserve(capacity);
  points_next_.reserve(capacity);
}

WayFault WaySpline::singular_at(const ToolWay& way, double s, const JointArray& q) const {
  const std::span<const double> joints(q.data(), space_.size());
  const auto X_BT = space_.forward(joints, space_.pose(way.at(s)));
  if (!X_BT) return {X_BT.error(), s};
  return {space_.singularity(joints, *X_BT), s};
}

WayFault WaySpline::too_long(double s) const {
  const auto knots = static_cast<double>(capacity_);
  return {{ErrorCode::kProgramTooLong, -1, knots + 1, knots}, s};
}

std::optional<WayFault> WaySpline::place(const ToolWay& way, double s, const JointArray& q_near,
                                         JointArray& q) const {
  const auto found = space_.inverse_near(way.at(s), q_near);
  if (!found) return WayFault{found.error(), s};
  q = *found;
  return std::nullopt;
}

/// dq/ds at s by differences of fourth order to one side.
/// @param reach  m that may be looked at: behind s where > 0, before it where < 0
std::optional<WayFault> WaySpline::end_rate(const ToolWay& way, double s, const JointArray& q,
                                            double reach, JointArray& dq) const {
  constexpr double kStepFirst = 1e-4;
  constexpr int kAttempts = 4;
  double step = std::copysign(std::min(kStepFirst, std::abs(reach) / 8), reach);
  for (int attempt = 0; attempt < kAttempts; ++attempt, step /= 8) {
    std::array<JointArray, 5> f{q};
    for (std::size_t i = 1; i < f.size(); ++i) {
      if (const auto fault = place(way, s + static_cast<double>(i) * step, f[i - 1], f[i])) {
        return fault;
      }
    }
    double doubt = 0;
    for (std::size_t j = 0; j < space_.size(); ++j) {
      dq[j] =
          (-25 * f[0][j] + 48 * f[1][j] - 36 * f[2][j] + 16 * f[3][j] - 3 * f[4][j]) / (12 * step);
      const double coarse = (-3 * f[0][j] + 4 * f[1][j] - f[2][j]) / (2 * step);
      doubt = std::max(doubt, std::abs(coarse - dq[j]) / (1 + std::abs(dq[j])));
    }
    if (doubt < 1e-3) return std::nullopt;
  }
  return singular_at(way, s, q);
}

std::optional<WayFault> WaySpline::march(const ToolWay& way, const JointArray& q_from) {
  begin_ = 0;
  knots_.assign(1, 0);
  points_.assign(1, q_from);
  const double end = way.length();
  SINEW_ASSERT(end > 0);
  // Joints that the inverse does not know (a linkage turned over) have no way to anywhere.
  JointArray q_first{};
  if (const auto fault = place(way, 0, q_from, q_first)) return fault;
  if (largest_difference(q_first, q_from) > kSameJoints) return singular_at(way, 0, q_from);
  JointArray rate{};
  if (const auto fault = end_rate(way, 0, q_from, end, rate)) return fault;
  const double step_max = std::min(kStepMax, end / 4);
  double step = step_max;
  double s = 0;
  while (s < end) {
    if (knots_.size() >= capacity_) return too_long(s);
    // The last two steps share what is left, so that none is a sliver.
    const double left = end - s;
    const double next = left <= step * (1 + 1e-9) ? end : s + (left < 2 * step ? left / 2 : step);
    const JointArray q_last = points_.back();
    JointArray guess{};
    for (std::size_t j = 0; j < space_.size(); ++j) guess[j] = q_last[j] + (next - s) * rate[j];
    JointArray q{};
    const auto fault = place(way, next, guess, q);
    const bool leaps = !fault && largest_difference(q, q_last) > kStrideMax;
    const bool surprised = fault || leaps || largest_difference(q, guess) > kSurpriseMax;
    if (surprised && next - s > kStepMin) {
      step = (next - s) / 2;
      continue;
    }
    if (fault) return fault;
    if (leaps) return singular_at(way, s, q_last);
    for (std::size_t j = 0; j < space_.size(); ++j) rate[j] = (q[j] - q_last[j]) / (next - s);
    knots_.push_back(next);
    points_.push_back(q);
    s = next;
    step = std::min(2 * step, step_max);
  }
  return std::nullopt;
}

std::optional<WayFault> WaySpline::cut(const ToolWay& way, double from, double to) {
  const std::size_t last = knots_.size() - 1;
  SINEW_ASSERT(begin_ == 0 && 0 <= from && from < to && to <= knots_[last]);
  JointArray q_from = points_.front();
  JointArray q_to = points_.back();
  const auto near = [&](double s) {
    const auto above = std::lower_bound(knots_.begin(), knots_.end() - 1, s);
    return points_[static_cast<std::size_t>(above - knots_.begin())];
  };
  if (from > 0) {
    if (const auto fault = place(way, from, near(from), q_from)) return fault;
  }
  if (to < knots_[last]) {
    if (const auto fault = place(way, to, near(to), q_to)) return fault;
  }
  // Of those between only what is not so near to an end that the piece there is a sliver.
  const double sliver = std::min(kStepMax, to - from) / 4;
  std::size_t kept = 1;
  for (std::size_t i = 1; i < knots_.size(); ++i) {
    if (knots_[i] < from + sliver || knots_[i] > to - sliver) continue;
    knots_[kept] = knots_[i] - from;
    points_[kept++] = points_[i];
  }
  // A way has four steps at least, so that there is room for its end.
  knots_.resize(kept + 1);
  points_.resize(kept + 1);
  points_.front() = q_from;
  points_.back() = q_to;
  knots_.back() = to - from;
  begin_ = from;
  if (const auto fault = end_rate(way, from, q_from, to - from, dq_first_)) return fault;
  return end_rate(way, to, q_to, from - to, dq_last_);
}

/// True where piece `i` of the spline keeps to the way; notes what the tool does there.
bool WaySpline::follows(const ToolWay& way, std::size_t i, PoseBT& X_near) {
  constexpr std::size_t kParts = 4;
  const double begin = knots_[i];
  const double h = knots_[i + 1] - begin;
  std::array<Vec3, kParts + 1> p;
  PathPoint at;
  bool good = largest_difference(points_[i], points_[i + 1]) <= kStrideMax;
  for (std::size_t k = 0; k <= kParts; ++k) {
    const double u = h * static_cast<double>(k) / kParts;
    spline_.sample_piece(i, u, at);
    const auto X_BT = space_.forward(std::span<const double>(at.q.data(), space_.size()), X_near);
    if (!X_BT) return false;
    X_near = *X_BT;
    p[k] = X_BT->p;
    if (k == 0 || k == kParts) continue;
    const ToolOffset off = space_.offset(*X_BT, way.at(begin_ + begin + u));
    good = good && off.distance <= kTightness * kPathTolerance &&
           off.angle <= kTightness * kPathTurnTolerance;
  }
  rates_.push_back(tool_rate(p, h / kParts));
  return good;
}

std::optional<WayFault> WaySpline::fit(const ToolWay& way) {
  // Each round halves every piece that is off, down to kStepMin: so many rounds are enough.
  constexpr int kRounds = 24;
  PoseBT X_first = space_.pose(way.at(begin_));
  for (int round = 0; round < kRounds; ++round) {
    spline_.clear();
    if (!append_to(spline_)) break;
    rates_.clear();
    off_.clear();
    bool all = true;
    PoseBT X_near = X_first;
    for (std::size_t i = 0; i < spline_.size(); ++i) {
      const bool good = follows(way, i, X_near);
      if (rates_.size() <= i) rates_.push_back({});
      off_.push_back(good ? 0 : 1);
      all = all && good;
    }
    if (all) return std::nullopt;
    if (const auto fault = split(way)) return fault;
  }
  return too_long(begin_);
}

std::optional<WayFault> WaySpline::split(const ToolWay& way) {
  knots_next_.clear();
  points_next_.clear();
  for (std::size_t i = 0; i < knots_.size(); ++i) {
    if (knots_next_.size() + 2 > capacity_) {
      return too_long(begin_ + knots_[i]);
    }
    knots_next_.push_back(knots_[i]);
    points_next_.push_back(points_[i]);
    if (i + 1 == knots_.size() || off_[i] == 0) continue;
    const double h = knots_[i + 1] - knots_[i];
    if (h < 2 * kStepMin) return singular_at(way, begin_ + knots_[i], points_[i]);
    const double middle = knots_[i] + h / 2;
    JointArray q_near{};
    for (std::size_t j = 0; j < kMaxJoints; ++j) {
      q_near[j] = (points_[i][j] + points_[i + 1][j]) / 2;
    }
    JointArray q{};
    if (const auto fault = place(way, begin_ + middle, q_near, q)) return fault;
    knots_next_.push_back(middle);
    points_next_.push_back(q);
  }
  knots_.swap(knots_next_);
  points_.swap(points_next_);
  return std::nullopt;
}

}  // namespace sinew::planning
