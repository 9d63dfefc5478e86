#include "sinew/devices/grbl/grbl_driver_motion.h"

#include <algorithm>
#include <cmath>

#include "sinew/core/assert.h"
#include "sinew/core/error_code.h"
#include "sinew/core/units.h"
#include "sinew/driver/send_range.h"

namespace sinew {

using namespace grbl;

namespace {

/// Of a joint's speed: pieces that are cut out of a smooth motion swing so much.
constexpr double kSpeedShare = 1.02;

/// Units/s^2.
FixedVector<double, kAxesMax> accelerations(const GrblDevice& device,
                                            std::span<const Joint> joints) {
  FixedVector<double, kAxesMax> all;
  for (std::size_t i = 0; i < joints.size(); ++i) {
    all.push_back(device.to_units(i, joints[i].acceleration_max));
  }
  return all;
}

Error joint_error(ErrorCode code, std::size_t joint, double measured = 0, double limit = 0) {
  return {code, static_cast<std::int8_t>(joint), measured, limit};
}

/// The nearest point of a straight piece.
struct Foot {
  double share = 0;     ///< of the piece
  double distance = 0;  ///< units
  double length = 0;    ///< units, of the piece
};
Foot foot_of(const Values& point, const Values& from, const Values& to) {
  double along = 0, length = 0;
  for (std::size_t i = 0; i < point.size(); ++i) {
    along += (point[i] - from[i]) * (to[i] - from[i]);
    length += (to[i] - from[i]) * (to[i] - from[i]);
  }
  const double share = length > 0 ? std::clamp(along / length, 0.0, 1.0) : 0;
  double sum = 0;
  for (std::size_t i = 0; i < point.size(); ++i) {
    const double off = point[i] - (from[i] + share * (to[i] - from[i]));
    sum += off * off;
  }
  return {share, std::sqrt(sum), std::sqrt(length)};
}

}  // namespace

GrblMotion::GrblMotion(const GrblDevice& device, std::span<const Joint> joints)
    : device_(device), joints_(joints), pace_(accelerations(device, joints)) {
  begin_.resize(joints.size());
  before_ = begin_;
  speed_.resize(joints.size());
}

std::optional<Error> GrblMotion::refusal(std::size_t joint, double from, double to,
                                         Duration duration) const {
  const Joint& own = joints_[joint];
  const SendRange range = SendRange(own).from(from);
  if (!range.holds(to)) {
    const double limit = to < own.lower ? own.lower : own.upper;
    return joint_error(ErrorCode::kJointLimit, joint, to, limit);
  }
  const double needed = std::abs(to - from) / (kSpeedShare * own.velocity_max);
  const double slack = device_.resolution(joint) / own.velocity_max;
  if (to_seconds(duration) + slack >= needed) return std::nullopt;
  return joint_error(ErrorCode::kSegmentTime, joint, to_seconds(duration), needed);
}

void GrblMotion::begin(const Values& counts) {
  pieces_.clear();
  pace_.begin();
  before_ = begin_ = counts;
  carried_ = 0;
  std::ranges::fill(speed_, 0.0);
}

Expected<void> GrblMotion::push(const JointMove& move, const GrblPositions& known, Instant now) {
  SINEW_ASSERT(!full());
  const std::size_t joints = joints_.size();
  if (move.q.size() != joints || move.qd.size() != joints) {
    return std::unexpected(Error{ErrorCode::kUnsendable, -1, static_cast<double>(move.q.size())});
  }
  const double duration = to_seconds(move.duration);
  if (!(duration >= kDurationMin && duration <= kDurationMax)) {
    const double limit = duration < kDurationMin ? kDurationMin : kDurationMax;
    return std::unexpected(Error{ErrorCode::kSegmentTime, -1, duration, limit});
  }
  Piece one;
  one.rest = one.no_way = true;
  Values way;
  double begins = 0, ends = 0;  // units/s over all axes, squared
  for (std::size_t i = 0; i < joints; ++i) {
    const double from = pieces_.empty() ? known.place(i, begin_[i]) : pieces_.back().end[i];
    if (!std::isfinite(move.qd[i]) || !std::isfinite(move.q[i])) {
      return std::unexpected(joint_error(ErrorCode::kUnsendable, i, move.qd[i]));
    }
    if (const auto error = refusal(i, from, move.q[i], move.duration)) {
      return std::unexpected(*error);
    }
    const double count = sayable(i, known.count_of(i, move.q[i]));
    const double here = pieces_.empty() ? begin_[i] : pieces_.back().line.to[i];
    if (std::abs(count) > kValueMax) {
      return std::unexpected(joint_error(ErrorCode::kUnsendable, i, count));
    }
    way.push_back(count - here);
    one.line.to.push_back(count);
    one.no_way = one.no_way && way[i] == 0;
    one.rest = one.rest && move.qd[i] == 0;
    begins += std::pow(device_.to_units(i, speed_[i]), 2);
    ends += std::pow(device_.to_units(i, move.qd[i]), 2);
  }
  one.end = move.q;
  one.line.duration = duration;
  // Too little for the wire: the next line takes that time as well.
  const double total = duration + carried_;
  carried_ = one.no_way && !one.rest ? total : 0;
  if (one.no_way && one.rest) one.time = total;
  if (!one.no_way) {
    const double peak = std::sqrt(std::max(begins, ends));
    const double late = pace_.late();
    one.line.duration = std::max(pace_.line_duration(way, peak, total, one.rest), kDurationMin);
    one.time = std::max(0.0, total + pace_.late() - late);
  }
  if (pieces_.empty()) began_ = now;
  pieces_.push_back(one);
  speed_ = move.qd;
  return {};
}

/// To a whole step, as the board does, and in the decimals of a line.
double GrblMotion::sayable(std::size_t joint, double count) const {
  const double steps = device_.steps_per_unit(joint);
  return std::round(std::round(count * steps) / steps * 1e3) / 1e3;
}

double GrblMotion::tolerance(std::size_t joint) const {
  constexpr double kDigits = 2e-3;
  return 1 / device_.steps_per_unit(joint) + kDigits;
}

bool GrblMotion::on_time(const Values& counts, Instant asked) const {
  constexpr double kDrift = 0.1;  // s since the last status
  if (pieces_.empty()) return true;
  const auto spot = spot_of(counts, asked);
  return spot && std::abs(spot->time - to_seconds(asked - began_)) <= kDrift;
}

bool GrblMotion::is_there(const Values& counts, const Values& target) const {
  for (std::size_t i = 0; i < counts.size(); ++i) {
    if (std::abs(counts[i] - target[i]) > tolerance(i)) return false;
  }
  return true;
}

std::size_t GrblMotion::waiting(Instant now) const {
  double time = to_seconds(now - began_);
  std::size_t over = 0;
  for (const Piece& one : pieces_) {
    time -= one.time;
    if (time < 0 || !one.accepted) break;
    ++over;
  }
  return pieces_.size() - over;
}

Duration GrblMotion::left(Instant now) const {
  double seconds = 0;
  for (const Piece& one : pieces_) seconds += one.time;
  return std::max(Duration::zero(), from_seconds(seconds) - (now - began_));
}

/// Of the pieces that it may be on, the one that is nearest to where its time puts it: a motion may
/// come back along itself.
std::optional<GrblMotion::Spot> GrblMotion::spot_of(const Values& counts, Instant asked) const {
  double slack = 0;
  for (std::size_t i = 0; i < joints_.size(); ++i) slack += tolerance(i) * tolerance(i);
  slack = std::sqrt(slack);
  const double time = to_seconds(asked - began_);
  std::optional<Spot> best;
  double best_off = 0;
  // The last one that was over may not have been.
  if (foot_of(counts, before_, begin_).distance <= slack) best = {0, 0}, best_off = std::abs(time);
  double begins = 0;
  const Values* from = &begin_;
  for (std::size_t k = 0; k < pieces_.size() && pieces_[k].sent; ++k) {
    const Piece& one = pieces_[k];
    const Foot foot = foot_of(counts, *from, one.line.to);
    // Within a step it may be anywhere.
    const double vague = foot.length > slack ? slack / foot.length : 1;
    const double there = std::clamp(time, begins + std::max(0.0, foot.share - vague) * one.time,
                                    begins + std::min(1.0, foot.share + vague) * one.time);
    const double off = std::abs(there - time);
    if (foot.distance <= slack && (!best || off <= best_off)) best = {k, there}, best_off = off;
    begins += one.time;
    from = &one.line.to;
  }
  return best;
}

bool GrblMotion::is_to_move() const {
  return std::ranges::any_of(pieces_, [](const Piece& one) { return one.sent && !one.no_way; });
}

JointInterval GrblMotion::ahead(std::size_t joint, double count) const {
  // By its time it may be on a piece of which it has not come to the begin yet.
  JointInterval reach{std::min(count, begin_[joint]), std::max(count, begin_[joint])};
  for (const Piece& one : pieces_) {
    if (!one.sent) break;
    reach.lower = std::min(reach.lower, one.line.to[joint]);
    reach.upper = std::max(reach.upper, one.line.to[joint]);
  }
  return reach;
}

bool GrblMotion::all_accepted() const {
  return std::ranges::all_of(pieces_, [](const Piece& one) { return one.accepted; });
}

void GrblMotion::drop(std::size_t count) {
  for (std::size_t k = 0; k < count; ++k) {
    const Piece& one = pieces_[0];
    began_ += from_seconds(one.time);
    before_ = begin_;
    begin_ = one.line.to;
    pieces_.drop_front(1);
  }
}

}  // namespace sinew
