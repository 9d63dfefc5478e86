// What the driver makes of a status, by what it is about.

#include <algorithm>
#include <cmath>

#include "sinew/core/assert.h"
#include "sinew/devices/grbl/grbl_driver.h"

namespace sinew {

using namespace grbl;
using Kind = DriverEvent::Kind;

namespace {

/// The nearest point of a straight piece.
struct Foot {
  double share = 0;     ///< of the piece
  double distance = 0;  ///< deg
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
  return {share, std::sqrt(sum)};
}

bool stands(const Status& status) {
  const bool held = status.state == State::kHold && status.detail == 0;
  return held || status.state == State::kIdle || status.state == State::kAlarm ||
         status.state == State::kSleep || status.state == State::kCheck ||
         status.state == State::kTool || status.state == State::kDoor;
}

/// What an alarm means to this program; docs/wires/grbl.md. @param joint  -1: not known
Error error_of(std::uint16_t alarm, std::int8_t joint) {
  switch (alarm) {
    case 1:
    case 12:
      return {ErrorCode::kEndStop, joint};
    case 3:
      return {ErrorCode::kDeviceRestarted};
    case 6:
    case 7:
    case 8:
    case 9:
      return {ErrorCode::kHomingFailed, joint};
    case 10:
      return {ErrorCode::kEmergencyStop, joint};
    case 11:
      return {ErrorCode::kNotHomed, joint};
    case 17:
      return {ErrorCode::kStalled, joint};
    default:
      return {ErrorCode::kDeviceRefused};
  }
}

/// Its counts still belong to the joints.
bool keeps_position(std::uint16_t alarm) {
  return alarm == 2 || alarm == 4 || alarm == 5;
}

}  // namespace

void GrblDriver::take_status(const Status& status, Instant now) {
  const Instant asked = asked_at_.value_or(now);
  asked_at_.reset();
  unheard_ = 0;
  told_silent_ = false;
  poll_due_ = now + (activity_ == Activity::kIdle ? timing_.resting_poll : timing_.arrival_poll);
  Values counts = status.position;
  if (status.offset) offset_ = *status.offset;
  for (std::size_t i = 0; status.work && i < std::min(counts.size(), offset_.size()); ++i) {
    counts[i] += offset_[i];
  }
  const bool readable = counts.size() >= joints_.size() && (!status.work || !offset_.empty());
  if (!readable) {
    ++health_.unexpected;
    return;
  }
  counts.resize(joints_.size());
  // While it brakes they count for nothing: what was known of it holds for as far as it can have
  // gone.
  const bool looks =
      step_ == Step::kLook && (activity_ == Activity::kOpening || activity_ == Activity::kStopping);
  if (!looks && !believable(counts, asked)) {
    poll_due_ = now;
    return;
  }
  const bool moved = !is_there(counts, known_.counts());
  if (moved) changed_ = std::max(changed_, now);
  if (!looks) {
    known_.count(counts);
    counted_at_ = asked;
  }
  switch (activity_) {
    case Activity::kOpening:
    case Activity::kStopping:
      return step_ == Step::kPlace ? step_place(status, now) : step_look(status, now);
    case Activity::kMoving:
      return step_moving(status, now);
    case Activity::kNudging:
      return step_nudging(status, now);
    case Activity::kHoming:
      if (!lines_.empty()) return;
      known_.homed();
      return step_place(status, now);
    case Activity::kAlarm:
      return step_alarm(status);
    case Activity::kIdle:
      // Nobody of us has moved it.
      if (status.state == State::kAlarm && !fault_) take_alarm(status.detail, now);
      if (moved && known_.unknown() == std::nullopt)
        tell(Kind::kNotice, {ErrorCode::kForeignMotion});
      return;
    default:
      return;
  }
}

/// No line has a checksum: where it seems to have jumped, or where all rests on it, a second status
/// has to say the same.
bool GrblDriver::believable(const Values& counts, Instant asked) {
  const bool steps = activity_ == Activity::kOpening || activity_ == Activity::kStopping;
  const bool placing = (steps || activity_ == Activity::kHoming) && step_ == Step::kPlace;
  const bool rests = placing || activity_ == Activity::kIdle;
  const auto near = [&](const Values& before, Instant at) {
    const double time = std::max(0.0, to_seconds(asked - at + 2 * line_time_));
    for (std::size_t i = 0; i < counts.size(); ++i) {
      const double gone = rests ? 0 : time * to_deg(joints_[i].velocity_max);
      if (std::abs(counts[i] - before[i]) > gone + tolerance(i)) return false;
    }
    return true;
  };
  const bool twice = suspect_ && near(suspect_->counts, suspect_->asked);
  const bool good =
      twice || (!placing && near(known_.counts(), counted_at_) && on_time(counts, asked));
  if (good) {
    suspect_.reset();
  } else {
    if (!placing) ++health_.unexpected;
    suspect_ = {counts, asked};
  }
  return good;
}

/// In a motion: where it is sent, when it is.
bool GrblDriver::on_time(const Values& counts, Instant asked) const {
  constexpr double kDrift = 0.1;  // s since the last status
  if (activity_ != Activity::kMoving || pending_.empty()) return true;
  const auto spot = spot_of(counts, asked);
  return spot && std::abs(spot->time - to_seconds(asked - began_)) <= kDrift;
}

void GrblDriver::step_look(const Status& status, Instant now) {
  if (step_ != Step::kLook) return;
  if (stands(status)) {
    if (activity_ == Activity::kOpening && looks_for_mark()) return;
    step_ = Step::kReset;
    return reset_board(now);
  }
  // Somebody else's motion, or the rest of one of an earlier host.
  if (status.state == State::kRun) say_now(RealTime::kHold);
  if (status.state == State::kJog) say_now(RealTime::kJogCancel);
}

/// Whether another status is needed to see its mark, which a reset takes away: GRBL says the offset
/// of its work coordinates in each tenth or thirtieth of them.
bool GrblDriver::looks_for_mark() {
  constexpr int kLooksMax = 32;
  constexpr double kDigit = 1e-3;
  if (offset_.empty()) return joints_.size() > 2 && ++looks_ < kLooksMax;
  if (offset_.size() > 2 && std::abs(offset_[2] - kMark) < kDigit / 2) known_.marked();
  return false;
}

/// Leaves the mark, where that has not been tried yet.
bool GrblDriver::mark(Instant now) {
  if (marked_ || joints_.size() < 3 || offset_.size() < 3) return false;
  marked_ = true;
  step_ = Step::kLines;
  lines_since_ = now;
  const double z = kMark - offset_[2];
  return std::abs(z) <= kValueMax && say(ToolOffset{z}, Sent::kOther);
}

/// The board has answered to all lines that a reset was followed by.
void GrblDriver::take_lines(Instant now) {
  step_ = Step::kPlace;
  poll_due_ = now;
}

void GrblDriver::step_place(const Status& status, Instant now) {
  if (status.state == State::kAlarm) {
    // What it counts was cut off, or it never knew.
    known_.restart();
    if (!unlocked_) {
      unlocked_ = true;
      step_ = Step::kLines;
      lines_since_ = now;
      say(Unlock{}, Sent::kOther);
      return;
    }
    // grblHAL can ask for homing, and for nothing else: that is no fault.
    if (device_.homes && activity_ == Activity::kOpening) return end_steps(now);
    const bool pressed = status.detail == 10 || (status.pins && status.pins->emergency_stop);
    fail({pressed ? ErrorCode::kEmergencyStop : ErrorCode::kDeviceRefused, 0});
    end_stop();
    activity_ = Activity::kIdle;
    return;
  }
  if (status.state != State::kIdle) return;
  if (setting_ && activity_ == Activity::kOpening) {
    fail(*setting_);
    end_stop();
    activity_ = Activity::kIdle;
    return;
  }
  if (mark(now)) return;
  end_steps(now);
}

void GrblDriver::end_steps(Instant now) {
  const bool opened = activity_ == Activity::kOpening;
  activity_ = Activity::kIdle;
  poll_due_ = now + timing_.resting_poll;
  if (opened) goes_on_until_.reset();
  update_positions(now);
  if (stop_asked_) return end_stop();
  if (opened && commands_ == 0) return tell(Kind::kReady);
  end_commands(Kind::kDone);
}

// Alarms

void GrblDriver::take_alarm(std::uint16_t code, Instant now) {
  if (!keeps_position(code)) known_.lose();
  // Behind our own reset in a search for switches.
  if (reset_at_) return;
  lines_.clear();
  unanswered_ = 0;
  alarm_ = code;
  alarm_at_ = now;
  activity_ = Activity::kAlarm;
  asked_at_.reset();
  pending_.clear();
  output_.clear();
  poll_due_ = now;
}

void GrblDriver::step_alarm(const Status& status) {
  std::int8_t joint = -1;
  if (status.pins) {
    for (std::size_t i = joints_.size(); i-- > 0;) {
      if ((status.pins->limits >> i & 1) != 0) joint = static_cast<std::int8_t>(i);
    }
  }
  const Error error = error_of(alarm_, joint);
  activity_ = Activity::kIdle;
  fail(error);
  end_stop();
}

// A motion

bool GrblDriver::is_there(const Values& counts, const Values& target) const {
  for (std::size_t i = 0; i < counts.size(); ++i) {
    if (std::abs(counts[i] - target[i]) > tolerance(i)) return false;
  }
  return true;
}

/// Pieces that are not over, by their own times since the last status.
std::size_t GrblDriver::waiting(Instant now) const {
  double time = to_seconds(now - began_);
  std::size_t over = 0;
  for (const Pending& one : pending_) {
    time -= one.time;
    if (time < 0 || !one.accepted) break;
    ++over;
  }
  return pending_.size() - over;
}

/// Until its pieces are over by their own times.
Duration GrblDriver::left(Instant now) const {
  double seconds = 0;
  for (const Pending& one : pending_) seconds += one.time;
  return std::max(Duration::zero(), from_seconds(seconds) - (now - began_));
}

/// Of the pieces that it may be on, the one that is nearest to where its time puts it: a motion may
/// come back along itself.
std::optional<GrblDriver::Spot> GrblDriver::spot_of(const Values& counts, Instant asked) const {
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
  for (std::size_t k = 0; k < pending_.size() && pending_[k].sent; ++k) {
    const Pending& one = pending_[k];
    const Foot foot = foot_of(counts, *from, one.line.to);
    const double there = begins + foot.share * one.time;
    const double off = std::abs(there - time);
    if (foot.distance <= slack && (!best || off < best_off)) best = {k, there}, best_off = off;
    begins += one.time;
    from = &one.line.to;
  }
  return best;
}

/// The first ones are over.
void GrblDriver::end_pieces(std::size_t count) {
  for (std::size_t k = 0; k < count; ++k) {
    const Pending& one = pending_[0];
    began_ += from_seconds(one.time);
    before_ = begin_;
    begin_ = one.line.to;
    pending_.drop_front(1);
    --commands_;
    tell(Kind::kDone);
  }
}

void GrblDriver::step_moving(const Status& status, Instant now) {
  const Values& counts = known_.counts();
  const bool idle = status.state == State::kIdle || status.state == State::kRun;
  if (!idle) {
    // Somebody else holds it.
    fail({ErrorCode::kForeignMotion});
    return begin_stop(now);
  }
  if (pending_.empty()) {
    if (now - last_piece_ < timing_.ignored_limit) return;
    tell(Kind::kFailed, {ErrorCode::kStreamEnded, -1, to_seconds(now - last_piece_)});
    return begin_stop(now);
  }
  const bool all_accepted =
      std::ranges::all_of(pending_, [](const Pending& one) { return one.accepted; });
  const bool over = status.state == State::kIdle && all_accepted && counted_at_ >= lines_since_ &&
                    is_there(counts, pending_.back().line.to);
  if (over) {
    const bool rest = pending_.back().rest;
    end_pieces(pending_.size());
    if (rest) activity_ = Activity::kIdle;
    return;
  }
  const auto spot = spot_of(counts, counted_at_);
  if (!spot) {
    const Values& to = pending_[0].line.to;
    std::size_t worst = 0;
    for (std::size_t i = 0; i < counts.size(); ++i) {
      if (std::abs(counts[i] - to[i]) > std::abs(counts[worst] - to[worst])) worst = i;
    }
    fail({ErrorCode::kMissedTarget, static_cast<std::int8_t>(worst),
          known_.place(worst, counts[worst]), known_.place(worst, to[worst])});
    return begin_stop(now);
  }
  // A board may be later or earlier than it was asked to be.
  began_ = counted_at_ - from_seconds(spot->time);
  end_pieces(spot->piece);
  if (status.state == State::kIdle && now - changed_ >= timing_.ignored_limit + left(now)) {
    fail({ErrorCode::kMotionIgnored, 0});
    return begin_stop(now);
  }
  look_at_the_end(now);
}

/// The next status is due at the motion's end, where that comes before its turn.
void GrblDriver::look_at_the_end(Instant now) {
  poll_due_ = now + timing_.moving_poll;
  const Duration until = left(now);
  if (pending_.empty() || !pending_.back().rest || until >= timing_.moving_poll) return;
  poll_due_ = now + std::max(until + line_time_, timing_.arrival_poll);
}

void GrblDriver::step_nudging(const Status& status, Instant now) {
  const bool idle = status.state == State::kIdle && lines_.empty();
  if (!idle) return;
  if (is_there(known_.counts(), nudge_to_)) {
    activity_ = Activity::kIdle;
    end_commands(Kind::kDone);
  } else if (now - changed_ >= timing_.ignored_limit) {
    activity_ = Activity::kIdle;
    end_commands(Kind::kFailed, {ErrorCode::kMotionIgnored, 0});
  }
}

}  // namespace sinew
