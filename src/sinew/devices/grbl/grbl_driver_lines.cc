// Lines and characters of the driver: what is said when, and what a reply answers.

#include <algorithm>
#include <cmath>

#include "sinew/core/assert.h"
#include "sinew/core/error_code.h"
#include "sinew/devices/grbl/grbl_driver.h"

namespace sinew {

using namespace grbl;
using Kind = DriverEvent::Kind;

namespace {

/// GRBL 1.1 counts 128 characters, of which one stays free; boards that report more have more.
constexpr std::size_t kRoomLeast = 127;
constexpr std::size_t kRoomMost = 1023;

}  // namespace

/// False where the port or the board has no room for it.
bool GrblDriver::say(const Request& request, Sent what) {
  const auto line = encode(request);
  const bool fits = unanswered_ + line.size() <= room_ && !lines_.full();
  if (!fits || output_.size() + line.size() > output_.capacity()) return false;
  if (lines_.empty()) lines_since_ = now_;
  lines_.push_back({what, static_cast<std::uint8_t>(line.size())});
  unanswered_ += line.size();
  for (const char c : line) output_.push_back(static_cast<std::uint8_t>(c));
  ++health_.requests;
  return true;
}

void GrblDriver::say_now(RealTime what) {
  if (output_.full()) return;
  output_.push_back(static_cast<std::uint8_t>(what));
}

void GrblDriver::ask_status(Instant now) {
  if (asked_at_) ++health_.timeouts;
  say_now(RealTime::kStatus);
  ++health_.requests;
  // What comes may answer to the oldest one.
  if (!asked_at_) asked_at_ = now;
  asked_last_ = now;
}

/// As many as the board has room for, in their order.
void GrblDriver::say_moves(Instant now) {
  if (activity_ != Activity::kMoving) return;
  GrblMotion::Pieces& pieces = motion_.pieces();
  for (GrblMotion::Piece& one : pieces) {
    if (one.sent) continue;
    if (one.no_way) {
      one.sent = one.accepted = true;
      continue;
    }
    if (!say(one.line, Sent::kMove)) return;
    if (&one == &pieces[0]) motion_.started(now);
    if (!motion_.is_to_move()) changed_ = now;
    one.sent = true;
  }
}

/// Drops what the board has of lines. @pre it stands, looks for switches, or says nothing
void GrblDriver::reset_board(Instant now) {
  if (reset_at_) ++health_.retries;
  output_.clear();
  say_now(RealTime::kReset);
  lines_.clear();
  unanswered_ = 0;
  reset_at_ = now;
  asked_at_.reset();
}

// Time

void GrblDriver::poll(Instant now) {
  now_ = std::max(now_, now);
  if (activity_ == Activity::kClosed) return;
  if (reset_at_) {
    wait_for_welcome(now_);
  } else if (activity_ == Activity::kHoming && !lines_.empty()) {
    if (now_ - lines_since_ > timing_.homing_limit) search_too_long(now_);
  } else if (is_at(Step::kLines)) {
    if (now_ - lines_since_ >= timing_.welcome_timeout) fall_silent(now_);
  } else if (asked_at_ && now_ - asked_last_ >= timing_.reply_timeout) {
    miss_reply(now_);
  } else if (!asked_at_ && now_ >= poll_due_) {
    ask_status(now_);
  }
  say_moves(now_);
  update_positions(now_);
}

void GrblDriver::wait_for_welcome(Instant now) {
  if (now - *reset_at_ < timing_.welcome_timeout) return;
  if (++unheard_ < timing_.tries) return reset_board(now);
  activity_ == Activity::kAlarm ? end_alarm(-1) : fall_silent(now);
}

void GrblDriver::miss_reply(Instant now) {
  if (++unheard_ < timing_.tries) return ask_status(now);
  if (activity_ == Activity::kAlarm) return end_alarm(-1);
  // In some alarms, and in a search for switches, it hears nothing but a reset.
  const bool moves = goes_on_until() && !left_searching_;
  const bool looks = activity_ == Activity::kOpening && step_ == Step::kLook;
  if (!looks || blind_ || moves) return fall_silent(now);
  blind_ = true;
  known_.restart();
  unheard_ = 0;
  step_ = Step::kReset;
  reset_board(now);
}

void GrblDriver::search_too_long(Instant now) {
  const double limit = to_seconds(timing_.homing_limit);
  end_commands(Kind::kFailed, {ErrorCode::kHomingFailed, -1, limit, limit});
  begin_stop(now);
}

std::optional<Instant> GrblDriver::next_deadline() const {
  if (activity_ == Activity::kClosed) return std::nullopt;
  Instant due = asked_at_ ? asked_last_ + timing_.reply_timeout : poll_due_;
  if (activity_ == Activity::kHoming && !lines_.empty()) due = lines_since_ + timing_.homing_limit;
  if (is_at(Step::kLines)) due = lines_since_ + timing_.welcome_timeout;
  if (reset_at_) due = *reset_at_ + timing_.welcome_timeout;
  return std::max(due, now_ + std::chrono::microseconds(100));
}

// Replies

void GrblDriver::receive(std::span<const std::uint8_t> bytes, Instant now) {
  now_ = std::max(now_, now);
  for (const std::uint8_t byte : bytes) {
    const LineDecoder::Result result = decoder_.push(byte);
    if (result == LineDecoder::Result::kMore || activity_ == Activity::kClosed) continue;
    const auto reply =
        result == LineDecoder::Result::kLine ? decode_reply(decoder_.line()) : std::nullopt;
    if (reply) {
      take(*reply, now_);
    } else {
      ++health_.unexpected;
    }
  }
  poll(now);
}

void GrblDriver::take(const Reply& reply, Instant now) {
  // Before its welcome whatever comes is about what was dropped.
  const bool dropped =
      reset_at_ && !std::holds_alternative<Welcome>(reply) && !std::holds_alternative<Alarm>(reply);
  if (dropped) return;
  if (std::holds_alternative<Ok>(reply)) return take_ok(now);
  if (const auto* one = std::get_if<Refused>(&reply)) return take_refusal(*one, now);
  if (const auto* one = std::get_if<Alarm>(&reply)) return take_alarm(one->code, now);
  if (const auto* one = std::get_if<Welcome>(&reply)) return take_welcome(*one, now);
  if (const auto* one = std::get_if<Status>(&reply)) return take_status(*one, now);
  if (const auto* one = std::get_if<Probed>(&reply)) return take_probed(*one, now);
  if (const auto* one = std::get_if<Setting>(&reply)) return settings_.take(*one);
  if (const auto* one = std::get_if<Build>(&reply)) {
    room_ = std::clamp<std::size_t>(one->bytes > 0 ? one->bytes - 1U : 0, kRoomLeast, kRoomMost);
  }
}

/// Of the oldest line without one.
void GrblDriver::take_ok(Instant now) {
  const bool looks = activity_ == Activity::kStopping && step_ == Step::kLook;
  if (lines_.empty()) {
    // To a line that a stop has dropped.
    health_.unexpected += looks ? 0 : 1;
    return;
  }
  const Line line = lines_[0];
  lines_.drop_front(1);
  unanswered_ -= line.size;
  lines_since_ = now;
  told_silent_ = false;
  modes_ = modes_ || line.what == Sent::kModes;
  if (line.what == Sent::kMove) {
    GrblMotion::Pieces& pieces = motion_.pieces();
    const auto one = std::ranges::find_if(
        pieces, [](const GrblMotion::Piece& each) { return each.sent && !each.accepted; });
    if (one != pieces.end()) one->accepted = true;
    return;
  }
  if (!lines_.empty()) return;
  if (activity_ == Activity::kHoming) {
    asked_at_.reset();
    poll_due_ = now;
  } else if (activity_ == Activity::kOpening || activity_ == Activity::kStopping) {
    take_lines(now);
  }
}

void GrblDriver::take_probed(const Probed& probed, Instant now) {
  const bool asked = activity_ == Activity::kNudging && probes_;
  if (!asked || !probed.touched || probed.at.size() < joints_.size()) return;
  GrblFacts::Touch touch{nudge_joint_, std::nullopt};
  if (positions_[nudge_joint_].quality != PositionQuality::kLost) {
    touch.q = known_.place(nudge_joint_, probed.at[nudge_joint_] * settings_.report_scale());
  }
  facts_.touched = {touch, now};
}

void GrblDriver::take_refusal(const Refused& /*refused*/, Instant now) {
  if (lines_.empty()) {
    ++health_.unexpected;
    return;
  }
  const Line line = lines_[0];
  const Error error{ErrorCode::kDeviceRefused};
  switch (activity_) {
    case Activity::kMoving:
      fail(error);
      return begin_stop(now);
    case Activity::kHoming:
    case Activity::kNudging:
      lines_.drop_front(1);
      unanswered_ -= line.size;
      end_commands(Kind::kFailed, error);
      activity_ = Activity::kIdle;
      poll_due_ = now;
      return;
    default:
      // What it does not know of an opening's questions, it leaves out; a lock shows in its state.
      lines_[0].what = Sent::kOther;
      return take_ok(now);
  }
}

void GrblDriver::take_welcome(const Welcome& welcome, Instant now) {
  facts_.firmware = welcome.firmware;
  if (!reset_at_) {
    // Behind some alarms grblHAL resets itself.
    const bool by_alarm = alarm_at_ && now - *alarm_at_ < timing_.welcome_timeout;
    if (!by_alarm) note_restart(now);
    return;
  }
  reset_at_.reset();
  offset_.clear();
  unheard_ = 0;
  modes_ = false;
  if (activity_ == Activity::kAlarm) {
    poll_due_ = now;  // its pins say which switch
    return;
  }
  step_ = Step::kLines;
  lines_since_ = now;
  say(Modes{}, Sent::kModes);
  if (activity_ != Activity::kOpening) return;
  settings_.begin();
  say(AskBuild{}, Sent::kOther);
  say(AskSettings{}, Sent::kOther);
}

}  // namespace sinew
