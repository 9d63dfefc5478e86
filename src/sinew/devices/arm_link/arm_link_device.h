#pragma once

#include <optional>

#include "sinew/core/fixed_vector.h"
#include "sinew/devices/bigrobotarm/bigrobotarm_device_board.h"
#include "sinew/devices/bigrobotarm/bigrobotarm_settings.h"
#include "sinew/mcu/arm_board.h"

namespace sinew {

/// The board with our firmware: the very program that is flashed (mcu/arm_board.h), with simulated
/// interrupts. docs/firmware/bigrobotarm.md. @rt apart from construction
class ArmLinkBoard final : public BigRobotArmBoard {
 public:
  ArmLinkBoard(const BigRobotArmDevice& settings, Instant boot);

  void restart(Instant now, Duration deaf, bool power) override;
  void receive(std::span<const std::uint8_t> bytes, Instant now) override;
  void advance(Instant now) override;
  std::size_t take_output(std::span<std::uint8_t> out) override;
  std::optional<Instant> next_event() const override;
  bool moving() const override { return board_->motion().moving(); }
  bool deaf() const override { return false; }
  std::array<double, bigrobotarm::kJoints> rotor_steps(Instant now) const override;
  std::array<double, bigrobotarm::kJoints> counted_steps(Instant now) const override;
  bigrobotarm::Gripper gripper() const override;
  std::uint64_t bytes_lost() const override { return bytes_lost_; }
  void set_stop_line(bool low) { stop_line_ = low; }

 private:
  static constexpr std::size_t kPort = 255;  ///< bytes that its port keeps

  bool busy() const;
  void feed();
  void slice();
  std::uint32_t ms() const;

  mcu::ArmBoardFacts facts_{};
  mcu::KeptPositions kept_{};
  std::optional<mcu::ArmBoard> board_;
  FixedVector<std::uint8_t, kPort> port_;
  Instant boot_;
  Instant sliced_;  ///< end of the last millisecond
  Instant deaf_until_{};
  std::uint64_t bytes_lost_ = 0;
  bool stop_line_ = false;
  std::array<double, bigrobotarm::kJoints> rotor_{};  ///< at `sliced_`
};

}  // namespace sinew
