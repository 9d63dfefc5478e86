#pragma once

#include <functional>
#include <memory>
#include <vector>

#include "firmware/emulation/emulated_board.h"
#include "sinew/sim/arm_load.h"
#include "sinew/sim/machine.h"

namespace sinew::emulation {

/// An arm of axis boards as sim::StepperArm is one, but that on each board runs the image that is
/// flashed: joints, motors, gears and weight are the simulator's, whatever has a processor is the
/// firmware. All boards are set up for their axis.
class EmulatedArm : public sim::SpiMachine {
 public:
  /// @param start  rad, where the joints stand
  EmulatedArm(Stm32Chip chip, const RobotModel& model, const JointVector& start,
              std::uint64_t seed);

  void advance(Instant now) override;
  std::optional<Instant> next_event() const override { return std::nullopt; }
  sim::Truth truth() const override;
  /// Supply and load reach the axis, all else is not wired here.
  void disturb(const sim::Disturbance& what) override;
  void select(std::uint8_t mask, Instant now) override;
  void shift(std::span<const std::uint8_t> mosi, std::span<std::uint8_t> miso,
             std::uint32_t clock_hz, Instant now) override;
  bool ready_pin(std::size_t /*axis*/) const override { return true; }

  EmulatedBoard& board(std::size_t joint) { return *boards_[joint]; }
  /// Called every millisecond, behind the motion.
  std::function<void()> on_tick = [] {};
  /// The first board whose program did what no program may, and what that was.
  const std::optional<std::string>& broken() const { return broken_; }

 private:
  void run_board(EmulatedBoard& board, Instant until);
  bool is_selected(std::size_t joint) const { return (selected_ >> joint & 1) != 0; }
  void advance_selected(Instant now);
  void tick();

  sim::ArmLoad load_;
  std::vector<std::unique_ptr<EmulatedBoard>> boards_;
  Instant next_tick_;
  std::uint8_t selected_ = 0;
  std::optional<std::string> broken_;
};

}  // namespace sinew::emulation
