// Lines and characters of the driver: what is said when, and what a reply answers.

#include <algorithm>
#include <cmath>

#include "sinew/core/assert.h"
#include "sinew/devices/grbl/grbl_driver.h"

namespace sinew {

using namespace grbl;
using Kind = DriverEvent::Kind;

namespace {

/// GRBL 1.1 counts 128 characters, of which one stays free; boards that report more have more.
constexpr std::size_t kRoomLeast = 127;
constexpr std::size_t kRoomMost = 1023;
/// Of a board's own limits: what its decimals leave open.
constexpr double kNearEnough = 0.999;

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
  asked_at_ = now;
}

/// As many as the board has room for, in their order.
void GrblDriver::say_moves(Instant now) {
  if (activity_ != Activity::kMoving) return;
  for (Pending& one : pending_) {
    if (one.sent) continue;
    if (one.no_way) {
      one.sent = one.accepted = true;
      continue;
    }
    if (!say(one.line, Sent::kMove)) return;
    if (&one == &pending_[0]) began_ = now;
    one.sent = true;
  }
}

/// Drops what the board has of lines, in a state in which nothing moves. @pre it stands, or looks
/// for switches
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
  const bool steps = activity_ == Activity::kOpening || activity_ == Activity::kStopping;
  if (activity_ == Activity::kHoming && !lines_.empty()) {
    if (now_ - lines_since_ > timing_.homing_limit) fall_silent(now_);
  } else if (steps && step_ == Step::kReset) {
    if (now_ - *reset_at_ >= timing_.welcome_timeout) {
      ++unheard_;
      if (unheard_ >= timing_.tries) return fall_silent(now_);
      reset_board(now_);
    }
  } else if (steps && step_ == Step::kLines) {
    if (now_ - lines_since_ >= timing_.welcome_timeout) fall_silent(now_);
  } else if (asked_at_ && now_ - *asked_at_ >= timing_.reply_timeout) {
    ++unheard_;
    if (unheard_ >= timing_.tries) return fall_silent(now_);
    ask_status(now_);
  } else if (!asked_at_ && now_ >= poll_due_) {
    ask_status(now_);
  }
  say_moves(now_);
  update_positions(now_);
}

std::optional<Instant> GrblDriver::next_deadline() const {
  const bool steps = activity_ == Activity::kOpening || activity_ == Activity::kStopping;
  Instant due = asked_at_ ? *asked_at_ + timing_.reply_timeout : poll_due_;
  if (activity_ == Activity::kClosed) return std::nullopt;
  if (activity_ == Activity::kHoming && !lines_.empty()) due = lines_since_ + timing_.homing_limit;
  if (steps && step_ == Step::kReset) due = *reset_at_ + timing_.welcome_timeout;
  if (steps && step_ == Step::kLines) due = lines_since_ + timing_.welcome_timeout;
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
  if (const auto* one = std::get_if<Setting>(&reply)) return take_setting(*one);
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
  if (line.what == Sent::kMove) {
    const auto one = std::ranges::find_if(
        pending_, [](const Pending& each) { return each.sent && !each.accepted; });
    if (one != pending_.end()) one->accepted = true;
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
      return take_ok(now);
  }
}

/// The first one that does not fit what motions are planned with.
void GrblDriver::take_setting(const Setting& setting) {
  if (setting_) return;
  const auto misfit = [&](ErrorCode code, std::size_t joint, double is, double needed) {
    setting_ = {code, static_cast<std::int8_t>(joint), is, needed};
  };
  if (setting.number == kIdleSetting && setting.value < 255)
    misfit(ErrorCode::kBoardRests, 0, 0, 0);
  for (std::size_t i = 0; i < joints_.size(); ++i) {
    const Joint& joint = joints_[i];
    const double rate = from_deg(setting.value) / 60;
    const double acceleration = from_deg(setting.value);
    const double steps = std::abs(device_.axes[i].steps_per_rad) * from_deg(1);
    if (setting.number == kRateSetting + i && rate < kNearEnough * joint.velocity_max) {
      misfit(ErrorCode::kBoardVelocity, i, rate, joint.velocity_max);
    }
    if (setting.number == kAccelerationSetting + i &&
        acceleration < kNearEnough * joint.acceleration_max) {
      misfit(ErrorCode::kBoardAcceleration, i, acceleration, joint.acceleration_max);
    }
    if (setting.number == kStepsSetting + i && std::abs(setting.value - steps) > 1e-3 * steps) {
      misfit(ErrorCode::kBoardSteps, i, setting.value, steps);
    }
  }
}

void GrblDriver::take_welcome(const Welcome& /*welcome*/, Instant now) {
  if (!reset_at_) {
    // Behind some alarms grblHAL resets itself.
    const bool by_alarm = alarm_at_ && now - *alarm_at_ < timing_.welcome_timeout;
    if (!by_alarm) note_restart(now);
    return;
  }
  reset_at_.reset();
  offset_.clear();
  unheard_ = 0;
  step_ = Step::kLines;
  lines_since_ = now;
  setting_.reset();
  say(Modes{}, Sent::kOther);
  if (activity_ != Activity::kOpening) return;
  say(AskBuild{}, Sent::kOther);
  say(AskSettings{}, Sent::kOther);
}

}  // namespace sinew
