#include "sinew/devices/encoder/as5600_machine.h"

#include <algorithm>
#include <cmath>

#include "sinew/core/units.h"

namespace sinew::sim {
namespace {

/// First-order lag that has settled to 1 % after the data sheet's 2.2 ms (its own filter is a
/// running mean of which nothing more is published).
constexpr double kTimeConstant = 2.2e-3 / 4.6;          // s
constexpr double kNoise = 0.015 / 360 * As5600::kTurn;  // counts rms, slow filter x16
constexpr double kUndetected = 0.25, kWeak = 0.5, kStrong = 2;

}  // namespace

As5600::As5600(double angle, std::uint64_t seed) : random_(seed), filtered_(angle), input_(angle) {
  turn_to(angle, 0);
}

double As5600::noise() {
  // Three uniform numbers: near enough to normal, and never beyond 3 sigma as real filters are.
  return random_.uniform(-1, 1) + random_.uniform(-1, 1) + random_.uniform(-1, 1);
}

void As5600::turn_to(double angle, double dt) {
  if (dt > 0) {
    // A first-order lag behind an even turn, exactly: it trails by speed x time constant.
    const double trail = (angle - input_) / dt * kTimeConstant;
    const double kept = std::exp(-dt / kTimeConstant);
    filtered_ = angle - trail + (filtered_ - input_ + trail) * kept;
  }
  input_ = angle;
  const double sigmas = field_ < kUndetected ? kTurn : kNoise / std::min(field_, 1.0);
  const double counts = filtered_ / (2 * kPi) * kTurn + noise() * sigmas;
  const double turns = std::floor(counts / kTurn);
  counts_ = static_cast<std::uint16_t>(static_cast<int>(counts - turns * kTurn) & 0xFFF);
}

bool As5600::has_register(std::uint8_t address) {
  return address <= 0x08 || (address >= 0x0B && address <= 0x0F) ||
         (address >= 0x1A && address <= 0x1C) || address == 0xFF;
}

std::uint8_t As5600::status() const {
  std::uint8_t status = field_ >= kUndetected ? kMagnetDetected : 0;
  if (field_ < kWeak) status |= kMagnetTooWeak;
  if (field_ > kStrong) status |= kMagnetTooStrong;
  return status;
}

std::uint8_t As5600::register_value(std::uint8_t address) const {
  // The gain goes against the field, in the middle of 0..128 (3.3 V) for a good magnet.
  const double gain = std::clamp(64 / std::max(field_, 1e-3), 0.0, 128.0);
  const double magnitude = std::clamp(2048 * field_ * gain / 64, 0.0, 4095.0);
  switch (static_cast<Register>(address)) {
    case Register::kStatus:
      return status();
    case Register::kRawAngle:
    case Register::kAngle:
      return static_cast<std::uint8_t>(counts_ >> 8);
    case Register::kAgc:
      return static_cast<std::uint8_t>(gain);
    case Register::kMagnitude:
      return static_cast<std::uint8_t>(static_cast<int>(magnitude) >> 8);
  }
  constexpr std::uint8_t kRawLow = 0x0D, kAngleLow = 0x0F, kMagnitudeLow = 0x1C;
  if (address == kRawLow || address == kAngleLow) return static_cast<std::uint8_t>(counts_ & 0xFF);
  if (address == kMagnitudeLow)
    return static_cast<std::uint8_t>(static_cast<int>(magnitude) & 0xFF);
  return 0;  // settings of a new chip, and addresses that it does not have
}

void As5600::set_pointer(std::uint8_t address) {
  pointer_ = address;
  latched_ = false;
}

std::uint8_t As5600::read_byte() {
  const auto is_high_byte = [](std::uint8_t address) {
    return address == static_cast<std::uint8_t>(Register::kRawAngle) ||
           address == static_cast<std::uint8_t>(Register::kAngle) ||
           address == static_cast<std::uint8_t>(Register::kMagnitude);
  };
  const bool low_of_pair = is_high_byte(static_cast<std::uint8_t>(pointer_ - 1));
  const bool was_latched = latched_;
  const std::uint8_t value = low_of_pair && was_latched ? low_byte_ : register_value(pointer_);
  latched_ = is_high_byte(pointer_);
  if (latched_) low_byte_ = register_value(static_cast<std::uint8_t>(pointer_ + 1));
  // "Only where the pointer was set to the high byte": reading the low byte alone goes on.
  pointer_ = static_cast<std::uint8_t>(low_of_pair && was_latched ? pointer_ - 1 : pointer_ + 1);
  return value;
}

bool As5600Bus::write(std::uint8_t address, std::span<const std::uint8_t> bytes) {
  if (stuck_ || address != As5600::kAddress) return false;
  if (bytes.empty()) return true;
  chip_.set_pointer(bytes[0]);
  // Settings are not modelled: bytes behind the pointer are acknowledged and forgotten.
  return As5600::has_register(bytes[0]);
}

bool As5600Bus::read(std::uint8_t address, std::span<std::uint8_t> out) {
  if (stuck_ || address != As5600::kAddress) return false;
  for (std::uint8_t& byte : out) byte = chip_.read_byte();
  return true;
}

}  // namespace sinew::sim
