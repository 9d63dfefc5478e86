#include "sinew/control/sent_way.h"

#include <algorithm>
#include <cmath>

#include "sinew/core/assert.h"
#include "sinew/core/cubic.h"

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

/// The fastest that a joint becomes behind v >= 0: one that still speeds up goes on with that until
/// its jerk has ended it.
double fastest_behind(const motion::AxisLimits& limit, double v, bool braking) {
  return v == 0 || braking ? v : v + limit.acceleration * limit.acceleration / limit.jerk / 2;
}

double time_to_rest(const motion::AxisLimits& limit, double v) {
  return v == 0 ? 0 : v / limit.acceleration + limit.acceleration / limit.jerk;
}

/// How far a joint may go on from its speed v >= 0 until it rests, rad or m.
///
/// The way to rest of a joint without acceleration is v/2 (v/a + a/j) at most. One that still
/// speeds up with a goes on for a/j until it does not any more, and is then faster by a^2/2j. A
/// joint that brakes by its limits needs at v' no more than its rest was ahead, and v' a/2j; the
/// second bound has room for that, so a stop needs nothing that was not reserved before.
/// @param least  s that it takes at least, once it brakes
double braking_way(const motion::AxisLimits& limit, double v, bool braking, double least) {
  const double rise = limit.acceleration / limit.jerk;  // s
  const double fastest = fastest_behind(limit, v, braking);
  const double before = v == 0 || braking ? 0 : 1.5 * fastest * rise;
  return before + fastest / 2 * std::max(time_to_rest(limit, fastest), least);
}

}  // namespace

SentWay::SentWay(std::span<const motion::AxisLimits> limits, bool together)
    : limits_(limits), together_(together) {
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

/// s that each joint takes at least to come to rest.
double SentWay::braking_time(std::span<const double> qd, bool braking) const {
  double longest = 0;
  for (std::size_t j = 0; together_ && j < qd.size(); ++j) {
    const double fastest = fastest_behind(limits_[j], std::abs(qd[j]), braking);
    longest = std::max(longest, time_to_rest(limits_[j], fastest));
  }
  return longest;
}

/// A cubic between its ends, and behind it the way to rest.
SentWay::Intervals SentWay::way_of(const JointMove& piece, bool braking) const {
  Intervals way;
  const double seconds = to_seconds(piece.duration);
  JointVector peaks;
  peaks.resize(limits_.size());
  for (std::size_t j = 0; together_ && j < limits_.size(); ++j) {
    const double qd = piece.qd.empty() ? 0 : piece.qd[j];
    peaks[j] = Cubic({q_[j], qd_[j]}, {piece.q[j], qd}, seconds).peak_speed();
  }
  const double least = braking_time({peaks.data(), peaks.size()}, braking);
  for (std::size_t j = 0; j < limits_.size(); ++j) {
    const double qd = piece.qd.empty() ? 0 : piece.qd[j];
    const double bulge = beyond_ends(piece.q[j] - q_[j], qd_[j], qd, seconds);
    const double ahead = std::copysign(braking_way(limits_[j], std::abs(qd), braking, least), qd);
    JointInterval own{std::min(q_[j], piece.q[j]) - bulge, std::max(q_[j], piece.q[j]) + bulge};
    widen(own, {piece.q[j] + ahead, piece.q[j] + ahead});
    // A stop inside the piece takes a joint along that rests at its end.
    if (piece.q[j] > q_[j]) own.upper = std::max(own.upper, piece.q[j] + peaks[j] * least / 2);
    if (piece.q[j] < q_[j]) own.lower = std::min(own.lower, piece.q[j] - peaks[j] * least / 2);
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
