#include "sinew/devices/axis_link/axis_link_driver_channel.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>

#include "sinew/core/assert.h"
#include "sinew/core/error_code.h"
#include "sinew/core/units.h"

namespace sinew::axis_link {
namespace {

/// Nearest unit: rounding must not make a target on a limit one beyond it. A target beyond one is
/// on the way back inward and stays as it is.
std::int32_t inside_units(const Joint& joint, double q) {
  const double nearest = std::round(q * kUnitsPerRad);
  const double lowest = std::ceil(joint.lower * kUnitsPerRad);
  const double highest = std::floor(joint.upper * kUnitsPerRad);
  const bool inside = within_limits(joint, q);
  const double whole = inside ? std::clamp(nearest, lowest, highest) : nearest;
  const auto units = to_units(whole / kUnitsPerRad);
  SINEW_ASSERT(units.has_value());  // limits and positions were units once
  return *units;
}

/// rad. A motor whose current failed comes back up to two full steps away: 3.6 deg, 17:1.
constexpr double kSnap = 3.7e-3;

/// s. A position in an answer is at most this old when the frame begins: docs/wires/axis_link.md.
constexpr double kReadingAge = 0.010;

/// Without a new number for longer, a good answer is a failure too: two control cycles of a board.
constexpr Duration kLateMax = std::chrono::milliseconds(8);

constexpr int kHelloTries = 8;
/// From the answer before a zero was named to the one behind it, at most: at the search's slow
/// speed a change of that goes into the shift.
constexpr Duration kShiftAge = std::chrono::milliseconds(20);

/// Longest time to rest inside the joint's limits: at full speed a moment from now, and the
/// acceleration that leads there must end first.
Duration braking_time(const Joint& joint) {
  if (joint.velocity_max == 0) return {};  // a channel without a joint as yet
  return from_seconds(joint.velocity_max / joint.acceleration_max +
                      2 * joint.acceleration_max / joint.jerk_max);
}

bool all_alike(std::span<const std::uint8_t> bytes) {
  return std::ranges::all_of(bytes, [&](std::uint8_t byte) { return byte == bytes[0]; });
}

}  // namespace

std::optional<Error> trouble_of(const State& state) {
  using enum ErrorCode;
  constexpr std::array kCodes{kFollowingError, kStalled,    kEncodersDisagree, kEncoderLost,
                              kEncoderLost,    kEndStop,    kHomingFailed,     kHomingFailed,
                              kSupplyFlag,     kOverheated, kLinkSilent,       kSelfTestFailed};
  if (state.emergency_stopped) return Error{kEmergencyStop};
  if (state.fault == 0) return std::nullopt;
  if (state.fault > kCodes.size()) return Error{kUnexpectedReply, -1, 1.0 * state.fault};
  return Error{kCodes[state.fault - 1U]};
}

std::optional<Error> refusal_of(const State& state) {
  switch (state.verdict) {
    case Verdict::kAccepted:
      return std::nullopt;
    case Verdict::kNotHomed:
      return Error{ErrorCode::kNotHomed};
    case Verdict::kOutOfLimits:  // of which it tells no number, and ours were kept
      return Error{ErrorCode::kDeviceRefused};
    case Verdict::kEmergencyStopped:
      return Error{ErrorCode::kEmergencyStop};
    case Verdict::kBusy:
      return Error{ErrorCode::kBusy};
    case Verdict::kFaulted:
      if (const auto trouble = trouble_of(state)) return trouble;
      break;
    case Verdict::kNoSession:
      break;
  }
  return Error{ErrorCode::kDeviceRefused};
}

Channel::Channel(const ChannelSettings& settings)
    : settings_(settings),
      hash_(model_hash({settings.axis, settings.joint.lower, settings.joint.upper,
                        settings.joint.velocity_max, settings.joint.acceleration_max,
                        settings.joint.jerk_max})),
      run_out_(settings.deadline + braking_time(settings.joint)) {
  SINEW_ASSERT(to_units(settings.joint.lower) && to_units(settings.joint.upper));
  SINEW_ASSERT(settings.failures_max > 0);
}

void Channel::begin(bool clear, Instant now) {
  step_ = Step::kHello;
  clear_ = clear;
  had_stopped_ = false;
  error_.reset();
  other_axis_.reset();
  command_.reset();
  setpoint_.reset();
  awaited_.reset();
  failures_ = 0;
  session_ = 0;
  state_.reset();
  has_zero_ = false;
  zero_shift_.reset();
  facts_.health.reset();
  // A number that no host before is likely to have greeted with: microseconds of the clock.
  sequence_ = static_cast<std::uint16_t>(sequence_ + 1 + now.time_since_epoch().count() / 1000);
}

void Channel::put_out(Error error) {
  if (is_out()) return;
  error.index = static_cast<std::int8_t>(settings_.axis);
  error_ = error;
  step_ = Step::kOut;
  setpoint_.reset();
}

void Channel::command(Mode mode) {
  command_ = Command{mode, std::nullopt};
  command_refusal_.reset();
}

Request Channel::next_request(Instant now) {
  SINEW_ASSERT(step_ != Step::kShut);
  began_ = now;
  sent_before_ = awaited_;
  if (step_ == Step::kHello) {
    awaited_ = sequence_;
    return hello(settings_.axis, sequence_, hash_, settings_.deadline);
  }
  Request request{.axis = settings_.axis, .session = session_};
  if (step_ == Step::kRelease && !command_) command(Mode::kRelease);
  if (step_ == Step::kClear && !command_) command(Mode::kClearFaults);
  if (command_) {
    if (!command_->sequence) command_->sequence = ++sequence_;
    request.mode = command_->mode;
    request.sequence = *command_->sequence;
  } else {
    request.sequence = ++sequence_;
    if (setpoint_) {
      request.mode = Mode::kTrack;
      request.target = inside_units(settings_.joint, setpoint_->q);
      const double speed =
          std::clamp(setpoint_->qd, kVelocityMin / kVelocityUnits, kVelocityMax / kVelocityUnits);
      request.velocity = to_velocity_units(speed).value_or(0);
    } else if (health_due_) {
      request.mode = Mode::kReadHealth;
      health_due_ = false;
    }
  }
  awaited_ = request.sequence;
  sent_at_[request.sequence % sent_at_.size()] = now;
  return request;
}

bool Channel::replied(std::span<const std::uint8_t> miso, Instant now) {
  // Of the first frame after begin() nothing is known that an answer could prove.
  if (!sent_before_ || step_ == Step::kShut) return false;
  if (miso.size() != kFrameSize) {
    fail(ErrorCode::kUnexpectedReply, 1.0 * static_cast<double>(miso.size()), now);
    return false;
  }
  const auto reply = decode_reply(miso.first<kFrameSize>());
  if (!reply) {
    const bool other = reply.error() == Reject::kOtherVersion;
    if (other && step_ == Step::kHello) {
      put_out(indexed(ErrorCode::kVersionMismatch, version_of(miso[0]), kVersion));
    } else if (all_alike(miso)) {
      fail(ErrorCode::kDeviceSilent, 0, now);
    } else {
      fail(ErrorCode::kChecksum, failures_ + 1.0, now);
    }
    return false;
  }
  const auto* identity = std::get_if<Identity>(&reply->body);
  if (identity != nullptr && step_ == Step::kHello && reply->axis == settings_.axis) {
    if (const auto error = identity_error(*identity)) {
      put_out(*error);
      return false;
    }
  }
  const bool of_session = step_ == Step::kHello ? identity != nullptr && reply->session != 0
                                                : reply->session == session_;
  if (reply->axis != settings_.axis) {
    other_axis_ = indexed(ErrorCode::kUnexpectedReply, reply->axis);
    fail(ErrorCode::kUnexpectedReply, reply->axis, now);
    return false;
  }
  if (!of_session) {
    // It started again, or heard nothing from us for so long that it closed the session.
    const auto* state = std::get_if<State>(&reply->body);
    const bool denies = state != nullptr && !state->homed;
    const bool forgot = state_ && state_->homed && (denies || !state_->position_ok);
    if (forgot) state_->position_ok = false;
    fail(forgot ? ErrorCode::kPositionUnknown : ErrorCode::kLinkSilent, 0, now);
    return false;
  }
  if (reply->sequence != *sent_before_) return late(*reply, now);
  failures_ = 0;
  executed_ = reply->sequence;
  take(*reply, began_);
  return true;
}

/// A good answer to an earlier frame than the last one.
bool Channel::late(const Reply& reply, Instant now) {
  const auto behind = static_cast<std::uint16_t>(*sent_before_ - reply.sequence);
  const bool recent = step_ != Step::kHello && behind < kRecent;
  if (recent) ++late_frames_;
  if (recent && is_newer(reply.sequence, executed_)) {
    failures_ = 0;
    executed_ = reply.sequence;
    take(reply, sent_at_[reply.sequence % sent_at_.size()]);
    return true;
  }
  const bool waits = recent && reply.sequence == executed_ && began_ - fresh_at_ <= kLateMax;
  if (!waits) fail(ErrorCode::kUnexpectedReply, 0, now);
  return false;
}

AxisLinkFacts::Axis Channel::facts() const {
  AxisLinkFacts::Axis facts = facts_;
  facts.up = is_up();
  facts.fault = error();
  if (state_) facts.state = {*state_, fresh_at_};
  if (setpoint_) facts.setpoint = setpoint_->q;
  facts.zero_shift = zero_shift_;
  facts.failed_frames = failed_frames_;
  facts.late_frames = late_frames_;
  return facts;
}

void Channel::take(const Reply& reply, Instant at) {
  if (const auto* identity = std::get_if<Identity>(&reply.body)) {
    if (step_ != Step::kHello) return;  // the frame before was still a hello
    facts_.identity = {*identity, began_};
    session_ = reply.session;
    uncertainty_ = identity->uncertainty / kUncertaintyUnits;
    step_ = clear_ ? Step::kRelease : Step::kLook;
    return;
  }
  if (command_ && command_->sequence == reply.sequence) {
    command_.reset();
    const auto* state = std::get_if<State>(&reply.body);
    if (state != nullptr) command_refusal_ = refusal_of(*state);
    if (step_ == Step::kRelease) {
      step_ = Step::kClear;
    } else if (step_ == Step::kClear) {
      step_ = Step::kLook;
    }
  }
  if (const auto* health = std::get_if<Health>(&reply.body)) facts_.health = {*health, began_};
  if (const auto* state = std::get_if<State>(&reply.body)) take_state(*state, at);
}

/// A search names its zero while the axis moves slowly: its position jumps by as much as the place
/// of the switch differs from where the search before it had it.
void Channel::look_for_zero(const State& state, Instant at) {
  if (!state.homed && !state.homing) has_zero_ = false;
  if (!state_ || !state.homed) return;
  const bool named = !state_->homed;
  if (named) zero_shift_.reset();
  const Duration between = at - fresh_at_;
  if (named && has_zero_ && between <= kShiftAge) {
    const double speed = (state_->velocity + state.velocity) / (2.0 * kStateVelocityUnits);
    zero_shift_ =
        from_units(state.position) - from_units(state_->position) - speed * to_seconds(between);
  }
  has_zero_ = state.position_ok;
}

void Channel::take_state(const State& state, Instant at) {
  look_for_zero(state, at);
  state_ = state;
  fresh_at_ = at;
  const auto trouble = trouble_of(state);
  if (step_ == Step::kLook) {
    // The silent host was the reason; this host speaks. Clearing the fault moves nothing.
    const bool stopped = trouble && trouble->code == ErrorCode::kLinkSilent && !had_stopped_;
    had_stopped_ |= stopped;
    step_ = stopped ? Step::kClear : Step::kUp;
  }
  if (step_ == Step::kUp && trouble) put_out(*trouble);
}

void Channel::fail(ErrorCode why, double measured, Instant now) {
  ++failures_;
  ++failed_frames_;
  // The number may be the one that the open session was greeted with, by another host.
  if (step_ == Step::kHello && failures_ % kHelloTries == 0)
    sequence_ = static_cast<std::uint16_t>(sequence_ + kSequenceWindow);
  const bool patient = step_ == Step::kHello || failures_ < settings_.failures_max;
  if (patient || is_out()) return;
  if (why == ErrorCode::kDeviceSilent) {
    return put_out(indexed(why, to_seconds(now - fresh_at_), to_seconds(now - fresh_at_)));
  }
  put_out(indexed(why, measured));
}

std::optional<Error> Channel::identity_error(const Identity& identity) const {
  if (identity.model_hash == hash_) return std::nullopt;
  return indexed(ErrorCode::kModelMismatch);
}

Error Channel::indexed(ErrorCode code, double measured, double limit) const {
  return {code, static_cast<std::int8_t>(settings_.axis), measured, limit};
}

bool Channel::at_rest() const {
  return !command_ && failures_ == 0 && state_ && !state_->moving && !state_->homing;
}

bool Channel::is_referenced() const {
  return step_ != Step::kShut && state_ && state_->homed && state_->position_ok && !state_->homing;
}

JointPosition Channel::position(Instant now) const {
  JointPosition position{.q = q(), .lower = settings_.joint.lower, .upper = settings_.joint.upper};
  const Duration age = now - fresh_at_;
  if (!is_referenced() || (failures_ > 0 && age > run_out_)) return position;
  // As far as it can have gone since it was seen.
  const double speed = std::abs(state_->velocity) / kStateVelocityUnits;
  const bool failed = failures_ > 0;
  const double late = to_seconds(failed ? age : began_ - fresh_at_);
  const double old = kReadingAge + late;
  // What 10 ms of acceleration add is less than a count; a late answer may have more.
  const double faster = settings_.joint.acceleration_max * late * (kReadingAge + late / 2);
  const double way = failed ? settings_.joint.velocity_max * old + kSnap : speed * old + faster;
  position.quality = failed ? PositionQuality::kUncertain : PositionQuality::kMeasured;
  position.lower = position.q - uncertainty_ - way;
  position.upper = position.q + uncertainty_ + way;
  return position;
}

}  // namespace sinew::axis_link
