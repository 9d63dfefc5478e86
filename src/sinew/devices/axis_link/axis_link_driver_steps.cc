#include <algorithm>
#include <cmath>

#include "sinew/core/assert.h"
#include "sinew/core/error_code.h"
#include "sinew/devices/axis_link/axis_link_driver.h"

// What AxisLinkDriver does once an answer came or time passed: one function per activity.
namespace sinew {

using namespace axis_link;
using Kind = DriverEvent::Kind;

namespace {

/// Until each axis was asked once, so that a weak magnet shows at the start.
constexpr Duration kFirstHealthPeriod = std::chrono::milliseconds(20);

/// Around 65536, so that it holds for 16 s of frames.
bool is_behind(std::uint16_t sequence, std::uint16_t other) {
  const auto ahead = static_cast<std::uint16_t>(other - sequence);
  return ahead != 0 && ahead < 0x8000;
}

}  // namespace

void AxisLinkDriver::step(Instant now) {
  switch (activity_) {
    case Activity::kClosed:
      return;
    case Activity::kOpening:
      step_opening(now);
      break;
    case Activity::kIdle:
      step_idle(now);
      break;
    case Activity::kMoving:
      step_moving(now);
      break;
    case Activity::kHoming:
    case Activity::kTesting:
      step_turns(now);
      break;
    case Activity::kStopping:
      step_stopping(now);
      break;
  }
  update_positions(now);
}

void AxisLinkDriver::step_opening(Instant now) {
  const double waited = to_seconds(now - since_);
  bool resolved = true;
  for (Channel& channel : channels_) {
    if (channel.is_up() || channel.is_out() || channel.step() == Channel::Step::kShut) continue;
    if (now - since_ >= timing_.open_timeout) {
      const Error silent{ErrorCode::kDeviceSilent, -1, waited, to_seconds(timing_.open_timeout)};
      channel.put_out(channel.other_axis().value_or(silent));
    } else {
      resolved = false;
    }
  }
  if (!resolved) return;
  update_positions(now);
  activity_ = Activity::kIdle;
  since_ = now;
  if (any_up()) {
    fault_.reset();
    tell(clearing_ ? Kind::kDone : Kind::kReady);
  } else {
    fault_ = why_all_are_out();
    tell(Kind::kFailed, *fault_);
  }
  if (clearing_) --pending_;
  clearing_ = false;
  for (std::size_t i = 0; i < channels_.size(); ++i) {
    if (!channels_[i].is_up() || !channels_[i].had_stopped()) continue;
    tell(Kind::kNotice, {ErrorCode::kLinkSilent, static_cast<std::int8_t>(i)});
  }
  note_outs();
}

/// The axis that went out since the last look, if any.
std::optional<Error> AxisLinkDriver::first_new_out() {
  for (std::size_t i = 0; i < channels_.size(); ++i) {
    if (known_out_[i] || !channels_[i].is_out()) continue;
    known_out_[i] = true;
    told_[i].reset();
    return channels_[i].error();
  }
  return std::nullopt;
}

void AxisLinkDriver::note_outs() {
  while (const auto error = first_new_out()) tell(Kind::kNotice, *error);
}

void AxisLinkDriver::step_idle(Instant now) {
  note_outs();
  // With every axis out nothing can be asked for any more; who waits shall hear of it.
  if (!fault_ && !any_up()) {
    fault_ = why_all_are_out();
    tell(Kind::kFailed, *fault_);
  }
  if (now < health_due_) return;
  const bool first_round = healths_asked_ < channels_.size();
  if (first_round) ++healths_asked_;
  health_due_ = now + (first_round ? kFirstHealthPeriod : timing_.health_period);
  health_axis_ = (health_axis_ + 1) % channels_.size();
  channels_[health_axis_].ask_health();
}

void AxisLinkDriver::fail(const Error& error, Instant now) {
  fault_ = error;
  end_commands(Kind::kFailed, error);
  begin_stop(Mode::kStop, now);
  note_outs();
}

void AxisLinkDriver::step_moving(Instant now) {
  if (const auto out = first_new_out()) return fail(*out, now);
  for (std::size_t i = 0; i < channels_.size(); ++i) {
    if (!channels_[i].is_up()) continue;
    if (auto refusal = refusal_of(*channels_[i].state())) {
      refusal->index = static_cast<std::int8_t>(i);
      return fail(*refusal, now);
    }
  }
  if (settling_) return step_settling(now);
  while (queue_.size() > 1 && now >= queue_.front().end) {
    queue_.pop_front();
    --pending_;
    tell(Kind::kDone);
  }
  if (now < queue_.front().end) return;
  if (!queue_.front().ends_at_rest) {
    // Nobody said how it goes on. Not a fault: the next motion may begin once it stands.
    const double duration = to_seconds(queue_.front().end - queue_.front().start);
    end_commands(Kind::kFailed,
                 {ErrorCode::kSegmentTime, -1, duration, to_seconds(now - queue_.front().start)});
    return begin_stop(Mode::kStop, now);
  }
  settling_ = true;
  since_ = now;
  for (std::size_t i = 0; i < channels_.size(); ++i) settle_from_[i] = channels_[i].sequence();
}

void AxisLinkDriver::step_settling(Instant now) {
  bool settled = true;
  for (std::size_t i = 0; i < channels_.size(); ++i) {
    const Channel& channel = channels_[i];
    if (!channel.is_up()) continue;
    const double target = queue_.at(i, now).q;
    const bool arrived = channel.at_rest() && is_behind(settle_from_[i], channel.executed()) &&
                         std::abs(channel.q() - target) <= timing_.settle_tolerance;
    if (!arrived && now - since_ >= timing_.settle_timeout) {
      return fail({ErrorCode::kMissedTarget, static_cast<std::int8_t>(i), channel.q(), target},
                  now);
    }
    settled = settled && arrived;
  }
  if (!settled) return;
  for (std::size_t i = 0; i < channels_.size(); ++i) {
    if (channels_[i].is_up()) told_[i] = queue_.at(i, now).q;
    channels_[i].follow(std::nullopt);
  }
  queue_.clear();
  settling_ = false;
  activity_ = Activity::kIdle;
  since_ = now;
  end_commands(Kind::kDone);
}

void AxisLinkDriver::step_turns(Instant now) {
  if (const auto out = first_new_out()) return fail(*out, now);
  const bool homes = activity_ == Activity::kHoming;
  const ErrorCode failed = homes ? ErrorCode::kHomingFailed : ErrorCode::kSelfTestFailed;
  const Duration limit = homes ? timing_.homing_timeout : timing_.test_timeout;
  const std::uint8_t joint = homing_order_[homing_place_];
  const auto index = static_cast<std::int8_t>(joint);
  const Channel& channel = channels_[joint];
  if (now - since_ >= limit) {
    return fail({failed, index, to_seconds(now - since_), to_seconds(limit)}, now);
  }
  if (!channel.at_rest()) return;
  const State& state = *channel.state();
  const bool found = !homes || (state.homed && state.position_ok);
  if (channel.command_refusal() || !found) {
    Error error = channel.command_refusal().value_or(Error{failed});
    error.index = index;
    return fail(error, now);
  }
  since_ = now;
  take_turn(homing_place_ + 1);
  if (homing_place_ < homing_order_.size()) return;
  activity_ = Activity::kIdle;
  end_commands(Kind::kDone);
}

void AxisLinkDriver::step_stopping(Instant now) {
  const Duration limit = run_out_ + timing_.stop_margin;
  bool stands = !to_all_due_;
  for (std::size_t i = 0; i < channels_.size(); ++i) {
    const Channel& channel = channels_[i];
    if (is_out_by_choice(i) || channel.at_rest()) continue;
    // Nobody answers: its own deadline has stopped it and it has braked, or it has no power.
    const Duration silence = channel.silence(now);
    const bool stood_before = silence >= channel.run_out() + timing_.stop_margin;
    const Duration wait = stood_before ? deadline_ : channel.run_out();
    if (channel.is_out() && std::min(silence, now - since_) >= wait) continue;
    if (now - since_ >= limit) {
      fault_ = fault_.value_or(Error{ErrorCode::kUnexpectedReply, static_cast<std::int8_t>(i),
                                     to_seconds(now - since_), to_seconds(limit)});
      continue;
    }
    stands = false;
  }
  while (const auto out = first_new_out()) {
    if (!fault_) fault_ = *out;
    tell(Kind::kNotice, *out);
  }
  if (!stands) return;
  activity_ = Activity::kIdle;
  since_ = now;
  if (stop_asked_) {
    pending_ = std::max<std::size_t>(pending_, 1);
    end_commands(Kind::kStopped);
  }
  stop_asked_ = false;
}

}  // namespace sinew
