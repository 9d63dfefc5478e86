#include "sinew/devices/axis_link/axis_link_device.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>

#include "sinew/core/assert.h"
#include "sinew/wire/little_words.h"

namespace sinew {

using namespace axis_link;

namespace {

Verdict verdict_of(AxisVerdict verdict) {
  switch (verdict) {
    case AxisVerdict::kAccepted:
      return Verdict::kAccepted;
    case AxisVerdict::kNotHomed:
      return Verdict::kNotHomed;
    case AxisVerdict::kOutOfLimits:
      return Verdict::kOutOfLimits;
    case AxisVerdict::kFaulted:
      return Verdict::kFaulted;
    case AxisVerdict::kEmergencyStopped:
      return Verdict::kEmergencyStopped;
    case AxisVerdict::kBusy:
      break;
  }
  return Verdict::kBusy;
}

/// `value` in units, nearest, held inside the numbers of T without the lowest (which may mean
/// "not measured").
template <class T>
T saturated(double value) {
  constexpr double kMost = std::numeric_limits<T>::max();
  const double lowest = std::numeric_limits<T>::is_signed ? -kMost : 0;
  return static_cast<T>(std::clamp(std::round(value), lowest, kMost));
}

/// From a new setup to the start with it: the host fetches the answer meanwhile.
constexpr Duration kRestartDelay = std::chrono::milliseconds(200);

bool under_way(const AxisStatus& status) {
  return status.moving || status.homing;
}

}  // namespace

AxisLinkNodeSettings axis_link_node_settings(const Joint& joint, std::uint8_t axis,
                                             std::uint16_t boot) {
  return {.model = {axis, joint.lower, joint.upper, joint.velocity_max, joint.acceleration_max,
                    joint.jerk_max},
          .boot = boot};
}

AxisLinkNodeSettings axis_link_node_settings(const std::optional<AxisSetup>& setup,
                                             std::uint16_t boot) {
  if (!setup) return {.model = {}, .boot = boot};
  const AxisSettings& axis = setup->axis;
  return {.model = {setup->axis_number, axis.lower, axis.upper, axis.limits.velocity,
                    axis.limits.acceleration, axis.limits.jerk},
          .boot = boot,
          .uncertainty = axis.uncertainty()};
}

AxisLinkNode::AxisLinkNode(Axis& axis, const AxisLinkNodeSettings& settings, SetupStore* setup)
    : axis_(axis),
      setup_(setup),
      settings_(settings),
      hash_(model_hash(settings.model)),
      last_session_(static_cast<std::uint8_t>(settings.boot)) {
  SINEW_ASSERT(settings.model.axis < kAxes);
  prepare();
}

void AxisLinkNode::select(bool selected) {
  if (selected == selected_) return;
  selected_ = selected;
  if (selected) {
    sending_ = prepared_;
    shifted_ = 0;
    return;
  }
  if (shifted_ == 0) return;  // a glitch on the select, or a scan of the bus
  if (shifted_ != kFrameSize) {
    ++bad_frames_;
    return;
  }
  take_frame(received_);
}

std::uint8_t AxisLinkNode::shift(std::uint8_t mosi) {
  if (!selected_) return 0;
  const std::size_t place = shifted_;
  if (shifted_ <= kFrameSize) ++shifted_;
  if (place >= kFrameSize) return 0;
  received_[place] = mosi;
  return sending_[place];
}

void AxisLinkNode::receive(std::span<const std::uint8_t> bytes) {
  for (const std::uint8_t byte : bytes) {
    const auto frame = decoder_.push(byte);
    if (!frame) continue;
    if (frame->size() != kFrameSize) {
      ++bad_frames_;
      continue;
    }
    // As on SPI: the answer is the state that it had when the frame began.
    const Frame answer = prepared_;
    if (!take_frame(frame->first<kFrameSize>())) continue;
    const cobs::Stream stream = cobs::encode(answer);
    // A host that does not read loses whole answers, never half of one.
    if (output_.size() + stream.size() > output_.capacity()) continue;
    for (const std::uint8_t out : stream) output_.push_back(out);
  }
}

std::size_t AxisLinkNode::take_output(std::span<std::uint8_t> out) {
  return output_.take_front(out);
}

void AxisLinkNode::advance(Instant now) {
  SINEW_ASSERT(now >= now_);
  now_ = now;
  if (session_ != 0 && now - heard_ >= deadline_) close_session();
  prepare();
}

std::optional<Instant> AxisLinkNode::next_event() const {
  if (session_ == 0) return std::nullopt;
  return heard_ + deadline_;
}

/// True where the frame asks for an answer of this axis.
bool AxisLinkNode::take_frame(std::span<const std::uint8_t, kFrameSize> bytes) {
  const auto request = decode_request(bytes);
  if (!request) {
    ++bad_frames_;
    return false;
  }
  if (!request->to_all && request->axis != settings_.model.axis) return false;
  ++good_frames_;
  execute(*request);
  prepare();
  return !request->to_all;
}

void AxisLinkNode::execute(const Request& request) {
  if (request.mode == Mode::kHello) return greet(request);
  const bool of_session = session_ != 0 && request.session == session_ && !request.to_all;
  const bool is_new = of_session && is_newer(request.sequence, executed_);
  const bool is_repeat = of_session && request.sequence == executed_;
  // A stop needs no permission: an old one, or one of a host without a session, does no harm.
  const bool stops = request.mode == Mode::kStop || request.mode == Mode::kEmergencyStop;
  if (is_new || is_repeat || stops) asked_ = request.mode;
  if (is_new) {
    executed_ = request.sequence;
    heard_ = now_;
  }
  if (is_new || (stops && !is_repeat)) verdict_ = obey(request);
  if (session_ == 0 && !stops) verdict_ = Verdict::kNoSession;
}

void AxisLinkNode::greet(const Request& request) {
  asked_ = Mode::kHello;
  const auto hash = std::bit_cast<std::uint32_t>(request.target);
  const Duration deadline = std::chrono::milliseconds(request.velocity);
  const bool fits = hash == hash_ && deadline >= kDeadlineMin && deadline <= kDeadlineMax;
  // The session's own hello, again or late, is no news.
  if (!fits || (session_ != 0 && request.sequence == greeted_)) return;
  // Another host, or one that lost count: what the last one had begun ends here.
  if (under_way(axis_.status())) {
    axis_.cancel_homing();
    axis_.stop();
  }
  last_session_ = last_session_ == 255 ? 1 : static_cast<std::uint8_t>(last_session_ + 1);
  session_ = last_session_;
  executed_ = greeted_ = request.sequence;
  deadline_ = deadline;
  heard_ = now_;
  verdict_ = Verdict::kAccepted;
}

Verdict AxisLinkNode::obey(const Request& request) {
  // Whatever began now would end with the start that is due.
  const bool begins = request.mode == Mode::kTrack || request.mode == Mode::kMove ||
                      request.mode == Mode::kHome || request.mode == Mode::kSelfTest;
  if (begins && restart_at_) return Verdict::kBusy;
  switch (request.mode) {
    case Mode::kRead:
    case Mode::kReadHealth:
    case Mode::kHello:
      break;
    case Mode::kHold:
      if (axis_.status().moving) axis_.stop();
      break;
    case Mode::kTrack:
      return verdict_of(axis_.track(from_units(request.target), request.velocity / kVelocityUnits));
    case Mode::kMove:
      return verdict_of(axis_.move_to(from_units(request.target)));
    case Mode::kHome:
      return verdict_of(axis_.home());
    case Mode::kCancel:
      axis_.cancel_homing();
      break;
    case Mode::kStop:
      if (axis_.status().homing) axis_.cancel_homing();
      axis_.stop();
      break;
    case Mode::kEmergencyStop:
      axis_.emergency_stop();
      break;
    case Mode::kRelease:
      axis_.release_emergency_stop();
      break;
    case Mode::kClearFaults:
      axis_.clear_faults();
      break;
    case Mode::kSelfTest:
      axis_.self_test();
      break;
    case Mode::kReadSetup: {
      const auto value = word(request.velocity);
      word_.reset();
      if (!value) return Verdict::kOutOfLimits;
      word_ = SetupWord{*value, static_cast<std::uint16_t>(request.velocity)};
      break;
    }
    case Mode::kWriteSetup:
    case Mode::kStoreSetup:
      return write_setup(request);
  }
  return Verdict::kAccepted;
}

/// Of the setup, and behind it of the image.
std::optional<std::uint32_t> AxisLinkNode::word(std::int32_t index) const {
  constexpr auto kFirst = static_cast<std::int32_t>(kImageWord);
  if (index < 0) return std::nullopt;
  if (index < kFirst) {
    return setup_ != nullptr ? setup_->word(static_cast<std::size_t>(index)) : std::nullopt;
  }
  const auto place = static_cast<std::size_t>(index - kFirst);
  if (!settings_.image || place >= kImageIdentityWords) return std::nullopt;
  return little_word(encode_identity(*settings_.image), place);
}

Verdict AxisLinkNode::write_setup(const Request& request) {
  const AxisStatus status = axis_.status();
  if (under_way(status) || restart_at_) return Verdict::kBusy;
  // The start with a new setup would take the latch back.
  if (status.emergency_stopped) return Verdict::kEmergencyStopped;
  if (setup_ == nullptr || request.velocity < 0) return Verdict::kOutOfLimits;
  if (request.mode == Mode::kWriteSetup) {
    const bool kept = setup_->set_word(static_cast<std::size_t>(request.velocity),
                                       std::bit_cast<std::uint32_t>(request.target));
    return kept ? Verdict::kAccepted : Verdict::kOutOfLimits;
  }
  if (!setup_->store()) return Verdict::kOutOfLimits;
  restart_at_ = now_ + kRestartDelay;
  return Verdict::kAccepted;
}

void AxisLinkNode::close_session() {
  session_ = 0;
  verdict_ = Verdict::kNoSession;
  // Between two setpoints an axis may stand for a moment; the stream is no less broken off.
  if (asked_ != Mode::kTrack && !under_way(axis_.status())) return;
  axis_.cancel_homing();
  axis_.stop(AxisFault::kLinkSilent);
}

void AxisLinkNode::prepare() {
  Reply reply{.axis = settings_.model.axis, .session = session_, .sequence = executed_, .body = {}};
  if (asked_ == Mode::kHello) {
    reply.body =
        Identity{hash_, settings_.boot,
                 saturated<std::uint16_t>(settings_.uncertainty * kUncertaintyUnits + 0.5)};
  } else if (asked_ == Mode::kReadHealth) {
    reply.body = health();
  } else if (asked_ == Mode::kReadSetup && word_) {
    reply.body = *word_;
  } else {
    reply.body = state();
  }
  prepared_ = encode(reply);
}

State AxisLinkNode::state() const {
  const AxisStatus status = axis_.status();
  const auto position = to_units(status.q);
  return {.position = position.value_or(0),
          .velocity = saturated<std::int16_t>(status.qd * kStateVelocityUnits),
          .motor_ok = status.motor_ok,
          .sensor_ok = status.sensor_ok,
          .communication_ok = status.communication_ok,
          // A position that the frame cannot hold is not told as another one.
          .position_ok = status.position_ok && position.has_value(),
          .homed = status.homed,
          .homing = status.homing,
          .moving = status.moving,
          .end_stop = status.end_stop,
          .emergency_stopped = status.emergency_stopped,
          .fault = static_cast<std::uint8_t>(status.fault),
          .verdict = verdict_};
}

Health AxisLinkNode::health() const {
  const AxisStatus status = axis_.status();
  Health health;
  if (status.supply_volts) {
    // One below FFFF, which means that nothing was measured.
    health.supply_mv = static_cast<std::uint16_t>(
        std::min<unsigned>(saturated<std::uint16_t>(*status.supply_volts * 1e3), 0xFFFE));
  }
  if (status.temperature_c) {
    health.temperature_c01 = saturated<std::int16_t>(*status.temperature_c * 1e2);
  }
  health.motor_magnet = status.motor_magnet;
  health.joint_magnet = status.joint_magnet;
  return health;
}

}  // namespace sinew
