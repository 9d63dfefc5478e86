#include "sinew/devices/maxarm/maxarm_device.h"

#include <algorithm>
#include <cmath>

#include "sinew/core/assert.h"

namespace sinew {

using namespace maxarm;
using namespace std::chrono_literals;

namespace {

// Measured on the maker's programs, question to the answer's first byte.
constexpr Duration kAnswerArduino[2] = {98ms, 275ms};
constexpr Duration kAnswerMicroPython[2] = {18ms, 424ms};  // behind up to 100 ms of polling
constexpr Duration kPollPeriod = 100ms;

constexpr Duration kHomeArduino = 2s;  // assumed: its set-up moves home with the usual time
constexpr Duration kSleepMicroPython = 10s;
constexpr Duration kHomeMicroPython = 3500ms;

constexpr std::uint16_t kPwmTimeMin = 20;       // ms; below, the Arduino program divides by zero
constexpr std::uint16_t kServoTimeMax = 30000;  // ms, the servo's own bound
constexpr std::int32_t kForearmMin = 470;       // MicroPython's bounds
constexpr std::int32_t kShoulderMax = 700;

}  // namespace

double MaxArmFirmware::Ramp::at(Instant now) const {
  if (now >= start + time) return to;
  return from + (to - from) * to_seconds(now - start) / to_seconds(time);
}

MaxArmFirmware::MaxArmFirmware(const MaxArmDevice& settings, const PalletizerGeometry& geometry,
                               std::uint64_t seed, Instant boot)
    : settings_(settings), geometry_(geometry), random_(seed), now_(boot) {
  restart(boot);
  restarts_ = 0;
}

void MaxArmFirmware::restart(Instant now) {
  now_ = now;
  ++restarts_;
  bytes_lost_ += ring_.size();
  ring_.clear();
  poll_left_ = 0;
  decoder_.reset();
  output_.clear();
  reply_.reset();
  dead_ = false;
  homed_ = false;
  suction_ = 3;
  nozzle_ = {1500, 1500, now, {}};
  boot_home_ = arduino() ? now : now + kSleepMicroPython;
  boot_end_ = boot_home_ + (arduino() ? kHomeArduino : kHomeMicroPython);
  busy_until_ = boot_end_;
  next_poll_ = boot_end_ + kPollPeriod;
  finish_boot_step();
}

void MaxArmFirmware::power_up(Instant now) {
  driven_ = false;
  restart(now);
}

void MaxArmFirmware::finish_boot_step() {
  if (homed_ || now_ < boot_home_) return;
  homed_ = true;
  const auto time = std::chrono::duration_cast<std::chrono::milliseconds>(boot_end_ - boot_home_);
  move_servos({500, 500, 500}, static_cast<std::uint16_t>(time.count()));
}

void MaxArmFirmware::receive(std::span<const std::uint8_t> bytes, Instant now) {
  advance(now);
  const std::size_t room = arduino() ? kRingArduino : kRingMicroPython;
  for (const std::uint8_t byte : bytes) {
    if (starting() || dead_ || ring_.size() >= room) {
      ++bytes_lost_;
    } else {
      ring_.push_back(byte);
    }
  }
  process();
}

void MaxArmFirmware::advance(Instant now) {
  SINEW_ASSERT(now >= now_);
  while (const auto event = next_event()) {
    if (*event > now) break;
    now_ = std::max(now_, *event);
    process();
  }
  now_ = now;
  process();
}

std::optional<Instant> MaxArmFirmware::next_event() const {
  if (!homed_) return boot_home_;
  if (dead_) return std::nullopt;
  if (reply_ || (busy_until_ > now_ && !ring_.empty())) return busy_until_;
  if (ring_.empty()) return std::nullopt;
  if (arduino() || poll_left_ > 0) return std::max(busy_until_, now_);
  return std::max(next_poll_, now_);
}

void MaxArmFirmware::process() {
  finish_boot_step();
  while (!dead_ && now_ >= busy_until_) {
    if (reply_) {
      for (const std::uint8_t byte : *reply_) {
        if (!output_.full()) output_.push_back(byte);
      }
      reply_.reset();
    }
    if (!arduino()) poll_port();
    if (ring_.empty() || (!arduino() && poll_left_ == 0)) return;
    const std::uint8_t byte = ring_[0];
    ring_.drop_front(1);
    if (poll_left_ > 0) --poll_left_;
    const auto request = decoder_.push(byte);
    if (request) execute(*request);
    // The loop sleeps once it has seen all that was there.
    if (poll_left_ == 0) next_poll_ = std::max(now_, busy_until_) + kPollPeriod;
  }
}

void MaxArmFirmware::poll_port() {
  if (poll_left_ > 0 || now_ < next_poll_) return;
  decoder_.begin_poll();
  if (ring_.empty()) {
    // Looks that found nothing leave no trace but their rhythm.
    next_poll_ += ((now_ - next_poll_) / kPollPeriod + 1) * kPollPeriod;
    return;
  }
  poll_left_ = ring_.size();
  next_poll_ = now_ + kPollPeriod;
}

void MaxArmFirmware::execute(const Request& request) {
  ++requests_taken_;
  last_taken_ = request;
  if (const auto* angle = std::get_if<SetAngle>(&request)) {
    move_servos({angle->pulses[0], angle->pulses[1], angle->pulses[2]}, angle->time_ms);
  } else if (const auto* xyz = std::get_if<SetXyz>(&request)) {
    const auto pulses = firmware_pulses(geometry_, settings_.variant, xyz->xyz_mm);
    if (pulses) move_servos(*pulses, xyz->time_ms);
  } else if (const auto* pwm = std::get_if<SetPwmServo>(&request)) {
    turn_nozzle(*pwm);
  } else if (const auto* suction = std::get_if<SetSuction>(&request)) {
    if (suction->action >= 1 && suction->action <= 3) suction_ = suction->action;
  } else {
    read_servos(std::holds_alternative<ReadXyz>(request));
  }
}

void MaxArmFirmware::move_servos(const ServoPulses& pulses, std::uint16_t time_ms) {
  ServoPulses to = pulses;
  if (!arduino()) {
    to[1] = std::min(to[1], kShoulderMax);
    to[2] = std::max(to[2], kForearmMin);
  }
  for (std::size_t i = 0; i < ramps_.size(); ++i) {
    const double known = readings_[i].value_or(std::int16_t{500});
    const double from = driven_ ? ramps_[i].at(now_) : known;
    ramps_[i] = {from, 1.0 * std::clamp(to[i], 0, 1000), now_,
                 std::chrono::milliseconds(std::min(time_ms, kServoTimeMax))};
  }
  driven_ = true;
}

void MaxArmFirmware::turn_nozzle(const SetPwmServo& request) {
  if (arduino() && request.time_ms < kPwmTimeMin) return restart(now_);
  const Duration time = std::chrono::milliseconds(request.time_ms);
  const double us = std::clamp<double>(request.pulse_us, 500, 2500);
  nozzle_ = {nozzle_.at(now_), us, now_, time};
  if (arduino()) busy_until_ = now_ + time;
}

void MaxArmFirmware::read_servos(bool as_xyz) {
  std::array<std::int16_t, 3> pulses{};
  for (std::size_t i = 0; i < pulses.size(); ++i) {
    pulses[i] = readings_[i].value_or(std::int16_t{-1});
    // "if not position: try again" takes 0 for no answer, and gives up with an exception.
    if (!arduino() && (pulses[i] <= 0 || pulses[i] > 1000)) {
      dead_ = true;
      bytes_lost_ += ring_.size();
      ring_.clear();
      return;
    }
  }
  const auto& bounds = arduino() ? kAnswerArduino : kAnswerMicroPython;
  busy_until_ = now_ + from_seconds(random_.uniform(to_seconds(bounds[0]), to_seconds(bounds[1])));
  const Reply reply = as_xyz ? Reply{Position{firmware_xyz(geometry_, settings_.variant, pulses)}}
                             : Reply{Angles{pulses}};
  const bool spec = settings_.checksum == MaxArmChecksum::kSpec;
  reply_ = encode_reply(reply, spec ? Checksum::kSpec : Checksum::kWithHeader);
}

std::array<double, 3> MaxArmFirmware::servo_targets(Instant now) const {
  return {ramps_[0].at(now), ramps_[1].at(now), ramps_[2].at(now)};
}

bool MaxArmFirmware::ramping(Instant now) const {
  return std::ranges::any_of(ramps_, [&](const Ramp& r) { return now < r.start + r.time; });
}

double MaxArmFirmware::nozzle_us(Instant now) const {
  return nozzle_.at(now);
}

std::size_t MaxArmFirmware::take_output(std::span<std::uint8_t> out) {
  return output_.take_front(out);
}

}  // namespace sinew
