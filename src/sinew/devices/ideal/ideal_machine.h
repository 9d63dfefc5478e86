#pragma once

#include <cstdint>
#include <optional>
#include <span>

#include "sinew/devices/ideal/ideal_device.h"
#include "sinew/sim/machine.h"

namespace sinew::sim {

/// Any robot with the ideal device: no weight, no friction, no noise. What befalls a machine from
/// outside still does: something in a joint's way or between its jaws, and a supply that goes away.
/// @rt
class IdealMachine : public ByteMachine {
 public:
  IdealMachine(const RobotModel& robot, Instant boot);

  void advance(Instant now) override;
  std::optional<Instant> next_event() const override { return std::nullopt; }
  Truth truth() const override;
  /// kSupply, kBlock and kUnblock; nothing else reaches it.
  void disturb(const Disturbance& what) override;
  /// The joints; the device remembers nothing.
  LastingState lasting_state() const override;
  bool restore(const LastingState& state) override;
  void receive(std::span<const std::uint8_t> bytes, Instant now) override;
  std::size_t take_output(std::span<std::uint8_t> out) override { return output_.take_front(out); }

 private:
  bool powered() const;

  ideal::IdealDevice device_;
  ideal::LineDecoder decoder_;
  FixedVector<std::uint8_t, 4 * ideal::kLineMax> output_;
  double supply_volts_;
  std::uint64_t bytes_lost_ = 0;
};

}  // namespace sinew::sim
