#include "sinew/devices/grbl/grbl_device.h"

#include <algorithm>
#include <cmath>

#include "sinew/core/assert.h"

namespace sinew::grbl {
namespace {

constexpr Duration kTick = std::chrono::milliseconds(1);
constexpr Duration kBoot = std::chrono::milliseconds(300);
/// Of a search for a switch, in travels; then it is not there.
constexpr double kSeekTravels = 1.5;
/// Status reports without the offset of work coordinates between two with it.
constexpr int kOffsetEvery = 9;

// error:N
constexpr std::uint16_t kNoSuchStatement = 3;
constexpr std::uint16_t kHomingOff = 5;
constexpr std::uint16_t kNotIdle = 8;
constexpr std::uint16_t kLocked = 9;
constexpr std::uint16_t kTooLong = 14;
constexpr std::uint16_t kUnsupported = 20;
constexpr std::uint16_t kHomingOnly = 46;

// ALARM:N
constexpr std::uint16_t kHardLimit = 1;
constexpr std::uint16_t kResetInMotion = 3;
constexpr std::uint16_t kProbeClosed = 4;
constexpr std::uint16_t kHomingReset = 6;
constexpr std::uint16_t kStaysClosed = 8;
constexpr std::uint16_t kNoSwitch = 9;
constexpr std::uint16_t kEmergency = 10;
constexpr std::uint16_t kHomingRequired = 11;

FixedVector<AxisRates, kAxesMax> rates_of(const BoardSettings& settings) {
  FixedVector<AxisRates, kAxesMax> rates;
  for (const BoardSettings::Axis& axis : settings.axes) rates.push_back(axis.rates);
  return rates;
}

std::optional<RealTime> real_time_of(std::uint8_t byte) {
  constexpr std::array kAll{RealTime::kReset, RealTime::kStatus, RealTime::kHold, RealTime::kResume,
                            RealTime::kJogCancel};
  const auto* const found = std::ranges::find(kAll, static_cast<RealTime>(byte));
  return found == kAll.end() ? std::nullopt : std::optional(*found);
}

}  // namespace

GrblDevice::GrblDevice(const BoardSettings& settings, Instant boot)
    : settings_(settings), planner_(rates_of(settings), settings.deviation), now_(boot) {
  zero_.resize(settings.axes.size());
  power_up(boot);
}

double GrblDevice::turned(std::size_t axis) const {
  const double steps = settings_.axes[axis].steps_per_unit;
  return std::round(planner_.position()[axis] * steps) / steps;
}

bool GrblDevice::moving() const {
  return !planner_.empty() && !planner_.at_rest();
}

// Power

void GrblDevice::lose_power() {
  powered_ = false;
  planner_.clear();
  received_.clear();
  output_.clear();
  boots_.reset();
}

void GrblDevice::power_up(Instant now) {
  powered_ = true;
  now_ = std::max(now_, now);
  boots_ = now_ + kBoot;
  // A rotor goes to a whole step, and it counts from there.
  Values at;
  for (std::size_t i = 0; i < zero_.size(); ++i) at.push_back(turned(i));
  planner_.place(at);
  zero_ = at;
  alarm_ = settings_.homing ? kHomingRequired : 0;
  tool_z_ = 0;
  state_ = State::kSleep;
}

/// Behind a start and behind each reset.
void GrblDevice::begin() {
  planner_.clear();
  search_ = Search::kNone;
  probes_ = false;
  received_.clear();
  lines_.reset();
  line_waits_ = critical_ = false;
  // grblHAL keeps it over a reset.
  if (settings_.firmware != Firmware::kGrblHal) tool_z_ = 0;
  offset_due_ = 0;
  state_ = alarm_ != 0 ? State::kAlarm : State::kIdle;
  // Ends what was cut off.
  output_.push_back('\r');
  output_.push_back('\n');
  say(Welcome{settings_.firmware, 1, 1});
}

std::optional<Instant> GrblDevice::next_event() const {
  if (!powered_) return std::nullopt;
  if (boots_) return boots_;
  return moving() || search_ != Search::kNone || line_waits_ ? std::optional(now_ + kTick)
                                                             : std::nullopt;
}

// Time

void GrblDevice::advance(Instant now) {
  if (!powered_) {
    now_ = std::max(now_, now);
    return;
  }
  if (boots_ && now >= *boots_) {
    now_ = *boots_;
    boots_.reset();
    begin();
  }
  while (now_ < now) {
    if (!moving() && search_ == Search::kNone) {
      now_ = now;
      return;
    }
    const Duration dt = std::min<Duration>(kTick, now - now_);
    now_ += dt;
    step(dt);
  }
}

void GrblDevice::step(Duration dt) {
  planner_.advance(to_seconds(dt));
  if (search_ != Search::kNone) return step_homing();
  const bool runs = state_ == State::kRun || state_ == State::kJog;
  if (runs && settings_.homing && switches_ != 0) {
    critical_ = true;
    return alarm(kHardLimit);
  }
  if (probes_) step_probing();
  settle();
}

/// What has come to its end makes room.
void GrblDevice::settle() {
  if (state_ == State::kJog && planner_.at_rest()) planner_.clear();
  const bool runs = state_ == State::kRun || state_ == State::kJog;
  if (runs && planner_.empty()) state_ = State::kIdle;
  read_lines();
}

void GrblDevice::begin_search(std::size_t axis, Search phase) {
  homing_axis_ = axis;
  search_ = phase;
  const BoardSettings::Axis& own = settings_.axes[axis];
  const double towards = own.homes_down ? -1 : 1;
  const bool seeks = phase == Search::kSeek || phase == Search::kLocate;
  const double way = seeks ? towards * kSeekTravels * own.travel : -towards * settings_.pull_off;
  const double rate = settings_.homing_rate / (phase == Search::kLocate ? 20 : 1);
  Values to = planner_.position();
  to[axis] += way;
  planner_.clear();
  planner_.push(to, std::abs(way) / rate);
}

void GrblDevice::step_homing() {
  const bool closed = (switches_ >> homing_axis_ & 1) != 0;
  const bool seeks = search_ == Search::kSeek || search_ == Search::kLocate;
  if (seeks ? !closed && !planner_.empty() : !planner_.empty()) return;
  if (seeks != closed) {
    alarm(seeks ? kNoSwitch : kStaysClosed);
    if (settings_.firmware == Firmware::kGrblHal) begin();
    return;
  }
  if (search_ != Search::kPullOff) {
    return begin_search(homing_axis_, static_cast<Search>(static_cast<int>(search_) + 1));
  }
  zero_[homing_axis_] = turned(homing_axis_) - settings_.axes[homing_axis_].homed_at;
  if (homing_axis_ + 1 < zero_.size()) return begin_search(homing_axis_ + 1, Search::kSeek);
  search_ = Search::kNone;
  state_ = State::kIdle;
  alarm_ = 0;
  say(Ok{});
  read_lines();
}

/// It brakes where its input has closed, and tells the place of that.
void GrblDevice::step_probing() {
  if (probe_closed_ && !touched_ && state_ == State::kRun) {
    touched_ = believed();
    planner_.hold();
  }
  if (touched_ && planner_.at_rest()) planner_.clear();
  if (!planner_.empty()) return;
  probes_ = false;
  say(Probed{touched_.value_or(believed()), touched_.has_value()});
  say(Ok{});
}

void GrblDevice::alarm(std::uint16_t code) {
  planner_.clear();
  probes_ = false;
  search_ = Search::kNone;
  alarm_ = code;
  state_ = State::kAlarm;
  say(Alarm{code});
}

void GrblDevice::set_emergency_stop(bool pressed) {
  emergency_ = pressed;
  if (pressed && powered_ && !boots_) alarm(kEmergency);
}

// Characters

void GrblDevice::receive(std::uint8_t byte, Instant now) {
  advance(now);
  if (!powered_ || boots_) return;
  if (critical_ && byte != static_cast<std::uint8_t>(RealTime::kReset)) return;
  if (const auto what = real_time_of(byte)) return real_time(*what);
  if (received_.size() >= std::min(settings_.bytes(), received_.capacity())) {
    ++bytes_lost_;
    return;
  }
  received_.push_back(byte);
  read_lines();
}

void GrblDevice::real_time(RealTime what) {
  switch (what) {
    case RealTime::kStatus:
      return say(status());
    case RealTime::kReset:
      return reset();
    case RealTime::kHold:
      if (state_ == State::kJog && settings_.firmware != Firmware::kGrblHal) {
        return real_time(RealTime::kJogCancel);
      }
      if (state_ != State::kRun && state_ != State::kIdle) return;
      planner_.hold();
      state_ = State::kHold;
      return;
    case RealTime::kResume:
      if (state_ != State::kHold) return;
      planner_.resume();
      state_ = State::kRun;
      return settle();
    case RealTime::kJogCancel:
      if (state_ != State::kJog) return;
      planner_.hold();
      return settle();
  }
}

/// What it moves is cut off, and it no longer knows where it is.
void GrblDevice::reset() {
  const bool moves = moving();
  if (search_ != Search::kNone) {
    alarm(kHomingReset);
  } else if (moves) {
    alarm(kResetInMotion);
  } else if (alarm_ == kEmergency && !emergency_) {
    alarm_ = 0;
  }
  begin();
}

/// No line is read while it holds, probes or looks for switches, nor a motion without room for it.
void GrblDevice::read_lines() {
  while (state_ != State::kHold && search_ == Search::kNone && !probes_) {
    if (!line_waits_) {
      if (received_.empty()) return;
      const std::uint8_t byte = received_[0];
      received_.drop_front(1);
      const LineDecoder::Result result = lines_.push(byte);
      if (result == LineDecoder::Result::kMore) continue;
      if (result == LineDecoder::Result::kDamaged) {
        say(Refused{kTooLong});
        continue;
      }
      line_waits_ = true;
    }
    if (planner_.full()) return;
    line_waits_ = false;
    answer(lines_.line());
  }
}

void GrblDevice::answer(std::string_view line) {
  if (line.size() > kLineMax) return say(Refused{kTooLong});
  if (const auto request = decode_request(line)) return answer(*request);
  say(Refused{line[0] == '$' ? kNoSuchStatement : kUnsupported});
}

void GrblDevice::answer(const Request& request) {
  if (const auto* move = std::get_if<Move>(&request)) return answer(*move);
  if (const auto* jog = std::get_if<Jog>(&request)) return answer(*jog);
  if (const auto* probe = std::get_if<Probe>(&request)) return answer(*probe);
  if (std::holds_alternative<AskSettings>(request)) return show_settings();
  if (std::holds_alternative<AskBuild>(request)) return show_build();
  if (const auto* offset = std::get_if<ToolOffset>(&request)) {
    if (state_ == State::kAlarm) return say(Refused{kLocked});
    tool_z_ = offset->z;
    offset_due_ = 0;
  }
  if (const auto* home = std::get_if<Home>(&request)) {
    if (!settings_.homing) return say(Refused{kHomingOff});
    if (home->axes != 0) return say(Refused{kNoSuchStatement});
    if (state_ != State::kIdle && alarm_ == 0) return say(Refused{kNotIdle});
    if (emergency_) return say(Refused{kLocked});
    state_ = State::kHome;
    return begin_search(0, Search::kSeek);
  }
  if (std::holds_alternative<Unlock>(request)) {
    if (emergency_) return say(Refused{kLocked});
    const bool asks = settings_.firmware == Firmware::kGrblHal && alarm_ == kHomingRequired;
    if (asks) return say(Refused{kHomingOnly});
    if (state_ == State::kAlarm) state_ = State::kIdle;
    alarm_ = 0;
  }
  say(Ok{});
}

void GrblDevice::answer(const Move& move) {
  if (state_ == State::kAlarm) return say(Refused{kLocked});
  if (state_ == State::kJog || move.to.size() != zero_.size()) return say(Refused{kNotIdle});
  Values to;
  for (std::size_t i = 0; i < zero_.size(); ++i) to.push_back(move.to[i] + zero_[i]);
  planner_.push(rounded(to), move.duration);
  if (!planner_.empty()) state_ = State::kRun;
  say(Ok{});
}

void GrblDevice::answer(const Jog& jog) {
  if (state_ != State::kIdle) return say(Refused{state_ == State::kAlarm ? kLocked : kNotIdle});
  if (jog.axis >= zero_.size()) return say(Refused{kUnsupported});
  Values to = planner_.position();
  to[jog.axis] += jog.by;
  planner_.push(rounded(to), std::max(std::abs(jog.by) * 60 / jog.rate, kDurationMin));
  if (!planner_.empty()) state_ = State::kJog;
  say(Ok{});
}

void GrblDevice::answer(const Probe& probe) {
  if (state_ != State::kIdle) return say(Refused{state_ == State::kAlarm ? kLocked : kNotIdle});
  if (probe.axis >= zero_.size()) return say(Refused{kUnsupported});
  if (probe_closed_) return alarm(kProbeClosed);
  Values to = planner_.position();
  to[probe.axis] += probe.by;
  planner_.push(rounded(to), std::max(std::abs(probe.by) * 60 / probe.rate, kDurationMin));
  probes_ = true;
  touched_.reset();
  if (!planner_.empty()) state_ = State::kRun;
  step_probing();
}

Values GrblDevice::believed() const {
  Values all;
  for (std::size_t i = 0; i < zero_.size(); ++i) all.push_back(believed(i));
  return all;
}

/// To whole steps.
Values GrblDevice::rounded(const Values& motor) const {
  Values to = motor;
  for (std::size_t i = 0; i < to.size(); ++i) {
    const double steps = settings_.axes[i].steps_per_unit;
    to[i] = std::round(to[i] * steps) / steps;
  }
  return to;
}

// What it says

void GrblDevice::say(const Reply& reply) {
  const Line line = encode(reply);
  if (output_.size() + line.size() > output_.capacity()) return;
  for (const char c : line) output_.push_back(static_cast<std::uint8_t>(c));
}

Status GrblDevice::status() {
  Status status;
  status.state = state_;
  if (state_ == State::kHold) status.detail = planner_.at_rest() ? 0 : 1;
  if (state_ == State::kAlarm && settings_.firmware == Firmware::kGrblHal) status.detail = alarm_;
  status.position = believed();
  if (settings_.firmware != Firmware::kGrbl) {
    status.room = Status::Room{static_cast<std::uint16_t>(Planner::kBlocks - planner_.size()),
                               static_cast<std::uint16_t>(settings_.bytes() - received_.size())};
  }
  if (offset_due_-- <= 0) {
    offset_due_ = kOffsetEvery;
    status.offset.emplace();
    status.offset->resize(zero_.size());
    if (zero_.size() > 2) (*status.offset)[2] = tool_z_;
  }
  if (switches_ != 0 || emergency_ || probe_closed_) {
    status.pins.emplace();
    status.pins->limits = switches_;
    status.pins->emergency_stop = emergency_;
    status.pins->probe = probe_closed_;
  }
  return status;
}

void GrblDevice::show_settings() {
  const auto show = [&](std::size_t number, double value) {
    say(Setting{static_cast<std::uint16_t>(number), value});
  };
  show(1, settings_.idle_ms);
  show(10, 1);
  show(11, settings_.deviation);
  show(22, settings_.homing ? 1 : 0);
  for (std::size_t i = 0; i < settings_.axes.size(); ++i) {
    const BoardSettings::Axis& axis = settings_.axes[i];
    show(kStepsSetting + i, axis.steps_per_unit);
    show(kRateSetting + i, axis.rates.rate * 60);
    show(kAccelerationSetting + i, axis.rates.acceleration);
    show(kTravelSetting + i, axis.travel);
  }
  say(Ok{});
}

void GrblDevice::show_build() {
  const bool counts = settings_.firmware == Firmware::kGrblHal;
  say(Build{Planner::kBlocks, static_cast<std::uint16_t>(settings_.bytes()),
            static_cast<std::uint8_t>(counts ? settings_.axes.size() : 0)});
  say(Ok{});
}

}  // namespace sinew::grbl
