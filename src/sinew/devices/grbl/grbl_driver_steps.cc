// What the driver makes of a status, by what it is about.

#include <algorithm>
#include <cmath>
#include <utility>

#include "sinew/core/assert.h"
#include "sinew/core/error_code.h"
#include "sinew/devices/grbl/grbl_driver.h"

namespace sinew {

using namespace grbl;
using Kind = DriverEvent::Kind;

namespace {

/// Statuses in a row of too few axes.
constexpr int kShortMost = 5;

bool stands(const Status& status) {
  const bool held = status.state == State::kHold && status.detail == 0;
  return held || status.state == State::kIdle || status.state == State::kAlarm ||
         status.state == State::kSleep || status.state == State::kCheck ||
         status.state == State::kTool || status.state == State::kDoor;
}

/// What an alarm means to this program; docs/wires/grbl.md. @param joint  -1: not known
Error error_of(std::uint16_t alarm, Firmware firmware, std::int8_t joint) {
  const bool fluid = firmware == Firmware::kFluidNc;
  const Error end_stop{ErrorCode::kEndStop, joint};
  const Error homing{ErrorCode::kHomingFailed, joint};
  switch (alarm) {
    case 1:
      return end_stop;
    case 3:
      return {ErrorCode::kDeviceRestarted};
    case 4:
      return {ErrorCode::kProbeClosed};
    case 6:
    case 7:
    case 8:
    case 9:
      return homing;
    case 10:
      return {fluid ? ErrorCode::kDeviceRefused : ErrorCode::kEmergencyStop, joint};
    case 11:
      return {fluid ? ErrorCode::kDeviceRefused : ErrorCode::kNotHomed, joint};
    case 12:
      return fluid ? homing : end_stop;
    case 13:
      return {fluid ? ErrorCode::kEmergencyStop : ErrorCode::kDeviceRefused, joint};
    case 14:
      return {fluid ? ErrorCode::kNotHomed : ErrorCode::kDeviceRefused, joint};
    case 17:
      return {fluid ? ErrorCode::kDeviceRefused : ErrorCode::kStalled, joint};
    default:
      return {ErrorCode::kDeviceRefused};
  }
}

/// Its counts still belong to the joints.
bool keeps_position(std::uint16_t alarm) {
  return alarm == 2 || alarm == 4 || alarm == 5;
}
/// It hears nothing but a reset then.
bool is_critical(std::uint16_t alarm) {
  return alarm == 1 || alarm == 2;
}

}  // namespace

/// Machine coordinates of as many axes as there are joints; nothing where the status has them not.
std::optional<Values> GrblDriver::counts_of(const Status& status) {
  const auto scaled = [&](Values values) {
    for (double& one : values) one *= settings_.report_scale();
    return values;
  };
  if (status.offset) offset_ = scaled(*status.offset);
  Values counts = scaled(status.position);
  for (std::size_t i = 0; status.work && i < std::min(counts.size(), offset_.size()); ++i) {
    counts[i] += offset_[i];
  }
  short_ = counts.size() < joints_.size() ? short_ + 1 : 0;
  if (short_ > 0 || (status.work && offset_.empty())) return std::nullopt;
  counts.resize(joints_.size());
  return counts;
}

/// All at once at 0 where it stood elsewhere: it has restarted, and its welcome was not heard.
bool GrblDriver::fell_to_zero(const Values& counts, Instant asked) const {
  Values zeros;
  zeros.resize(counts.size());
  if (!motion_.is_there(counts, zeros) || motion_.is_there(known_.counts(), zeros)) return false;
  return activity_ == Activity::kIdle ||
         (activity_ == Activity::kMoving && !motion_.on_time(counts, asked));
}

void GrblDriver::take_status(const Status& status, Instant now) {
  const Instant asked = asked_at_.value_or(counted_at_);
  asked_at_.reset();
  unheard_ = 0;
  told_silent_ = false;
  poll_due_ = now + (activity_ == Activity::kIdle ? timing_.resting_poll : timing_.arrival_poll);
  facts_.board = {{status.state, status.pins.value_or(Pins{})}, now};
  const auto read = counts_of(status);
  if (!read) {
    ++health_.unexpected;
    // A board of fewer axes than this robot has joints.
    if (short_ >= kShortMost && !fault_) end_with({ErrorCode::kModelMismatch});
    return;
  }
  const Values& counts = *read;
  // While it brakes they count for nothing: what was known of it holds for as far as it can have
  // gone.
  const bool looks = is_at(Step::kLook);
  if (!looks && !believable(counts, asked)) {
    poll_due_ = now;
    return;
  }
  const bool moved = !motion_.is_there(counts, known_.counts());
  if (fell_to_zero(counts, asked)) return note_restart(now);
  if (moved) changed_ = std::max(changed_, now);
  if (!looks) {
    known_.count(counts);
    counted_at_ = asked;
  }
  if (status.state == State::kSleep && !looks && !fault_) {
    known_.lose();
    return end_with({ErrorCode::kBoardRests});
  }
  switch (activity_) {
    case Activity::kOpening:
    case Activity::kStopping:
      if (step_ == Step::kLook) stood_ = counts;
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
      if (status.state == State::kAlarm && !fault_ && !locked_) take_alarm(status.detail, now);
      return watch_others(status, moved);
    default:
      return;
  }
}

/// At rest another sender, or a pendant, may move or hold it. Told once, until it is left alone.
void GrblDriver::watch_others(const Status& status, bool moved) {
  const bool before = std::exchange(
      foreign_, moved || (status.state != State::kIdle && status.state != State::kAlarm));
  if (foreign_ && !before) commands_.tell(Kind::kNotice, {ErrorCode::kForeignMotion});
}

/// No line has a checksum: where it seems to have jumped, or where all rests on it, a second status
/// has to say the same.
bool GrblDriver::believable(const Values& counts, Instant asked) {
  const bool placing =
      is_at(Step::kPlace) || (activity_ == Activity::kHoming && step_ == Step::kPlace);
  const bool rests = placing || activity_ == Activity::kIdle;
  const auto near = [&](const Values& before, Instant at) {
    const double time = std::max(0.0, to_seconds(asked - at + 2 * line_time_));
    for (std::size_t i = 0; i < counts.size(); ++i) {
      const double gone = rests ? 0 : time * device_.to_units(i, joints_[i].velocity_max);
      if (std::abs(counts[i] - before[i]) > gone + motion_.tolerance(i)) return false;
    }
    return true;
  };
  const bool twice = suspect_ && near(suspect_->counts, suspect_->asked);
  const bool good = twice || (!placing && near(known_.counts(), counted_at_) &&
                              (activity_ != Activity::kMoving || motion_.on_time(counts, asked)));
  if (good) {
    suspect_.reset();
  } else {
    if (!placing) ++health_.unexpected;
    suspect_ = {counts, asked};
  }
  return good;
}

void GrblDriver::step_look(const Status& status, Instant now) {
  if (step_ != Step::kLook) return;
  if (stands(status) || status.state == State::kHome) {
    if (activity_ == Activity::kOpening && looks_for_mark()) return;
    // Asleep its motors were off; a search of an earlier host is ended.
    const bool lost = status.state == State::kSleep || status.state == State::kHome;
    if (lost) known_.restart();
    step_ = Step::kReset;
    return reset_board(now);
  }
  // Another sender's motion, or the rest of one of an earlier host.
  if (status.state == State::kRun) say_now(RealTime::kHold);
  if (status.state == State::kJog) say_now(RealTime::kJogCancel);
}

/// Whether another status is needed to see its mark, which most boards forget by a reset: GRBL says
/// the offset of its work coordinates in each tenth or thirtieth of them.
bool GrblDriver::looks_for_mark() {
  constexpr int kLooksMax = 32;
  if (offset_.empty()) return joints_.size() > 2 && ++looks_ < kLooksMax;
  if (offset_.size() > 2) known_.see_mark(has_mark());
  return false;
}

bool GrblDriver::has_mark() const {
  constexpr double kDigit = 1e-3;
  return offset_.size() > 2 && std::abs(offset_[2] - kMark) < kDigit / 2;
}

/// Leaves the mark, where it is not there and that has not been tried yet.
bool GrblDriver::mark(Instant now) {
  if (marked_ || joints_.size() < 3 || offset_.size() < 3 || has_mark()) return false;
  const double z = kMark - offset_[2];
  marked_ = std::abs(z) <= kValueMax && say(ToolOffset{z}, Sent::kOther);
  if (!marked_) return false;
  step_ = Step::kLines;
  lines_since_ = now;
  offset_.clear();
  return true;
}

/// The board has answered to all lines that a reset was followed by.
void GrblDriver::take_lines(Instant now) {
  // A line of its settings may have been damaged.
  const bool again = activity_ == Activity::kOpening && !listed_again_ &&
                     !settings_.complete(facts_.firmware) && say(AskSettings{}, Sent::kOther);
  if (again) {
    listed_again_ = true;
    return;
  }
  step_ = Step::kPlace;
  placing_since_ = poll_due_ = now;
}

void GrblDriver::step_place(const Status& status, Instant now) {
  // Its power was away between a reset and its welcome, or another sender has moved it.
  if (!stood_.empty() && !motion_.is_there(known_.counts(), stood_)) known_.restart();
  stood_.clear();
  if (status.state == State::kAlarm) {
    // What it counts was cut off, or it never knew.
    known_.restart();
    if (!unlocked_) {
      unlocked_ = true;
      step_ = Step::kLines;
      lines_since_ = now;
      say(Unlock{}, Sent::kOther);
      say(Modes{}, Sent::kModes);
      return;
    }
    locked_ = device_.homes && !(status.pins && status.pins->emergency_stop) && status.detail != 10;
    if (locked_) return end_steps(now);
    return end_with({device_.homes ? ErrorCode::kEmergencyStop : ErrorCode::kDeviceRefused, -1});
  }
  if (status.state != State::kIdle) {
    const bool late = now - placing_since_ > timing_.welcome_timeout;
    return late ? end_with({ErrorCode::kDeviceRefused}) : void();
  }
  locked_ = false;
  const auto misfit = settings_.misfit(facts_.firmware);
  if (misfit && activity_ == Activity::kOpening) return end_with(*misfit);
  // In other modes its lines would mean other places.
  if (!modes_) return end_with({ErrorCode::kDeviceRefused});
  if (mark(now)) return;
  end_steps(now);
}

/// It stands, and is not used before the fault is cleared.
void GrblDriver::end_with(const Error& error) {
  fail(error);
  end_stop();
  motion_.clear();
  come_to_rest();
}

void GrblDriver::come_to_rest() {
  activity_ = Activity::kIdle;
  ends_at_.reset();
}

void GrblDriver::end_steps(Instant now) {
  const bool opened = activity_ == Activity::kOpening;
  come_to_rest();
  poll_due_ = now + timing_.resting_poll;
  left_searching_ = blind_ = false;
  if (opened) goes_on_until_.reset();
  update_positions(now);
  if (commands_.stop_asked()) return end_stop();
  if (opened && commands_.open() == 0) return fault_ ? void() : commands_.tell(Kind::kReady);
  end_commands(Kind::kDone);
}

// Alarms

/// It wants to be homed first, and that is no fault of a robot with switches.
bool GrblDriver::is_locked(std::uint16_t alarm) const {
  const std::uint16_t own = facts_.firmware == Firmware::kFluidNc ? 14 : 11;
  return device_.homes && alarm == own;
}

void GrblDriver::take_alarm(std::uint16_t code, Instant now) {
  if (!keeps_position(code)) known_.lose();
  // Behind our own reset in a search for switches.
  if (reset_at_ || is_locked(code)) return;
  begin_steps(Activity::kAlarm, Step::kLook, now);
  alarm_ = code;
  alarm_at_ = now;
  if (is_critical(code)) reset_board(now);
}

void GrblDriver::step_alarm(const Status& status) {
  std::int8_t joint = -1;
  if (status.pins) {
    for (std::size_t i = joints_.size(); i-- > 0;) {
      if ((status.pins->limits >> i & 1) != 0) joint = static_cast<std::int8_t>(i);
    }
  }
  end_alarm(joint);
}

void GrblDriver::end_alarm(std::int8_t joint) {
  reset_at_.reset();
  end_with(error_of(alarm_, facts_.firmware, joint));
}

// A motion

/// The first ones are over.
void GrblDriver::end_pieces(std::size_t count) {
  motion_.drop(count);
  for (std::size_t k = 0; k < count; ++k) {
    commands_.done();
  }
}

void GrblDriver::step_moving(const Status& status, Instant now) {
  const Values& counts = known_.counts();
  const bool idle = status.state == State::kIdle || status.state == State::kRun;
  if (!idle) {
    // Another sender holds it.
    fail({ErrorCode::kForeignMotion});
    return begin_stop(now);
  }
  if (motion_.empty()) {
    if (now - last_piece_ < timing_.ignored_limit) return;
    commands_.tell(Kind::kFailed, {ErrorCode::kStreamEnded, -1, to_seconds(now - last_piece_)});
    return begin_stop(now);
  }
  const GrblMotion::Piece& last = motion_.last();
  const bool waits = last.rest && last.no_way && motion_.left(now) > Duration::zero();
  const bool over = status.state == State::kIdle && motion_.all_accepted() && !waits &&
                    counted_at_ >= lines_since_ && motion_.is_there(counts, last.line.to);
  if (over) {
    const bool rest = last.rest;
    end_pieces(motion_.size());
    if (rest) come_to_rest();
    return;
  }
  const auto spot = motion_.spot_of(counts, counted_at_);
  if (!spot) {
    const Values& to = motion_.first().line.to;
    std::size_t worst = 0;
    for (std::size_t i = 0; i < counts.size(); ++i) {
      if (std::abs(counts[i] - to[i]) > std::abs(counts[worst] - to[worst])) worst = i;
    }
    fail({ErrorCode::kMissedTarget, static_cast<std::int8_t>(worst),
          known_.place(worst, counts[worst]), known_.place(worst, to[worst])});
    return begin_stop(now);
  }
  // A board may be later or earlier than it was asked to be.
  motion_.be_at(*spot, counted_at_);
  if (spot->piece > 0) changed_ = now;
  end_pieces(spot->piece);
  const bool ignores = status.state == State::kIdle && motion_.is_to_move();
  if (ignores && now - changed_ >= timing_.ignored_limit + motion_.left(now)) {
    fail({ErrorCode::kMotionIgnored, 0});
    return begin_stop(now);
  }
  look_at_the_end(now);
}

/// The next status is due at the motion's end, where that comes before its turn.
void GrblDriver::look_at_the_end(Instant now) {
  poll_due_ = now + timing_.moving_poll;
  const Duration until = motion_.left(now);
  if (motion_.empty() || !motion_.last().rest || until >= timing_.moving_poll) return;
  poll_due_ = now + std::max(until + line_time_, timing_.arrival_poll);
}

/// A digit of its line may have been lost.
std::optional<std::size_t> GrblDriver::off_its_way() const {
  for (std::size_t i = 0; i < nudge_to_.size(); ++i) {
    const auto [lower, upper] = std::minmax(nudge_from_[i], nudge_to_[i]);
    const double slack = motion_.tolerance(i), here = known_.counts()[i];
    if (here < lower - slack || here > upper + slack) return i;
  }
  return std::nullopt;
}

void GrblDriver::step_nudging(const Status& status, Instant now) {
  if (const auto joint = off_its_way()) {
    const bool known = positions_[*joint].quality != PositionQuality::kLost;
    const auto place = [&](double count) { return known ? known_.place(*joint, count) : 0; };
    fail({ErrorCode::kMissedTarget, static_cast<std::int8_t>(*joint),
          place(known_.counts()[*joint]), place(nudge_to_[*joint])});
    return begin_stop(now);
  }
  if (status.state != State::kIdle) return;
  const bool there = (probes_ && facts_.touched) || motion_.is_there(known_.counts(), nudge_to_);
  if (lines_.empty() && there) {
    come_to_rest();
    end_commands(Kind::kDone);
  } else if (now - changed_ >= timing_.ignored_limit) {
    const bool waits = !lines_.empty();
    end_commands(Kind::kFailed, {ErrorCode::kMotionIgnored, 0});
    waits ? begin_stop(now) : come_to_rest();
  }
}

}  // namespace sinew
