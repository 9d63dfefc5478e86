#include "firmware/emulation_avr/mega_arm.h"

#include <algorithm>

namespace sinew::emulation {

void MegaArm::advance(Instant now) {
  now_ = now;
  board_.run_until(MegaBoard::kStart + (now - Instant{}));
  const mcu::Bytes heard = board_.take_output();
  output_.insert(output_.end(), heard.begin(), heard.end());
}

sim::Truth MegaArm::truth() const {
  sim::Truth truth;
  for (std::size_t i = 0; i < joints_.size(); ++i) {
    const double q = static_cast<double>(board_.steps(i)) / joints_[i].steps_per_rad;
    truth.joints.push_back({.q = q, .believed = q});
  }
  return truth;
}

void MegaArm::receive(std::span<const std::uint8_t> bytes, Instant now) {
  advance(now);
  board_.send(bytes);
}

std::size_t MegaArm::take_output(std::span<std::uint8_t> out) {
  const std::size_t size = std::min(out.size(), output_.size());
  std::copy_n(output_.begin(), size, out.begin());
  output_.erase(output_.begin(), output_.begin() + static_cast<std::ptrdiff_t>(size));
  return size;
}

}  // namespace sinew::emulation
