#include <algorithm>
#include <cmath>

#include "sinew/core/assert.h"
#include "sinew/devices/lsc/lsc_driver.h"
#include "sinew/devices/lsc/lsc_settings.h"

namespace sinew {

using namespace lsc;
using Kind = DriverEvent::Kind;

namespace {

constexpr Duration kTimeMin = std::chrono::milliseconds(20);  // the boards' own tick
constexpr std::uint16_t kTimeMax = 65535;                     // ms
constexpr std::uint16_t kEsp32TimeMax = 30'000;               // ms
/// Of a rest frame: over before the next one. Nobody expects an arm at rest to move, so what such a
/// frame mends, or breaks where it is damaged itself, must not go at full servo speed.
constexpr Duration kRestTime = std::chrono::milliseconds(900);
constexpr int kConfirms = 2;     // one fault spoils two frames in a row at most
constexpr int kRewrites = 2;     // esp32: confirmed again where it says something else
constexpr int kReadingsMax = 8;  // until two in a row agree

std::uint8_t bit(std::size_t slot) {
  return static_cast<std::uint8_t>(1U << slot);
}

std::uint16_t to_ms(Duration time) {
  const double ms = std::round(to_seconds(time) * 1e3);
  return static_cast<std::uint16_t>(std::clamp(ms, 0.0, double{kTimeMax}));
}

}  // namespace

// Motion

Duration LscDriver::byte_time() const {
  return from_seconds(10.0 / timing_.baud);
}

Duration LscDriver::frame_time(std::uint8_t also) const {
  int servos = 0;
  for (std::size_t i = 0; i < units_.slots(); ++i) {
    servos += slots_[i].held || (also & bit(i)) != 0 ? 1 : 0;
  }
  return byte_time() * (7 + 3 * servos);
}

double LscDriver::at(const Slot& slot, Instant time) const {
  const double whole = to_seconds(current_.end - current_.start);
  if (whole <= 0 || time >= current_.end) return slot.to;
  const double part = std::clamp(to_seconds(time - current_.start) / whole, 0.0, 1.0);
  return slot.from + (slot.to - slot.from) * part;
}

/// From rest. A question that is just leaving goes first.
void LscDriver::begin(const Segment& segment, Instant now) {
  drop_targets();
  goes_on_until_.reset();
  next_ = segment;
  next_->first = true;
  current_.start = current_.end = now;
  rewrites_left_ = kRewrites;
  tries_left_ = timing_.tries;
  phase_ = Phase::kRunning;
  poll_running(now);
  refresh(now);
}

/// Sends the frame of `segment`, which takes over at `end` of the last one or when it arrives,
/// whichever is later.
void LscDriver::send_segment(Segment& segment, Instant now, Instant end) {
  const Instant arrival = std::max(now, wire_free_) + frame_time(segment.mask);
  segment.start = arrival;
  segment.end = std::max(arrival, end) + segment.duration;
  send_targets(segment, now, segment.end - arrival);
  segment.sent = true;
}

void LscDriver::send_targets(const Segment& segment, Instant now, Duration time) {
  Move frame;
  const std::uint16_t longest = profile_ == LscProfile::kEsp32 ? kEsp32TimeMax : kTimeMax;
  frame.time_ms = std::min(to_ms(time), longest);
  for (std::size_t i = 0; i < units_.slots(); ++i) {
    const bool moves = (segment.mask & bit(i)) != 0;
    if (!moves && !slots_[i].held) continue;
    const auto held = static_cast<std::uint16_t>(std::lround(slots_[i].to));
    slots_[i].told = told(i, moves ? segment.to[i] : held);
    frame.servos.push_back({units_.id(i), slots_[i].told});
  }
  facts_.told = {frame, now};
  send(frame, now);
}

/// The units that bring a servo to `to`. One that stays where it was measured gets again what keeps
/// it there.
std::uint16_t LscDriver::told(std::size_t slot, std::uint16_t to) const {
  const Slot& servo = slots_[slot];
  if (slot >= units_.joints() || servo.sag == 0 || to != servo.rest) return to;
  return units_.beside(slot, to, -servo.sag);
}

void LscDriver::measure_sag(std::size_t joint, double there) {
  Slot& slot = slots_[joint];
  const double most = kServoSlack / units_.resolution(joint);
  const double off = there - slot.told;
  slot.rest = there;
  // More than a weight does: something is in its way.
  slot.sag = slot.held && std::abs(off) <= most ? off : 0;
}

/// False where what waits to leave is no frame of targets, or has begun to leave.
bool LscDriver::drop_targets() {
  if (output_.empty() || output_begun_ || !output_moves_) return false;
  wire_free_ -= byte_time() * static_cast<int>(output_.size());
  output_.clear();
  return true;
}

/// Behind a sign of life at rest, where the board cannot be asked what it has understood.
void LscDriver::say_rest(Instant now) {
  if (profile_ != LscProfile::kLsc6 || phase_ != Phase::kIdle || !output_.empty() || lost()) return;
  const bool held =
      std::any_of(slots_.begin(), slots_.end(), [](const Slot& slot) { return slot.held; });
  if (held) send_targets({}, now, kRestTime);
}

/// The segment that was sent is the one that the board now carries out.
void LscDriver::promote() {
  const Segment next = *next_;
  for (std::size_t i = 0; i < units_.slots(); ++i) {
    Slot& slot = slots_[i];
    const bool moves = (next.mask & bit(i)) != 0;
    if (!moves && !slot.held) continue;
    slot.from = slot.known ? at(slot, next.start) : slot.to;
    if (moves) slot.to = next.to[i];
    if (moves && !slot.known) slot.from = slot.lower = slot.upper = slot.to;
    slot.held = true;
    slot.lower = std::min({slot.lower, slot.from, slot.to});
    slot.upper = std::max({slot.upper, slot.from, slot.to});
  }
  current_ = next;
  next_.reset();
}

void LscDriver::poll_running(Instant now) {
  if (stop_due_) send_stop(now);
  if (next_ && !next_->sent && output_.empty() && now >= current_.end - frame_time()) {
    send_segment(*next_, now, current_.end);
    if (next_->first) {
      promote();
      // Jaws alone leave the joints as they are.
      if ((current_.mask & bit(0)) != 0) free_ = false;
      repair_at_ = current_.start + timing_.segment_max;
    }
  }
  if (next_ && next_->sent && now >= next_->start) {
    promote();
    tell(Kind::kDone);
    --pending_;
  }
  if (stop_due_ || next_) return;
  if (now >= current_.end) {
    phase_ = Phase::kConfirming;
    confirms_left_ = kConfirms;
    phase_due_ = now;
  } else if (now >= repair_at_ && output_.empty()) {
    // A long move is said again and again: a damaged frame counts for 100 ms, not for all of it.
    repair_at_ = now + timing_.segment_max;
    const Instant arrival = std::max(now, wire_free_) + frame_time();
    if (current_.end - arrival < kTimeMin) return;
    ++health_.repeats;
    send_targets(current_, now, current_.end - arrival);
  }
}

void LscDriver::poll_confirming(Instant now) {
  if (now < phase_due_ || !output_.empty()) return;
  if (confirms_left_ > 0) {
    --confirms_left_;
    ++health_.repeats;
    send_targets(current_, now, creeping_ ? std::chrono::milliseconds(kTimeMax) : kTimeMin);
    phase_due_ = wire_free_ + kTimeMin;
    return;
  }
  after_confirming(now);
}

void LscDriver::after_confirming(Instant now) {
  if (creeping_) {
    goes_on_until_ = now + std::chrono::milliseconds(kTimeMax);
    for (std::size_t i = 0; i < units_.slots(); ++i) {
      if (!slots_[i].held || slots_[i].known) continue;
      slots_[i] = {};
      if (i < units_.joints()) positions_[i] = {};
    }
    return finish(now);
  }
  const bool was_lost = lost();
  for (std::size_t i = 0; i < units_.slots(); ++i) {
    Slot& slot = slots_[i];
    if (!slot.held) continue;
    slot.known = true;
    slot.from = slot.lower = slot.upper = slot.to;
  }
  if (profile_ != LscProfile::kLsc6) {
    phase_ = profile_ == LscProfile::kBus ? Phase::kSettling : Phase::kReading;
    phase_due_ = now + timing_.settle;
    reading_.reset();
    readings_left_ = kReadingsMax;
    return;
  }
  const bool arm = (current_.mask & bit(0)) != 0;
  for (JointPosition& joint : positions_) {
    // A first move that was stopped half-way has not brought the arm anywhere.
    if (arm && !(was_lost && stopping_)) joint.quality = PositionQuality::kCommanded;
  }
  finish(now);
}

void LscDriver::finish(Instant now) {
  phase_ = Phase::kIdle;
  const Kind kind = stopping_ ? Kind::kStopped : Kind::kDone;
  end_all(kind);
  refresh(now);
}

void LscDriver::stop(Instant now) {
  poll(now);
  if (stopping_) return;
  if (pending_ == 0) return tell(Kind::kStopped);
  stopping_ = true;
  if (next_ && next_->first) return finish(now);  // nothing of it has left
  if (next_ && next_->sent && drop_targets()) next_.reset();
  if (next_ && !next_->sent) next_.reset();
  stop_due_ = phase_ == Phase::kRunning;
  if (stop_due_) send_stop(now);
}

/// As soon as no byte is left to be taken: the place where the servos will be when the frame has
/// arrived becomes their target.
void LscDriver::send_stop(Instant now) {
  if (!output_.empty()) return;
  const Instant arrival = std::max(now, wire_free_) + frame_time();
  if (next_ && arrival >= next_->start) promote();
  if (next_) return;
  stop_due_ = false;
  current_.rest = true;
  if (arrival >= current_.end) {
    // They stand before a frame is through: what says where ends the motion.
    phase_ = Phase::kConfirming;
    confirms_left_ = kConfirms;
    phase_due_ = now;
    return poll_confirming(now);
  }
  const bool known = std::all_of(slots_.begin(), slots_.end(),
                                 [](const Slot& slot) { return !slot.held || slot.known; });
  if (!known) {
    // A first move that is as good as over shall not become one of a minute.
    if (current_.end - arrival <= kTimeMin) return;
    creeping_ = true;
    phase_ = Phase::kConfirming;
    confirms_left_ = kConfirms + 1;
    phase_due_ = now;
    return poll_confirming(now);
  }
  Segment halt;
  for (std::size_t i = 0; i < units_.slots(); ++i) {
    if (!slots_[i].held) continue;
    const double place = at(slots_[i], arrival);
    halt.to[i] = static_cast<std::uint16_t>(std::lround(place));
    halt.mask |= bit(i);
  }
  halt.duration = kTimeMin;
  next_ = halt;
  send_segment(*next_, now, now);
  promote();
}

Duration LscDevice::tool_time(const RobotModel& robot, const ToolAction& action,
                              std::optional<double> jaws) const {
  const auto* geometry = std::get_if<SerialGeometry>(&robot.geometry);
  const auto* to = std::get_if<JawsTo>(&action);
  if (to == nullptr || geometry == nullptr || !geometry->gripper) return {};
  const LscTiming timing;
  const Duration report = motion_delay().report;
  const bool blind = profile == LscProfile::kLsc6;
  if (!jaws && blind) return timing.first_move_min + report;
  // A board that can be asked knows where they are; the planner does not.
  const double share = jaws_share(*geometry->gripper, to->width, jaws);
  return std::max(timing.segment_max, from_seconds(share * to_seconds(timing.jaws_stroke))) +
         report;
}

}  // namespace sinew
