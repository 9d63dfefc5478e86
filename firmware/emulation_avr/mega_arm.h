#pragma once

#include <array>
#include <cstdint>
#include <span>

#include "firmware/emulation_avr/mega_board.h"
#include "sinew/devices/bigrobotarm/bigrobotarm_settings.h"
#include "sinew/sim/machine.h"

namespace sinew::emulation {

/// A BigRobotArm whose board is emulated: the image that is flashed, and joints that are where the
/// pulses at its pins say.
class MegaArm final : public sim::ByteMachine {
 public:
  explicit MegaArm(const BigRobotArmJoints& joints) : joints_(joints) {}

  void advance(Instant now) override;
  /// The chip is looked at that often.
  std::optional<Instant> next_event() const override { return now_ + kLook; }
  sim::Truth truth() const override;
  void disturb(const sim::Disturbance& /*what*/) override {}
  void receive(std::span<const std::uint8_t> bytes, Instant now) override;
  std::size_t take_output(std::span<std::uint8_t> out) override;
  MegaBoard& board() { return board_; }

 private:
  static constexpr Duration kLook = std::chrono::milliseconds(1);

  BigRobotArmJoints joints_;
  MegaBoard board_;
  Instant now_{};
  mcu::Bytes output_;
};

}  // namespace sinew::emulation
