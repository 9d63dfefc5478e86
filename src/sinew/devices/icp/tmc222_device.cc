#include "sinew/devices/icp/tmc222_device.h"

#include <algorithm>
#include <cmath>

namespace sinew {

using namespace tmc222;

namespace {

template <class... Cases>
struct Overload : Cases... {
  using Cases::operator()...;
};

constexpr int kSixteenth = 16;

}  // namespace

Tmc222::Tmc222(std::uint8_t address, const Parameters& otp, double under_voltage_v, Instant)
    : address_(address), otp_(otp), under_voltage_(under_voltage_v) {
  reset_ram();
}

void Tmc222::reset_ram() {
  state_ = State::kShutdown;
  parameters_ = otp_;
  parameters_set_ = false;
  flags_ = {};
  flags_.vdd_reset = true;
  actual_ = 0;
  target_ = 0;
  speed_ = 0;
  init_.reset();
  next_step_.reset();
  answer_.fill(0xFF);
}

bool Tmc222::write(std::span<const std::uint8_t> bytes, Instant now) {
  advance(now);
  if (volts_ < kVddReset) return false;
  if (const auto command = decode_command(bytes)) execute(*command, now);
  return true;
}

bool Tmc222::read(Answer& answer, Instant now) {
  advance(now);
  if (volts_ < kVddReset) return false;
  answer = answer_;
  return true;
}

void Tmc222::execute(const Command& command, Instant now) {
  std::visit(Overload{[&](const GetFullStatus1&) {
                        answer_ = encode_status1(status1());
                        flags_ = {};
                        check_faults();
                        if (state_ == State::kShutdown && !faulty()) state_ = State::kStopped;
                      },
                      [&](const GetFullStatus2&) {
                        answer_ = encode_status2({address_, static_cast<std::int16_t>(actual_),
                                                  static_cast<std::int16_t>(target_),
                                                  parameters_.secure_position});
                      },
                      [&](const GetOtpParam&) { answer_ = encode_otp(address_, otp_); },
                      [&](const GotoSecurePosition&) {
                        if (parameters_.secure_position == kSecurePositionOff) return;
                        go_to(secure_target(parameters_), now);
                      },
                      [&](const HardStop&) { stop_hard(false); },
                      [&](const SoftStop&) {
                        if (state_ == State::kGotoPos && !init_) state_ = State::kSoftStop;
                      },
                      [&](const ResetPosition&) {
                        if (moving()) return;
                        actual_ = 0;
                        target_ = 0;
                      },
                      [&](const ResetToDefault&) {
                        if (!moving()) set_parameters(otp_);
                      },
                      [&](const RunInit& init) {
                        if (moving() || state_ == State::kShutdown || flags_.vdd_reset) return;
                        init_ = init;
                        second_way_ = false;
                        target_ = wrapped(init.first, parameters_.step_mode);
                        begin_leg(now);
                      },
                      [&](const SetMotorParam& set) {
                        if (moving()) return;
                        set_parameters(set.parameters);
                        parameters_set_ = true;
                      },
                      [&](const SetPosition& set) { go_to(set.target, now); }},
             command);
}

void Tmc222::set_parameters(const Parameters& parameters) {
  parameters_ = parameters;
  // Another step mode may have a narrower position.
  actual_ = wrapped(actual_, parameters_.step_mode);
  target_ = wrapped(target_, parameters_.step_mode);
}

void Tmc222::go_to(std::int64_t target, Instant now) {
  const bool blocked = flags_.step_loss || flags_.vdd_reset || !parameters_set_ || faulty() ||
                       state_ == State::kShutdown || state_ == State::kSoftStop || init_;
  if (blocked) return;
  target_ = wrapped(target, parameters_.step_mode);
  if (state_ == State::kStopped) begin_leg(now);
}

/// From rest towards target_, the short way round.
void Tmc222::begin_leg(Instant now) {
  velocity_top_ = kVelocityMax[parameters_.velocity_max];
  velocity_low_ = velocity_min(parameters_);
  if (init_) {
    velocity_top_ = kVelocityMax[init_->velocity_max];
    velocity_low_ =
        init_->velocity_min == 0 ? velocity_top_ : velocity_top_ * init_->velocity_min / 32;
  }
  const std::int32_t way = wrapped(std::int64_t{target_} - actual_, parameters_.step_mode);
  // RunInit that stands at its first target already waits there for ever.
  state_ = way == 0 && !init_ ? State::kStopped : State::kGotoPos;
  next_step_.reset();
  if (way == 0) return;
  direction_ = way < 0 ? -1 : 1;
  speed_ = velocity_low_;
  ramp_ = 1;
  schedule(now);
}

void Tmc222::schedule(Instant from) {
  next_step_ = from + from_seconds(1 / (speed_ * microsteps(parameters_.step_mode)));
}

void Tmc222::advance(Instant now) {
  while (next_step_ && *next_step_ <= now) make_step();
}

void Tmc222::make_step() {
  const Instant at = *next_step_;
  const std::uint8_t mode = parameters_.step_mode;
  actual_ = wrapped(std::int64_t{actual_} + direction_, mode);
  const int sense = parameters_.shaft ? -direction_ : direction_;
  field_ += std::int64_t{sense} * (kSixteenth / microsteps(mode));
  const std::int32_t way = wrapped(std::int64_t{target_} - actual_, mode);
  const double change = 2 * kAcceleration[parameters_.acceleration] / microsteps(mode);
  const double low = velocity_low_ * velocity_low_;
  const double top = velocity_top_ * velocity_top_;
  const double now = speed_ * speed_;
  const bool slow = now <= low;
  if (state_ == State::kSoftStop && slow) {
    target_ = actual_;
    state_ = State::kStopped;
    next_step_.reset();
    return;
  }
  if (way == 0 && slow) return arrive(at);
  // Away from the target, or nearer than the way to the lowest speed: slow down.
  const bool away = (way < 0 ? -1 : 1) != direction_;
  if (slow && away) {
    direction_ = -direction_;
    return schedule(at);
  }
  const double braking = (now - low) / change;
  const bool slows = state_ == State::kSoftStop || away || std::abs(way) <= braking + 1;
  double next = now;
  if (slows) next = std::max(low, now - change);
  if (!slows && !parameters_.acceleration_shape) next = std::min(top, now + change);
  ramp_ = 0;
  if (next < now) ramp_ = -1;
  if (next > now) ramp_ = 1;
  speed_ = std::sqrt(next);
  schedule(at);
}

void Tmc222::arrive(Instant at) {
  if (init_ && !second_way_) {
    // The second way is made at the lowest speed, without ramps.
    second_way_ = true;
    velocity_top_ = velocity_low_;
    target_ = wrapped(init_->second, parameters_.step_mode);
    const std::int32_t way = wrapped(std::int64_t{target_} - actual_, parameters_.step_mode);
    direction_ = way < 0 ? -1 : 1;
    if (way != 0) return schedule(at);
  }
  if (init_) {
    actual_ = 0;
    target_ = 0;
  }
  init_.reset();
  state_ = State::kStopped;
  next_step_.reset();
}

void Tmc222::stop_hard(bool shutdown) {
  if (moving()) {
    flags_.step_loss = true;
    target_ = actual_;
  }
  init_.reset();
  next_step_.reset();
  if (state_ != State::kShutdown) state_ = shutdown ? State::kShutdown : State::kStopped;
}

bool Tmc222::faulty() const {
  return volts_ < under_voltage_ || celsius_ > kThermalShutdown || coil_broken_;
}

/// Sets the flags of what is wrong now; they stay until they are read.
void Tmc222::check_faults() {
  if (volts_ < under_voltage_) flags_.under_voltage = true;
  if (coil_broken_) flags_.electrical_defect = true;
  if (celsius_ > kThermalWarning) {
    flags_.thermal_warning = true;
    flags_.temperature = 2;
  }
  if (celsius_ > kThermalShutdown) {
    flags_.thermal_shutdown = true;
    flags_.temperature = 3;
  }
  if (faulty()) stop_hard(true);
}

void Tmc222::set_supply(double volts, Instant now) {
  advance(now);
  const bool was_up = volts_ >= kVddReset;
  volts_ = volts;
  if (volts_ < kVddReset) {
    if (was_up) reset_ram();
    return;
  }
  check_faults();
}

void Tmc222::set_temperature(double celsius, Instant now) {
  advance(now);
  celsius_ = celsius;
  check_faults();
}

void Tmc222::set_coil_fault(bool broken, Instant now) {
  advance(now);
  coil_broken_ = broken;
  check_faults();
}

double Tmc222::current() const {
  if (!powered()) return 0;
  return kPeakCurrent[moving() ? parameters_.run_current : parameters_.hold_current];
}

Status1 Tmc222::status1() const {
  Status1 status{.address = address_, .parameters = parameters_, .flags = flags_};
  if (!moving()) {
    status.motion = actual_ == target_ ? Motion::kAtTarget : Motion::kNotAtTarget;
    return status;
  }
  const bool up = direction_ > 0;
  if (ramp_ > 0) status.motion = up ? Motion::kAcceleratingUp : Motion::kAcceleratingDown;
  if (ramp_ < 0) status.motion = up ? Motion::kDeceleratingUp : Motion::kDeceleratingDown;
  if (ramp_ == 0) status.motion = up ? Motion::kTopSpeedUp : Motion::kTopSpeedDown;
  return status;
}

}  // namespace sinew
