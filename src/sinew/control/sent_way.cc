#include "sinew/control/sent_way.h"

#include <algorithm>
#include <cmath>

#include "sinew/core/assert.h"

namespace sinew::control {
namespace {

void widen(JointInterval& interval, const JointInterval& by) {
  interval.lower = std::min(interval.lower, by.lower);
  interval.upper = std::max(interval.upper, by.upper);
}

/// How far a cubic may leave what lies between its ends: not at all where it goes one way only.
double beyond_ends(double way, double qd0, double qd1, double seconds) {
  const double steepest = 3 * std::abs(way) / seconds;
  const auto along = [&](double qd) { return qd * way >= 0 && std::abs(qd) <= steepest; };
  return along(qd0) && along(qd1) ? 0 : std::max(std::abs(qd0), std::abs(qd1)) * seconds / 4;
}

}  // namespace

SentWay::SentWay(std::span<const motion::AxisLimits> limits) : limits_(limits) {
  q_.resize(limits.size());
  qd_.resize(limits.size());
}

void SentWay::rest(std::span<const double> q) {
  q_ = JointVector(q);
  qd_.clear();
  qd_.resize(q.size());
  pieces_.clear();
  merged_ = 0;
}

/// The way to rest of a joint without acceleration is v/2 (v/a + a/j) at most. One that still
/// speeds up with a goes on for a/j until it does not any more, and is then faster by a^2/2j. A
/// joint that brakes by its limits needs at v' no more than its rest was ahead, and v' a/2j; the
/// second bound has room for that, so a stop needs nothing that was not reserved before.
double SentWay::braking_way(const motion::AxisLimits& limit, double v, bool braking) {
  const double rise = limit.acceleration / limit.jerk;  // s
  const auto from = [&](double speed) { return speed / 2 * (speed / limit.acceleration + rise); };
  if (v == 0 || braking) return from(v);
  const double fastest = v + limit.acceleration * rise / 2;
  return 1.5 * fastest * rise + from(fastest);
}

/// A cubic between its ends, and behind it the way to rest.
SentWay::Intervals SentWay::way_of(const JointMove& piece, bool braking) const {
  Intervals way;
  const double seconds = to_seconds(piece.duration);
  for (std::size_t j = 0; j < limits_.size(); ++j) {
    const double qd = piece.qd.empty() ? 0 : piece.qd[j];
    const double bulge = beyond_ends(piece.q[j] - q_[j], qd_[j], qd, seconds);
    const double ahead = std::copysign(braking_way(limits_[j], std::abs(qd), braking), qd);
    JointInterval own{std::min(q_[j], piece.q[j]) - bulge, std::max(q_[j], piece.q[j]) + bulge};
    widen(own, {piece.q[j] + ahead, piece.q[j] + ahead});
    way.push_back(own);
  }
  return way;
}

void SentWay::sent(const JointMove& piece, bool braking) {
  const Intervals way = way_of(piece, braking);
  if (pieces_.full() || merged_ > 0) {
    for (std::size_t j = 0; j < way.size(); ++j) widen(pieces_.back()[j], way[j]);
    ++merged_;
  } else {
    pieces_.push_back(way);
  }
  q_ = piece.q;
  qd_ = piece.qd;
  qd_.resize(q_.size());
}

void SentWay::ended() {
  if (pieces_.empty()) return;
  if (pieces_.size() == 1 && merged_ > 0) {
    --merged_;
    return;
  }
  pieces_.drop_front(1);
}

std::span<const JointInterval> SentWay::with(std::span<const JointPosition> now,
                                             const JointMove& next, bool braking) {
  SINEW_ASSERT(now.size() == limits_.size() && next.q.size() == limits_.size());
  reach_ = way_of(next, braking);
  for (std::size_t j = 0; j < reach_.size(); ++j) {
    for (const Intervals& piece : pieces_) widen(reach_[j], piece[j]);
    if (now[j].quality == PositionQuality::kLost) continue;
    // What is open about where it stands goes along with it; what is measured is measured anew.
    if (now[j].quality != PositionQuality::kMeasured && !now[j].under_way) {
      reach_[j].lower += std::min(0.0, now[j].lower - now[j].q);
      reach_[j].upper += std::max(0.0, now[j].upper - now[j].q);
    }
    widen(reach_[j], {now[j].lower, now[j].upper});
  }
  return {reach_.data(), reach_.size()};
}

}  // namespace sinew::control
