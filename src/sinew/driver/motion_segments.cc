#include "sinew/driver/motion_segments.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "sinew/core/assert.h"
#include "sinew/core/error_code.h"

namespace sinew::segments {
namespace {

/// Pieces that are cut out of a smooth motion swing out by rounding and by the fourth power of
/// their duration; so much (rad) is held back at the limit, more is refused.
constexpr double kSwing = 1e-4;
/// Likewise of the peak speed.
constexpr double kSpeedTolerance = 1.01;
/// s. Shorter than any cycle of the link: there would be no setpoint inside.
constexpr double kShortest = 1e-4;
/// s. An hour; longer is a mistake of units.
constexpr double kLongest = 3600;

/// An encoder's count beyond a limit is on it: an axis that was sent to its limit may read so, and
/// holds its host to the limit itself.
double on_limit(const Joint& joint, double q) {
  const double inside = std::clamp(q, joint.lower, joint.upper);
  return std::abs(q - inside) <= kSwing ? inside : q;
}

}  // namespace

CubicPiece::CubicPiece(const Setpoint& from, const Setpoint& to, double duration,
                       const SendRange& range)
    : cubic_(from, to, duration), range_(range) {
  SINEW_ASSERT(duration > 0);
}

Setpoint CubicPiece::at(double t) const {
  const Setpoint there = cubic_.at(t);
  if (t >= cubic_.duration()) return there;
  return {std::clamp(there.q, range_.lower, range_.upper), there.qd};
}

Expected<void> CubicPiece::check(const Joint& joint) const {
  const double peak = cubic_.peak_speed();
  if (!(peak <= joint.velocity_max * kSpeedTolerance)) {
    const double time = cubic_.duration();
    return std::unexpected(
        Error{ErrorCode::kSegmentTime, -1, time, time * peak / joint.velocity_max});
  }
  std::optional<Error> out;
  cubic_.for_turns([&](double q) {
    if (out || (q >= range_.lower - kSwing && q <= range_.upper + kSwing)) return;
    out = Error{ErrorCode::kJointLimit, -1, q, q < joint.lower ? joint.lower : joint.upper};
  });
  if (out) return std::unexpected(*out);
  return {};
}

Expected<void> SegmentQueue::push(const JointMove& move, std::span<const Joint> joints,
                                  std::span<const Setpoint> start, Instant now) {
  SINEW_ASSERT(!full() && start.size() == joints.size());
  if (move.q.size() != joints.size() || move.qd.size() != joints.size()) {
    return std::unexpected(Error{ErrorCode::kUnsendable, -1, static_cast<double>(move.q.size())});
  }
  const double duration = to_seconds(move.duration);
  if (duration < kShortest || duration > kLongest) {
    const double limit = duration < kShortest ? kShortest : kLongest;
    return std::unexpected(Error{ErrorCode::kSegmentTime, -1, duration, limit});
  }
  Segment segment{
      .pieces = {}, .start = empty() ? now : back().end, .end = {}, .ends_at_rest = true};
  segment.end = segment.start + move.duration;
  for (std::size_t i = 0; i < joints.size(); ++i) {
    const auto refuse = [&](Error error) {
      error.index = static_cast<std::int8_t>(i);
      return std::unexpected(error);
    };
    const double q = on_limit(joints[i], move.q[i]);
    Setpoint from = empty() ? start[i] : back().pieces[i].end();
    from.q = on_limit(joints[i], from.q);
    const SendRange range = SendRange(joints[i]).from(from.q);
    if (!range.holds(q)) {
      const double limit = q < joints[i].lower ? joints[i].lower : joints[i].upper;
      return refuse({ErrorCode::kJointLimit, -1, q, limit});
    }
    if (!std::isfinite(move.qd[i])) return refuse({ErrorCode::kUnsendable, -1, move.qd[i]});
    const CubicPiece piece(from, {q, move.qd[i]}, duration, range);
    const auto checked = piece.check(joints[i]);
    if (!checked) return refuse(checked.error());
    segment.ends_at_rest = segment.ends_at_rest && move.qd[i] == 0;
    segment.pieces.push_back(piece);
  }
  segments_.push_back(segment);
  return {};
}

void SegmentQueue::pop_front() {
  SINEW_ASSERT(!empty());
  segments_.drop_front(1);
}

Setpoint SegmentQueue::at(std::size_t joint, Instant when) const {
  SINEW_ASSERT(!empty());
  for (const Segment& segment : segments_) {
    if (when >= segment.end) continue;
    return segment.pieces[joint].at(std::max(0.0, to_seconds(when - segment.start)));
  }
  return back().pieces[joint].end();
}

}  // namespace sinew::segments
