#include "sinew/devices/encoder/encoder_device.h"

#include <algorithm>
#include <array>

#include "sinew/core/assert.h"

namespace sinew {
namespace {

using encoder_link::Register;

// Half a turn a sample is where unwrapping ends; sums stay far inside 64 bits below it.
constexpr std::int64_t kSpeedMax = std::int64_t{2047} << 20;
constexpr std::int64_t kAccelerationMax = std::int64_t{256} << 20;

}  // namespace

void ShaftObserver::restart(std::uint16_t position) {
  angle_ = static_cast<std::uint32_t>(position) << 20;
  speed_ = 0;
  acceleration_ = 0;
}

void ShaftObserver::coast() {
  angle_ += static_cast<std::uint32_t>(speed_ + acceleration_ / 2);
  speed_ = std::clamp(speed_ + acceleration_, -kSpeedMax, kSpeedMax);
}

void ShaftObserver::update(std::uint16_t position) {
  coast();
  // The difference of two angles in 32 bits is the nearest way round.
  const auto measured = static_cast<std::uint32_t>(position) << 20;
  const std::int64_t error = static_cast<std::int32_t>(measured - angle_);
  angle_ += static_cast<std::uint32_t>(error * 721 / 4096);
  speed_ = std::clamp(speed_ + error * 93 / 8192, -kSpeedMax, kSpeedMax);
  acceleration_ = std::clamp(acceleration_ + error / 4096, -kAccelerationMax, kAccelerationMax);
}

EncoderNode::EncoderNode(I2cBus& bus, const Settings& settings, Instant boot)
    : bus_(bus), settings_(settings), next_sample_(boot), good_at_(boot), byte_at_(boot) {
  SINEW_ASSERT(settings.sample_period > Duration::zero());
  SINEW_ASSERT(settings.stale >= settings.sample_period);
}

void EncoderNode::advance(Instant now) {
  // After a long time without a call there is only one shaft to read, so there is one sample.
  if (now - next_sample_ > settings_.stale) next_sample_ = now;
  while (next_sample_ <= now) {
    sample(next_sample_);
    next_sample_ += settings_.sample_period;
  }
}

/// A reading with its magnet in place.
bool EncoderNode::read_chip(std::uint16_t& position) {
  const auto reading = read_as5600(bus_);
  bus_error_ = !reading;
  if (bus_error_) {
    bus_errors_ = static_cast<std::uint8_t>(std::min(bus_errors_ + 1, 255));
    return false;
  }
  chip_ = *reading;
  position = reading->position;
  return reading->magnet;
}

void EncoderNode::sample(Instant now) {
  std::uint16_t position = 0;
  const bool good = read_chip(position);
  // Asked before this reading counts: a reading after a long gap does not mend the gap.
  if (now - good_at_ > settings_.stale) state_ = State::kBlind;
  if (!good) {
    observer_.coast();
    return;
  }
  good_at_ = now;
  position_ = position;
  if (state_ == State::kBlind) {
    observer_.restart(position);
    state_ = State::kSettling;
    good_samples_ = 0;
    restarted_ = true;
    return;
  }
  observer_.update(position);
  if (state_ == State::kSettling && ++good_samples_ >= kSettleSamples) state_ = State::kSettled;
}

void EncoderNode::receive(std::span<const std::uint8_t> bytes, Instant now) {
  advance(now);
  if (now - byte_at_ > settings_.byte_gap) decoder_.reset();
  byte_at_ = now;
  for (const std::uint8_t byte : bytes) {
    if (const auto request = decoder_.push(byte)) answer(request->name);
  }
}

std::uint16_t EncoderNode::status() const {
  namespace bits = encoder_link::status;
  auto value = static_cast<std::uint16_t>(bus_errors_ << 8);
  if (state_ != State::kBlind) value |= bits::kFresh;
  if (state_ == State::kSettled) value |= bits::kSettled;
  if (chip_.magnet) value |= bits::kMagnet;
  if (chip_.too_weak) value |= bits::kTooWeak;
  if (chip_.too_strong) value |= bits::kTooStrong;
  if (bus_error_) value |= bits::kBusError;
  if (restarted_) value |= bits::kRestarted;
  return value;
}

std::int16_t EncoderNode::per_second(std::int64_t q20, int power) const {
  const double rate = 1 / to_seconds(settings_.sample_period);
  const double ticks = static_cast<double>(q20) * 0x1p-20 * (power == 1 ? rate : rate * rate);
  return encoder_link::saturated(static_cast<std::int64_t>(ticks + (ticks < 0 ? -0.5 : 0.5)));
}

void EncoderNode::answer(Register name) {
  bool silent = state_ != State::kSettled;
  if (name == Register::kPosition) silent = state_ == State::kBlind;
  if (name == Register::kStatus) silent = false;
  if (silent || output_.capacity() - output_.size() < encoder_link::kReplySize) return;
  std::uint16_t value = 0;
  switch (name) {
    case Register::kPosition:
      value = position_;
      break;
    case Register::kVelocity:
      value = static_cast<std::uint16_t>(per_second(observer_.ticks_per_sample_q20(), 1));
      break;
    case Register::kAcceleration:
      value = static_cast<std::uint16_t>(per_second(observer_.ticks_per_sample2_q20(), 2));
      break;
    case Register::kStatus:
      value = status();
      restarted_ = false;
      break;
  }
  for (const std::uint8_t byte : encoder_link::encode(encoder_link::Reply{name, value})) {
    output_.push_back(byte);
  }
}

std::size_t EncoderNode::take_output(std::span<std::uint8_t> out) {
  return output_.take_front(out);
}

}  // namespace sinew
