#include "firmware/emulation_avr/mega_board.h"

#include <algorithm>

#include "sinew/core/split_mix.h"

namespace sinew::emulation {
namespace {

/// Of the port: 10 bits of 4 us.
constexpr std::uint64_t kCyclesPerByte = 640;

struct Pin {
  char port;
  int bit;
};
struct AxisPins {
  Pin step, direction, enable;
  bool reversed;
};
// MKS Gen L v2.1, by its pin table: base, shoulder, elbow, wrist rotate, wrist. The shoulder's
// motor is mounted the other way round.
constexpr std::array<AxisPins, MegaBoard::kAxes> kPins{{
    {{'F', 0}, {'F', 1}, {'D', 7}, false},
    {{'F', 6}, {'F', 7}, {'F', 2}, true},
    {{'L', 3}, {'L', 1}, {'K', 0}, false},
    {{'A', 4}, {'A', 6}, {'A', 2}, false},
    {{'C', 1}, {'C', 3}, {'C', 7}, false},
}};
constexpr Pin kStopLine{'E', 4};
constexpr Pin kServo{'E', 5};

}  // namespace

std::string mega_image() {
  return SINEW_ATMEGA_IMAGES "/bigrobotarm-atmega2560.bin";
}

MegaBoard::MegaBoard() {
  power_cycle();
  run_until(kStart);
}

void MegaBoard::power_cycle() {
  chip_ = std::make_unique<AvrBoard>(AvrChip::kAtmega2560, mega_image());
  SplitMix64 random(++noise_);
  chip_->fill_ram([&] { return static_cast<std::uint8_t>(random.bits()); });
  input_.clear();
  output_.clear();
  sending_ = false;
  watch_pins();
  chip_->on_restart([this] { set_stop_line(false); });
  set_stop_line(false);
}

void MegaBoard::watch_pins() {
  for (std::size_t i = 0; i < kAxes; ++i) {
    const AxisPins& pins = kPins[i];
    steps_[i] = 0;
    high_[i] = false;
    chip_->on_pin(pins.step.port, pins.step.bit, [this, i](bool high) { step(i, high); });
    chip_->on_pin(pins.direction.port, pins.direction.bit,
                  [this, i](bool high) { backwards_[i] = high != kPins[i].reversed; });
  }
  servo_raised_ = 0;
  chip_->on_pin(kServo.port, kServo.bit, [this](bool high) {
    const double us = 1e6 / AvrBoard::kHertz;
    if (high) {
      servo_raised_ = chip_->cycle();
    } else if (servo_raised_ != 0) {
      servo_us_ = static_cast<double>(chip_->cycle() - servo_raised_) * us;
      servo_raised_ = 0;
    }
  });
  chip_->on_uart('0', [this](std::uint8_t byte) { output_.push_back(byte); });
}

void MegaBoard::step(std::size_t axis, bool high) {
  if (high == high_[axis]) return;
  high_[axis] = high;
  const std::uint64_t now = chip_->cycle();
  if (!high) {
    const double pulse = static_cast<double>(now - raised_[axis]) / AvrBoard::kHertz;
    shortest_pulse_ = std::min(shortest_pulse_, pulse);
    return;
  }
  raised_[axis] = now;
  steps_[axis] += backwards_[axis] ? -1 : 1;
  if (on_step) on_step({axis, steps_[axis], seconds()});
}

void MegaBoard::send(std::span<const std::uint8_t> bytes) {
  input_.insert(input_.end(), bytes.begin(), bytes.end());
  if (sending_ || input_.empty()) return;
  sending_ = true;
  chip_->at_cycle(chip_->cycle() + kCyclesPerByte, [this]() -> std::optional<std::uint64_t> {
    sending_ = !input_.empty();
    if (!sending_) return std::nullopt;
    chip_->send_uart('0', input_.front());
    input_.pop_front();
    return chip_->cycle() + kCyclesPerByte;
  });
}

void MegaBoard::run_ms(int ms) {
  chip_->run_until(chip_->now() + std::chrono::milliseconds(ms));
}

void MegaBoard::set_stop_line(bool low) {
  // A reset clears the pin's register, and a level that was there before is no change.
  chip_->set_pin(kStopLine.port, kStopLine.bit, low);
  chip_->set_pin(kStopLine.port, kStopLine.bit, !low);
}

void MegaBoard::restart() {
  chip_->reset();
  set_stop_line(false);
}

bool MegaBoard::enabled(std::size_t axis) const {
  return chip_->drives_low(kPins[axis].enable.port, kPins[axis].enable.bit);
}

}  // namespace sinew::emulation
