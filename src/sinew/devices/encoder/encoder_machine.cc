#include "sinew/devices/encoder/encoder_machine.h"

#include <algorithm>
#include <cmath>

#include "sinew/core/units.h"
#include "sinew/devices/encoder/encoder_device_chip.h"

namespace sinew::sim {
namespace {

constexpr double kBrownOut = 3;  // V; the STM8S103 resets at 2.95 V at most

double first_angle(std::uint64_t seed) {
  return SplitMix64(seed).uniform(0, 2 * kPi);
}

}  // namespace

EncoderBoard::EncoderBoard(I2cBus& bus, Instant boot) : bus_(bus), next_sample_(boot) {
  encoder_node_start(&node_);
}

void EncoderBoard::sample(std::uint8_t elapsed) {
  const auto chip = read_as5600_bytes(bus_);
  encoder_node_sample(&node_, chip ? chip->data() : nullptr, elapsed);
}

void EncoderBoard::advance(Instant now) {
  std::int64_t elapsed = 1;
  // A long time without a call has one shaft to read, so there is one sample.
  if (now - next_sample_ > std::chrono::milliseconds(kEncoderNodeStale)) {
    elapsed += (now - next_sample_) / kSamplePeriod;
    next_sample_ += (elapsed - 1) * kSamplePeriod;
  }
  for (; next_sample_ <= now; next_sample_ += kSamplePeriod) {
    sample(static_cast<std::uint8_t>(std::min<std::int64_t>(elapsed, 255)));
    elapsed = 1;
  }
}

void EncoderBoard::receive(std::span<const std::uint8_t> bytes, Instant now) {
  advance(now);
  for (const std::uint8_t byte : bytes) {
    encoder_link::ReplyBytes reply{};
    if (!encoder_node_receive(&node_, byte, reply.data())) continue;
    if (output_.capacity() - output_.size() < reply.size()) continue;
    for (const std::uint8_t one : reply) output_.push_back(one);
  }
}

EncoderMachine::EncoderMachine(double speed, std::uint64_t seed, Instant boot)
    : speed_(speed), angle_(first_angle(seed)), chip_(angle_, seed), now_(boot) {
  board_.emplace(bus_, boot);
}

void EncoderMachine::advance(Instant now) {
  // In the node's own samples: the chip turns between them.
  while (now_ < now) {
    const Instant next = std::min(now, now_ + EncoderBoard::kSamplePeriod);
    const double dt = to_seconds(next - now_);
    if (!blocked_) angle_ += speed_ * dt;
    chip_.turn_to(angle_, dt);
    now_ = next;
    if (board_) board_->advance(now_);
  }
}

Truth EncoderMachine::truth() const {
  Truth truth;
  const auto within_turn = [](double angle) { return std::remainder(angle, 2 * kPi); };
  const double qd = blocked_ ? 0 : speed_;
  truth.joints.push_back({.q = within_turn(angle_),
                          .qd = qd,
                          .believed = within_turn(chip_.counts() * 2 * kPi / As5600::kTurn)});
  truth.supply_volts = supply_volts_;
  truth.moving = qd != 0;
  return truth;
}

void EncoderMachine::disturb(const Disturbance& what) {
  using Kind = Disturbance::Kind;
  if (what.kind == Kind::kMagnet) chip_.set_field(what.value);
  if (what.kind == Kind::kBlock) blocked_ = true;
  if (what.kind == Kind::kUnblock) blocked_ = false;
  if (what.kind != Kind::kSupply) return;
  supply_volts_ = what.value;
  const bool on = supply_volts_ >= kBrownOut;
  if (on && !board_) board_.emplace(bus_, now_);
  if (!on) board_.reset();
}

void EncoderMachine::receive(std::span<const std::uint8_t> bytes, Instant now) {
  advance(now);
  if (board_) board_->receive(bytes, now);
}

std::size_t EncoderMachine::take_output(std::span<std::uint8_t> out) {
  return board_ ? board_->take_output(out) : 0;
}

}  // namespace sinew::sim
