#pragma once

#include <optional>
#include <span>

#include "sinew/devices/grbl/grbl_device.h"
#include "sinew/devices/grbl/grbl_settings.h"
#include "sinew/sim/machine.h"

namespace sinew::sim {

/// An arm of steppers on a board that speaks GRBL. Its joints stand where their motors' steps put
/// them, until something is in their way or a motion is cut off: then steps are lost, and the board
/// does not know. Its switches close 1 unit beyond the joints' limits. @rt
class GrblMachine : public ByteMachine {
 public:
  /// @param robot  with a GrblDevice
  GrblMachine(const RobotModel& robot, Instant boot);

  void advance(Instant now) override;
  std::optional<Instant> next_event() const override { return board_.next_event(); }
  Truth truth() const override;
  /// kSupply, kBlock, kUnblock and kProbe.
  void disturb(const Disturbance& what) override;
  LastingState lasting_state() const override;
  bool restore(const LastingState& state) override;
  void receive(std::span<const std::uint8_t> bytes, Instant now) override;
  std::size_t take_output(std::span<std::uint8_t> out) override { return board_.take_output(out); }

 private:
  struct Body {
    double base = 0;  ///< rad: the joint where its motor has turned by 0
    double q = 0;
    double lost = 0;      ///< rad, since the board counts
    double lower, upper;  ///< between what is in its way
    double touches;       ///< where something closes the probe input, and beyond
    bool touches_above;   ///< .. which is where it grows to
  };

  void follow();
  void skid();
  void forget_lost();

  FixedVector<Joint, kMaxJoints> joints_;
  GrblDevice device_;
  grbl::GrblDevice board_;
  FixedVector<Body, kMaxJoints> bodies_;
  FixedVector<double, kMaxJoints> speeds_;  ///< rad/s, a tick before
  double supply_volts_ = 0;
  bool homing_ = false;
  Instant now_;
};

}  // namespace sinew::sim
