#include "sinew/devices/lsc/lsc_driver.h"

#include <algorithm>
#include <cmath>

#include "sinew/core/assert.h"
#include "sinew/core/error_code.h"

namespace sinew {

using namespace lsc;
using Kind = DriverEvent::Kind;

namespace {

constexpr Duration kTimeMin = std::chrono::milliseconds(20);  // the boards' own tick
constexpr int kOpeningReadings = 60;  // 2 s: a limp arm sinks until something holds it
constexpr Duration kBlockedPause = std::chrono::milliseconds(1);
constexpr double kSpeedSlack = 1.1;  // planners round their times
constexpr int kUnloads = 2;
constexpr Duration kHandOld = std::chrono::milliseconds(400);
constexpr Duration kHandPeriod = std::chrono::milliseconds(50);
constexpr double kHandLate = 0.04;        // s between a servo's reading and its last byte
constexpr double kHandAcceleration = 60;  // rad/s^2, of a joint that is led, or falls

std::uint8_t bit(std::size_t slot) {
  return static_cast<std::uint8_t>(1U << slot);
}

}  // namespace

LscDriver::LscDriver(const LscDevice& device, std::span<const Joint> joints,
                     const std::optional<JawGripper>& gripper, const LscTiming& timing)
    : profile_(device.profile), units_(device, joints, gripper), timing_(timing) {
  SINEW_ASSERT(timing.baud > 0 && timing.tries > 0 && timing.quiet > Duration::zero());
  SINEW_ASSERT(timing.segment_min >= kTimeMin && timing.segment_max >= timing.segment_min);
  positions_.resize(units_.joints());
}

// Opening and closing

void LscDriver::open(Instant now) {
  now_ = std::max(now_, now);
  if (phase_ != Phase::kClosed) close(now_);
  // What was known of a board that cannot be asked is worth nothing once nobody has listened.
  if (!declared_) lose_positions();
  declared_ = false;
  fault_.reset();
  told_silent_ = false;
  stopping_ = false;
  low_readings_ = empty_readings_ = 0;
  kind_silences_ = 0;
  output_.clear();
  wire_free_ = now_;
  question_ = Question::kNone;
  decoder_.reset();
  phase_ = Phase::kQuiet;
  quiet_since_ = now_;
  phase_due_ = now_ + timing_.quiet;
}

void LscDriver::close(Instant now) {
  now_ = std::max(now_, now);
  if (phase_ == Phase::kClosed) return;
  refresh(now_);
  const bool moving = pending_ > 0;
  for (std::size_t i = 0; moving && i < units_.joints(); ++i) {
    JointPosition& joint = positions_[i];
    if (joint.quality == PositionQuality::kLost) continue;
    const double a = units_.q_of(i, slots_[i].lower);
    const double b = units_.q_of(i, slots_[i].upper);
    joint.quality = PositionQuality::kUncertain;
    joint.lower = std::min(a, b) - kServoSlack;
    joint.upper = std::max(a, b) + kServoSlack;
  }
  admit_motion();
  end_all(Kind::kFailed, {ErrorCode::kPortClosed});
  phase_ = Phase::kClosed;
  question_ = Question::kNone;
  output_.clear();
}

void LscDriver::poll_opening(Instant now) {
  if (phase_ != Phase::kQuiet || now < phase_due_ || !output_.empty()) return;
  decoder_.reset();
  // Nothing says whether a group runs; stopping none is harmless.
  send(StopGroup{}, now);
  phase_ = Phase::kAsking;
  reading_.reset();
  readings_left_ = kOpeningReadings;
  tries_left_ = timing_.tries;
  health_due_ = wire_free_;
}

void LscDriver::become_ready(Instant now) {
  phase_ = Phase::kIdle;
  told_silent_ = false;
  health_due_ = now + timing_.health_period;
  tell(Kind::kReady);
}

void LscDriver::doubt(const Error& error, Instant now) {
  const bool opening = phase_ == Phase::kQuiet || phase_ == Phase::kAsking;
  if (pending_ > 0) {
    end_all(Kind::kFailed, error);
  } else if (!told_silent_) {
    tell(opening ? Kind::kFailed : Kind::kNotice, error);
  }
  told_silent_ = true;
  admit_motion();
  lose_positions();
  // Half a frame would swallow the next one, so what has begun to leave leaves.
  if (!output_begun_) output_.clear();
  question_ = Question::kNone;
  phase_ = Phase::kQuiet;
  quiet_since_ = now;
  phase_due_ = now + timing_.quiet;
}

void LscDriver::enter_fault(const Error& error) {
  if (pending_ > 0) {
    end_all(Kind::kFailed, error);
  } else {
    tell(Kind::kFailed, error);
  }
  fault_ = error;
  admit_motion();
  lose_positions();
  if (!output_begun_) output_.clear();
  phase_ = Phase::kFault;
}

/// What is left without an end goes on by itself.
void LscDriver::admit_motion() {
  const bool runs = phase_ == Phase::kRunning || phase_ == Phase::kConfirming;
  if (runs && current_.end > now_) goes_on_until_ = current_.end;
}

void LscDriver::lose_positions() {
  for (Slot& slot : slots_) slot = {};
  for (JointPosition& joint : positions_) joint = {};
  next_.reset();
}

void LscDriver::end_all(Kind kind, const Error& error) {
  for (; pending_ > 0; --pending_) tell(kind, error);
  next_.reset();
  stopping_ = stop_due_ = creeping_ = false;
}

// What is asked for

DriverState LscDriver::state() const {
  switch (phase_) {
    case Phase::kClosed:
      return DriverState::kClosed;
    case Phase::kQuiet:
    case Phase::kAsking:
      return DriverState::kOpening;
    case Phase::kIdle:
      return DriverState::kReady;
    case Phase::kFault:
      return DriverState::kFault;
    default:
      return stopping_ ? DriverState::kStopping : DriverState::kMoving;
  }
}

std::span<const JointPosition> LscDriver::positions() const {
  return {positions_.data(), positions_.size()};
}

bool LscDriver::lost() const {
  return std::any_of(positions_.begin(), positions_.end(), [](const JointPosition& joint) {
    return joint.quality == PositionQuality::kLost || joint.quality == PositionQuality::kUncertain;
  });
}

SendRange LscDriver::range_of(std::size_t joint) const {
  return units_.range_from(joint, positions_[joint]);
}

/// Some joint is beyond its limits; a way that a model takes for blocked is gone slowly then.
bool LscDriver::outside() const {
  for (std::size_t i = 0; i < units_.joints(); ++i) {
    if (!units_.inside(i, positions_[i].q)) return true;
  }
  return false;
}

bool LscDriver::wants_move(Instant now) const {
  if (phase_ == Phase::kIdle) return true;
  if (stopping_ || current_.rest || next_) return false;
  if (phase_ == Phase::kConfirming) return output_.empty();
  return phase_ == Phase::kRunning && now >= current_.end - frame_time() - timing_.lead;
}

Expected<void> LscDriver::may_begin() const {
  if (phase_ == Phase::kClosed) return std::unexpected(Error{ErrorCode::kPortClosed});
  if (phase_ == Phase::kFault) return std::unexpected(*fault_);
  if (phase_ == Phase::kIdle) return {};
  return std::unexpected(Error{ErrorCode::kBusy});
}

Expected<void> LscDriver::check_start(const JointMove& move) const {
  for (std::size_t i = 0; i < move.q_start.size(); ++i) {
    const JointPosition& here = positions_[i];
    const bool elsewhere = here.quality == PositionQuality::kMeasured &&
                           std::abs(here.q - move.q_start[i]) > timing_.measured_tolerance;
    if (!elsewhere) continue;
    return std::unexpected(
        Error{ErrorCode::kMovedUnasked, static_cast<std::int8_t>(i), here.q, move.q_start[i]});
  }
  return {};
}

Expected<void> LscDriver::check_time(const Segment& segment, const JointMove& move) const {
  const double time = to_seconds(move.duration);
  for (std::size_t i = 0; i < units_.joints(); ++i) {
    const PositionQuality quality = positions_[i].quality;
    const bool known =
        quality == PositionQuality::kCommanded || quality == PositionQuality::kMeasured;
    if (known || move.duration >= timing_.first_move_min) continue;
    return std::unexpected(Error{ErrorCode::kPositionUnknown, static_cast<std::int8_t>(i), time,
                                 to_seconds(timing_.first_move_min)});
  }
  const Duration shortest = std::max(timing_.segment_min, frame_time(segment.mask));
  const Duration longest = lost() || outside() ? timing_.first_move_max : timing_.segment_max;
  if (move.duration < shortest || move.duration > longest) {
    const Duration limit = move.duration < shortest ? shortest : longest;
    return std::unexpected(Error{ErrorCode::kSegmentTime, -1, time, to_seconds(limit)});
  }
  for (std::size_t i = 0; !lost() && i < units_.joints(); ++i) {
    // From where the segment before ends; a unit more or less is rounding.
    const double from = slots_[i].to;
    const double way = std::max(0.0, std::abs(segment.to[i] - from) - 1);
    const double least = way / units_.speed_max(i);
    if (least <= time * kSpeedSlack) continue;
    return std::unexpected(
        Error{ErrorCode::kSegmentTime, static_cast<std::int8_t>(i), time, least});
  }
  return {};
}

Expected<void> LscDriver::move(const JointMove& move, Instant now) {
  SINEW_ASSERT(move.q.size() == units_.joints());
  poll(now);
  const bool follows = !stopping_ && !current_.rest && !next_ &&
                       (phase_ == Phase::kRunning || phase_ == Phase::kConfirming);
  if (!follows) {
    if (const auto may = may_begin(); !may) return may;
    if (const auto start = check_start(move); !start) return start;
  }
  Segment segment;
  for (std::size_t i = 0; i < units_.joints(); ++i) {
    const auto units = units_.of_joint(i, move.q[i], range_of(i));
    if (!units) return std::unexpected(units.error());
    segment.to[i] = *units;
    segment.mask |= bit(i);
  }
  if (const auto checked = check_time(segment, move); !checked) return checked;
  segment.duration = move.duration;
  segment.rest = lost() || std::all_of(move.qd.begin(), move.qd.end(),
                                       [](double speed) { return speed == 0; });
  ++health_.requests;
  ++pending_;
  if (!follows) {
    begin(segment, now);
    return {};
  }
  if (phase_ == Phase::kConfirming) {
    // An underrun: the arm stands at the end of the segment before, and need not be told again.
    drop_targets();
    phase_ = Phase::kRunning;
  }
  next_ = segment;
  poll(now);
  return {};
}

Expected<void> LscDriver::tool(const ToolAction& action, Instant now) {
  poll(now);
  const auto* to = std::get_if<JawsTo>(&action);
  const auto jaws = units_.jaws();
  if (to == nullptr || !jaws) return std::unexpected(Error{ErrorCode::kToolNotFitted});
  const auto units = units_.of_width(to->width);
  if (!units) return std::unexpected(units.error());
  if (const auto may = may_begin(); !may) return may;
  const Slot& slot = slots_[*jaws];
  Segment segment;
  segment.to[*jaws] = *units;
  segment.mask = bit(*jaws);
  segment.duration = timing_.first_move_min;
  if (slot.known) {
    const double part = std::abs(*units - slot.to) / units_.stroke();
    segment.duration =
        std::max(timing_.segment_max, from_seconds(part * to_seconds(timing_.jaws_stroke)));
  }
  ++health_.requests;
  ++pending_;
  health_.jaws_width.reset();
  begin(segment, now);
  return {};
}

/// Bus servos let go of their joints, and are read as they are led.
Expected<void> LscDriver::service(DeviceService what, Instant now) {
  poll(now);
  const bool frees = what == DeviceService::kFree;
  const bool known = frees || what == DeviceService::kHold;
  if (profile_ != LscProfile::kBus || !known) {
    return std::unexpected(Error{ErrorCode::kNoSuchService});
  }
  if (const auto may = may_begin(); !may) return may;
  if (!frees && free_ && now_ - hand_at_ > kHandOld) {
    return std::unexpected(Error{ErrorCode::kPositionUnknown, 0});
  }
  ++health_.requests;
  ++pending_;
  if (frees) {
    free_ = true;
    unloads_left_ = kUnloads;
    hand_speed_.fill(0);
    for (std::size_t i = 0; i < units_.joints(); ++i) slots_[i].held = false;
    poll_free(now_);
    return {};
  }
  Segment here;
  for (std::size_t i = 0; i < units_.joints(); ++i) {
    here.to[i] = static_cast<std::uint16_t>(std::lround(slots_[i].to));
    here.mask |= bit(i);
  }
  here.duration = timing_.segment_max;
  begin(here, now_);
  return {};
}

/// Said more than once: nothing tells whether it was heard.
void LscDriver::poll_free(Instant now) {
  if (!free_ || phase_ != Phase::kIdle || !output_.empty() || question_ != Question::kNone) return;
  if (unloads_left_ > 0) {
    --unloads_left_;
    ServoIds ids;
    for (std::size_t i = 0; i < units_.joints(); ++i) ids.push_back(units_.id(i));
    return send(Unload{ids}, now);
  }
  if (pending_ > 0) end_all(Kind::kDone);
  if (now >= hand_due_) {
    hand_due_ = now + kHandPeriod;
    ask(Question::kPositions, now);
  }
}

/// As a hand, or its weight, has the arm now.
void LscDriver::follow_hand(const Units& units, Instant now) {
  const double age = std::max(1e-3, to_seconds(now - hand_at_));
  for (std::size_t i = 0; i < units_.joints(); ++i) {
    const double there = units[i];
    const bool fresh = positions_[i].quality == PositionQuality::kMeasured && hand_at_ > Instant{};
    hand_speed_[i] = fresh ? std::abs(there - slots_[i].to) * units_.resolution(i) / age : 0;
    slots_[i] = {false, true, there, there, there, there};
    positions_[i].quality = PositionQuality::kMeasured;
  }
  hand_at_ = now;
}

void LscDriver::declare_positions(std::span<const JointPosition> positions) {
  SINEW_ASSERT(positions.size() == units_.joints());
  if (profile_ != LscProfile::kLsc6 || pending_ > 0 || phase_ == Phase::kFault) return;
  for (std::size_t i = 0; i < positions.size(); ++i) {
    JointPosition joint = positions[i];
    slots_[i] = {};
    const bool told =
        joint.quality == PositionQuality::kCommanded || joint.quality == PositionQuality::kMeasured;
    if (told) {
      // On record it may stand beyond a limit.
      const auto units = units_.of_joint(i, joint.q, units_.range_from(i, joint));
      joint = {};
      if (units) {
        joint.quality = PositionQuality::kCommanded;
        const double at_rest = *units;
        slots_[i] = {false, true, at_rest, at_rest, at_rest, at_rest};
      }
    }
    positions_[i] = joint;
  }
  declared_ = phase_ == Phase::kClosed;
  refresh(now_);
}

Expected<void> LscDriver::clear_fault(Instant now) {
  poll(now);
  if (phase_ != Phase::kFault) {
    if (pending_ > 0) return std::unexpected(Error{ErrorCode::kBusy});
    return {};
  }
  const bool fresh = now - volts_at_ <= 2 * timing_.health_period;
  const bool of_supply = fault_->code == ErrorCode::kSupplyLow;
  if (of_supply && (!fresh || empty_readings_ > 0)) return std::unexpected(*fault_);
  kind_silences_ = 0;
  fault_.reset();
  told_silent_ = false;
  question_ = Question::kNone;
  phase_ = Phase::kQuiet;
  quiet_since_ = now;
  phase_due_ = now + timing_.quiet;
  return {};
}

// Time and bytes

void LscDriver::poll(Instant now) {
  now_ = std::max(now_, now);
  if (phase_ == Phase::kClosed) return;
  if (!output_.empty() && now_ - output_since_ > timing_.output_timeout) {
    output_begun_ = false;
    doubt({ErrorCode::kDeviceSilent, -1, to_seconds(now_ - output_since_),
           to_seconds(timing_.output_timeout)},
          now_);
  }
  poll_question(now_);
  poll_opening(now_);
  if (phase_ == Phase::kRunning) poll_running(now_);
  if (phase_ == Phase::kConfirming) poll_confirming(now_);
  poll_free(now_);
  poll_health(now_);
  refresh(now_);
}

std::optional<Instant> LscDriver::next_deadline() const {
  if (phase_ == Phase::kClosed) return std::nullopt;
  Instant due = Instant::max();
  const auto at_least = [&](Instant instant) { due = std::min(due, instant); };
  if (question_ != Question::kNone) at_least(question_due_);
  if (phase_ == Phase::kQuiet || phase_ == Phase::kConfirming || phase_ == Phase::kSettling) {
    at_least(phase_due_);
  } else if (question_ == Question::kNone) {
    at_least(phase_ == Phase::kReading ? now_ : health_due_);
  }
  if (phase_ == Phase::kRunning) {
    at_least(current_.end);
    if (stop_due_) at_least(now_);
    if (next_) at_least(next_->sent ? next_->start : current_.end - frame_time());
    if (!next_) at_least(repair_at_);
  }
  if (free_ && phase_ == Phase::kIdle) at_least(unloads_left_ > 0 ? wire_free_ : hand_due_);
  if (!output_.empty()) at_least(output_since_ + timing_.output_timeout);
  // What is due and has to wait for something is looked at again soon.
  return due > now_ ? due : now_ + kBlockedPause;
}

void LscDriver::refresh(Instant now) {
  for (std::size_t i = 0; i < units_.joints(); ++i) {
    JointPosition& joint = positions_[i];
    const bool told =
        joint.quality == PositionQuality::kCommanded || joint.quality == PositionQuality::kMeasured;
    if (!told) continue;
    const bool runs = phase_ == Phase::kRunning || phase_ == Phase::kConfirming;
    const bool limp = free_ && !slots_[i].held;
    if (runs && !limp) joint.quality = PositionQuality::kCommanded;
    joint.q = units_.q_of(i, runs && !limp ? at(slots_[i], now) : slots_[i].to);
    // A servo that was told is where it was told only as well as it can be.
    double slack = joint.quality == PositionQuality::kCommanded ? kServoSlack : 0;
    if (limp) {
      const double age = to_seconds(now - hand_at_) + kHandLate;
      slack += age * (hand_speed_[i] + age * kHandAcceleration);
    }
    joint.lower = joint.q - units_.resolution(i) / 2 - slack;
    joint.upper = joint.q + units_.resolution(i) / 2 + slack;
  }
}

void LscDriver::send(const Request& request, Instant now) {
  SINEW_ASSERT(output_.empty());
  output_ = encode(request);
  output_begun_ = false;
  output_moves_ = std::holds_alternative<Move>(request);
  output_since_ = now;
  wire_free_ = std::max(now, wire_free_) + byte_time() * static_cast<int>(output_.size());
}

std::size_t LscDriver::take_output(std::span<std::uint8_t> out) {
  const std::size_t count = output_.take_front(out);
  output_begun_ = !output_.empty() && (output_begun_ || count > 0);
  return count;
}

std::optional<DriverEvent> LscDriver::take_event() {
  return events_.take_front();
}

void LscDriver::tell(Kind kind, const Error& error) {
  // Whoever does not listen may miss a notice, never the end of a command.
  if (kind == Kind::kNotice && events_.size() + 4 > events_.capacity()) return;
  SINEW_ASSERT(!events_.full());
  events_.push_back({kind, error});
}

}  // namespace sinew
