#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "sinew/devices/feetech/feetech_device.h"
#include "sinew/devices/feetech/feetech_settings.h"
#include "sinew/model/robot_model.h"
#include "sinew/sim/arm_load.h"
#include "sinew/sim/machine.h"
#include "sinew/sim/servo_motor.h"

namespace sinew::sim {

/// An arm of servos on Feetech's bus: one a joint, one for the jaws, weight on the joints, motors
/// that grow warm, and a supply. It begins held near its home, as a program before has left it;
/// behind a loss of power its motors are off and it falls.
///
/// A Disturbance means: kSupply its volts, kPayload kg at the tips, kBlock and kUnblock a joint or,
/// with the number behind the last joint, a thing of so many m between the jaws, kLoad Nm on a
/// joint, kLead a servo's plug: 0 is out. @rt apart from its construction.
class FeetechMachine : public ByteMachine {
 public:
  static constexpr double kBrownOutVolts = 3.5;  ///< assumed: below, servos forget

  /// @param model  a serial arm with FeetechDevice settings, asserted
  /// @param seed   of the pose at power-up
  FeetechMachine(const RobotModel& model, std::uint64_t seed, Instant boot);

  void advance(Instant now) override;
  std::optional<Instant> next_event() const override { return std::nullopt; }
  Truth truth() const override;
  void disturb(const Disturbance& what) override;
  LastingState lasting_state() const override;
  bool restore(const LastingState& state) override;
  void receive(std::span<const std::uint8_t> bytes, Instant now) override;
  std::size_t take_output(std::span<std::uint8_t> out) override;

  FeetechBusDevice& bus() { return bus_; }
  /// deg C, of a servo's motor.
  void warm(std::size_t i, double heat) { heat_[i] = heat; }

 private:
  void step(Instant to);
  void sense(double volts);
  void update_load();
  double angle_of(std::size_t i, double units) const;
  double units_of(std::size_t i, double angle) const;
  bool is_jaws(std::size_t i) const { return i == joints_; }

  FeetechDevice device_;
  std::size_t joints_;
  double width_max_ = 0;
  double jaw_span_ = 0;  ///< rad of the jaws' servo from closed to open
  FeetechBusDevice bus_;
  std::vector<ServoMotor> motors_;  ///< joints, then the jaws; as many as at construction
  ArmLoad load_;
  std::array<double, kMaxJoints> extra_load_{};  ///< Nm
  std::array<double, kMaxJoints> heat_{};        ///< deg C
  double volts_;
  bool powered_ = true;
  std::uint64_t bytes_lost_ = 0;
  Instant now_;
  Instant load_due_;
};

}  // namespace sinew::sim
