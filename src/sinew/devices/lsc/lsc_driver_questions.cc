#include <algorithm>
#include <cmath>
#include <string_view>
#include <utility>

#include "sinew/core/assert.h"
#include "sinew/core/error_code.h"
#include "sinew/devices/lsc/lsc_driver.h"
#include "sinew/devices/lsc/lsc_settings.h"

namespace sinew {

using namespace lsc;
using Kind = DriverEvent::Kind;

namespace {

constexpr int kConfirms = 2;  // one fault spoils two frames in a row at most
constexpr Duration kQuestionRoom = std::chrono::milliseconds(8);  // a question's time, with margin
constexpr double kBootUnits = 1500;
constexpr double kMeasuredAgree = 4;  // units between two readings of a servo that stands
constexpr double kVoltsPlausible = 30;
// Units at which a servo can stand. A bus servo that was turned by hand may be a little beyond what
// it can be sent to; nothing else is.
constexpr std::uint16_t kMeasuredMax = 1200;
constexpr std::uint16_t kCommandedMax = 2500;
/// One lost byte spoils two questions in a row; that must not make a bus board pass for a classic
/// one.
constexpr int kKindSilences = 3;
constexpr std::string_view kBootText = "begin";  // the ESP32's last words before it listens

std::uint8_t bit(std::size_t slot) {
  return static_cast<std::uint8_t>(1U << slot);
}

}  // namespace

// Questions and answers

void LscDriver::ask(Question question, Instant now) {
  ServoIds ids;
  for (std::size_t i = 0; i < units_.slots(); ++i) ids.push_back(units_.id(i));
  switch (question) {
    case Question::kBattery:
      send(ReadBattery{}, now);
      break;
    case Question::kVersion:
      send(ReadVersion{}, now);
      break;
    case Question::kPositions:
      send(profile_ == LscProfile::kBus ? Request{ReadPositions{ids}} : Request{ReadCommanded{}},
           now);
      break;
    case Question::kKind:
      // The base's servo alone: a flipped bit makes "go limp" of it, and a base does not fall.
      send(ReadPositions{{units_.id(0)}}, now);
      break;
    case Question::kNone:
      return;
  }
  question_ = question;
  // A list of positions takes its own time to come back.
  question_due_ = wire_free_ + byte_time() * kFrameMax + timing_.reply_timeout;
  ++health_.requests;
}

void LscDriver::poll_health(Instant now) {
  if (question_ != Question::kNone || !output_.empty()) return;
  const Question life = profile_ == LscProfile::kEsp32 ? Question::kVersion : Question::kBattery;
  if (phase_ == Phase::kSettling && now >= phase_due_) phase_ = Phase::kReading;
  if (phase_ == Phase::kReading) return ask(Question::kPositions, now);
  if (phase_ == Phase::kQuiet || phase_ == Phase::kClosed || now < health_due_) return;
  // A question must never make a segment late.
  if (phase_ == Phase::kRunning && now + kQuestionRoom > current_.end - frame_time()) return;
  if (phase_ != Phase::kAsking) health_due_ = now + timing_.health_period;
  if (phase_ == Phase::kAsking && reading_) {
    return ask(profile_ == LscProfile::kLsc6 ? Question::kKind : Question::kPositions, now);
  }
  ask(life, now);
}

void LscDriver::poll_question(Instant now) {
  if (question_ == Question::kNone || now < question_due_) return;
  const bool of_kind = std::exchange(question_, Question::kNone) == Question::kKind;
  decoder_.reset();
  if (of_kind) {
    // As a board without readings does.
    if (++kind_silences_ >= kKindSilences) become_ready(now);
    return;
  }
  ++health_.timeouts;
  if (phase_ == Phase::kFault) return;
  if (--tries_left_ <= 0) {
    const double waited = to_seconds(timing_.reply_timeout) * timing_.tries;
    return doubt({ErrorCode::kDeviceSilent, -1, waited, waited}, now);
  }
  ++health_.retries;
  if (phase_ == Phase::kReading) {
    // The ESP32 takes a damaged question for "go home"; the targets say where to stay.
    phase_ = Phase::kConfirming;
    confirms_left_ = 1;
    phase_due_ = now;
    return;
  }
  health_due_ = now;
}

void LscDriver::receive(std::span<const std::uint8_t> bytes, Instant now) {
  poll(now);
  for (const std::uint8_t byte : bytes) {
    if (phase_ == Phase::kClosed) return;
    if (phase_ == Phase::kQuiet) {
      ++health_.unexpected;
      if (now - quiet_since_ < timing_.quiet_limit) phase_due_ = now + timing_.quiet;
      continue;
    }
    if (text_says_boot(byte)) {
      doubt({ErrorCode::kDeviceRestarted}, now);
      continue;
    }
    const std::uint64_t skipped = decoder_.skipped();
    const auto frame = decoder_.push(byte);
    health_.unexpected += decoder_.skipped() - skipped;
    if (!frame) continue;
    if (const auto reply = decode_reply(*frame)) {
      handle(*reply, now);
    } else {
      ++health_.unexpected;
    }
  }
  poll(now);
}

bool LscDriver::text_says_boot(std::uint8_t byte) {
  if (profile_ != LscProfile::kEsp32) return false;
  const bool fits = byte == static_cast<std::uint8_t>(kBootText[boot_matched_]);
  boot_matched_ = fits ? boot_matched_ + 1 : 0;
  if (boot_matched_ < kBootText.size()) return false;
  boot_matched_ = 0;
  return true;
}

/// For whoever looks on, whether it was asked for or not.
void LscDriver::note(const Reply& reply, Instant now) {
  if (const auto* battery = std::get_if<Battery>(&reply)) facts_.battery = {*battery, now};
  if (const auto* version = std::get_if<Version>(&reply)) facts_.version = {*version, now};
  if (const auto* started = std::get_if<GroupStarted>(&reply)) {
    facts_.group_started = {*started, now};
  }
  if (const auto* finished = std::get_if<GroupFinished>(&reply)) {
    facts_.group_finished = {*finished, now};
  }
  if (const auto* stopped = std::get_if<GroupStopped>(&reply)) {
    facts_.group_stopped = {*stopped, now};
  }
  if (const auto* measured = std::get_if<Positions>(&reply)) {
    facts_.positions = {measured->servos, now};
  }
  if (const auto* commanded = std::get_if<Commanded>(&reply)) {
    facts_.positions = {ServoValues(commanded->servos), now};
  }
}

void LscDriver::handle(const Reply& reply, Instant now) {
  note(reply, now);
  const auto* started = std::get_if<GroupStarted>(&reply);
  const auto* finished = std::get_if<GroupFinished>(&reply);
  if (started != nullptr || finished != nullptr) {
    // Somebody else moved the arm: the Run button, an app.
    ++health_.unexpected;
    if (phase_ == Phase::kFault) return;
    return doubt({ErrorCode::kForeignMotion}, now);
  }
  if (const auto* battery = std::get_if<Battery>(&reply);
      battery != nullptr && question_ == Question::kBattery) {
    question_ = Question::kNone;
    return take_battery(battery->millivolts / 1000.0, now);
  }
  if (std::holds_alternative<Version>(reply) && question_ == Question::kVersion) {
    question_ = Question::kNone;
    return take_life(now);
  }
  const auto* commanded = std::get_if<Commanded>(&reply);
  const auto* measured = std::get_if<Positions>(&reply);
  if (profile_ == LscProfile::kLsc6 && measured != nullptr) return take_kind(*measured);
  if (question_ == Question::kPositions && commanded != nullptr) {
    return take_positions(commanded->servos, now);
  }
  if (question_ == Question::kPositions && measured != nullptr) {
    return take_positions({measured->servos.data(), measured->servos.size()}, now);
  }
  // The answer to the StopGroup of an opening says nothing that matters.
  if (std::holds_alternative<GroupStopped>(reply) && phase_ == Phase::kAsking) return;
  ++health_.unexpected;
}

void LscDriver::take_battery(double volts, Instant now) {
  if (volts <= kVoltsPlausible) {
    health_.supply_volts = volts;
    volts_at_ = now;
  }
  // One reading may be damaged, two in a row that are both low are not.
  low_readings_ = volts < timing_.supply_notice_volts ? low_readings_ + 1 : 0;
  empty_readings_ = volts < timing_.supply_fault_volts ? empty_readings_ + 1 : 0;
  const Error low{ErrorCode::kSupplyLow, -1, volts, timing_.supply_notice_volts};
  if (low_readings_ == 2) tell(Kind::kNotice, low);
  if (empty_readings_ == 1 && phase_ != Phase::kFault) {
    health_due_ = now;
    return;
  }
  if (empty_readings_ >= 2 && phase_ != Phase::kFault) {
    return enter_fault({ErrorCode::kSupplyLow, -1, volts, timing_.supply_fault_volts});
  }
  take_life(now);
}

void LscDriver::take_life(Instant now) {
  tries_left_ = timing_.tries;
  if (phase_ != Phase::kAsking) return say_rest(now);
  const bool told_apart = profile_ == LscProfile::kLsc6 && kind_silences_ >= kKindSilences;
  if (told_apart) return become_ready(now);
  reading_ = Units{};  // no reading agrees with all zeros
}

/// A board that tells where a servo is has servos on a bus: its units are others, and turn the
/// other way.
void LscDriver::take_kind(const Positions& positions) {
  const bool asked_for = positions.servos.size() == 1 && positions.servos[0].id == units_.id(0);
  if (!asked_for || phase_ == Phase::kFault) {
    ++health_.unexpected;
    return;
  }
  question_ = Question::kNone;
  enter_fault({ErrorCode::kOtherBoard});
}

void LscDriver::take_positions(std::span<const ServoValue> servos, Instant now) {
  const std::uint16_t highest = profile_ == LscProfile::kBus ? kMeasuredMax : kCommandedMax;
  Units units{};
  std::uint32_t found = 0;
  for (const ServoValue& servo : servos) {
    const auto slot = units_.slot_of(servo.id);
    if (!slot || servo.value > highest) continue;
    units[*slot] = servo.value;
    found |= bit(*slot);
  }
  if (found != (1U << units_.slots()) - 1) {
    ++health_.unexpected;
    return;
  }
  question_ = Question::kNone;
  tries_left_ = timing_.tries;
  if (free_ && phase_ == Phase::kIdle) return follow_hand(units, now);
  const double tolerance = profile_ == LscProfile::kBus ? kMeasuredAgree : 0;
  bool same = reading_.has_value();
  // A hand may lead the joints while the jaws move.
  const std::size_t first = free_ && phase_ != Phase::kAsking ? units_.joints() : 0;
  for (std::size_t i = first; same && i < units_.slots(); ++i) {
    same = std::abs(1.0 * units[i] - (*reading_)[i]) <= tolerance && units[i] != 0;
  }
  reading_ = units;
  if (same) return positions_agreed(units, now);
  // It still moves, or answers get damaged all the time.
  if (--readings_left_ > 0) return;
  doubt({ErrorCode::kPositionUnknown, 0}, now);
}

void LscDriver::positions_agreed(const Units& units, Instant now) {
  hand_at_ = now;
  if (profile_ == LscProfile::kBus && units_.jaws()) {
    health_.jaws_width = units_.width_of(units[*units_.jaws()]);
  }
  if (phase_ == Phase::kReading) return check_arrival(units, now);
  if (phase_ != Phase::kAsking) return;
  bool boot = profile_ == LscProfile::kEsp32;
  for (std::size_t i = 0; i < units_.slots(); ++i) boot = boot && units[i] == kBootUnits;
  for (std::size_t i = 0; i < units_.slots(); ++i) {
    const double there = units[i];
    slots_[i] = {false, true, there, there, there, there};
    if (i >= units_.joints()) continue;
    positions_[i] = {};
    if (profile_ == LscProfile::kBus) positions_[i].quality = PositionQuality::kMeasured;
    // A board that was just switched on says 1500 for servos that it has never driven.
    if (profile_ == LscProfile::kEsp32 && !boot) {
      positions_[i].quality = PositionQuality::kCommanded;
    }
  }
  refresh(now);
  become_ready(now);
}

void LscDriver::check_arrival(const Units& units, Instant now) {
  const bool bus = profile_ == LscProfile::kBus;
  const bool arm = (current_.mask & bit(0)) != 0;
  const bool stopped_first = stopping_ && lost();
  std::optional<Error> missed;
  for (std::size_t i = 0; i < units_.joints(); ++i) {
    const Slot& slot = slots_[i];
    const double measured = units_.q_of(i, units[i]);
    const double target = units_.q_of(i, slot.to);
    const double tolerance = bus ? timing_.measured_tolerance : units_.resolution(i) / 2;
    if (!slot.held || missed || std::abs(measured - target) <= tolerance) continue;
    missed = Error{ErrorCode::kMissedTarget, static_cast<std::int8_t>(i), measured, target};
  }
  if (missed && !bus && rewrites_left_ > 0) {
    --rewrites_left_;
    phase_ = Phase::kConfirming;
    confirms_left_ = kConfirms;
    phase_due_ = now;
    return;
  }
  for (std::size_t i = 0; i < units_.joints(); ++i) {
    const double there = units[i];
    JointPosition& joint = positions_[i];
    if (bus) {
      joint.quality = PositionQuality::kMeasured;
      measure_sag(i, there);
    } else if (arm && !stopped_first) {
      joint.quality = PositionQuality::kCommanded;
    }
    slots_[i].from = slots_[i].to = slots_[i].lower = slots_[i].upper = there;
  }
  if (missed && arm && !stopping_) end_all(Kind::kFailed, *missed);
  finish(now);
}

}  // namespace sinew
