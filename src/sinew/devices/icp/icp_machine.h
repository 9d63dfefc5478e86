#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>

#include "sinew/devices/icp/icp_device.h"
#include "sinew/devices/icp/tmc222_device.h"
#include "sinew/model/robot_model.h"
#include "sinew/sim/machine.h"
#include "sinew/sim/stepper_motor.h"

namespace sinew::sim {

/// The hexapod: its controller, six motor modules, and under each a stepper motor that turns a
/// spindle in a nut, with friction, the leg's share of the weight, and a mechanical end a
/// millimetre beyond either limit. Truth is in metres of leg; `believed` is the way that the field
/// of the motor was turned. Legs start at their home.
///
/// The supply feeds all: modules refuse to position below 7 to 8 V (each its own, by the seed) and
/// lose their RAM below 5 V; the controller restarts when the supply was below 4 V. A motor that
/// rests costs nothing. @rt apart from its construction.
class IcpMachine final : public ByteMachine {
 public:
  static constexpr double kNominalVolts = 12;
  static constexpr double kControllerReset = 4;  ///< V

  /// @param model  with six joints and an IcpDevice; its drives, where it has any.
  IcpMachine(const RobotModel& model, const IcpQuirks& quirks, std::uint64_t seed, Instant boot);

  // The controller refers to the modules beside it.
  IcpMachine(const IcpMachine&) = delete;
  IcpMachine& operator=(const IcpMachine&) = delete;

  void advance(Instant now) override;
  std::optional<Instant> next_event() const override { return controller_.next_event(); }
  Truth truth() const override;
  void disturb(const Disturbance& what) override;
  /// Motor shafts; the modules' OTP is never written.
  LastingState lasting_state() const override;
  bool restore(const LastingState& state) override;
  void receive(std::span<const std::uint8_t> bytes, Instant now) override;
  std::size_t take_output(std::span<std::uint8_t> out) override {
    return controller_.take_output(out);
  }

  /// Supply off and on again, at once.
  void power_cycle();
  const IcpController& controller() const { return controller_; }
  Tmc222& module(std::size_t leg) { return modules_[leg]; }

 private:
  static constexpr std::array<double, 2> kFree{-1e9, 1e9};

  struct Leg {
    double lower() const { return std::max(end_lower, block_lower); }
    double upper() const { return std::min(end_upper, block_upper); }

    StepperDrive drive;
    double start = 0;      ///< m, at angle 0
    double begin = 0;      ///< m, where the field began to be turned
    double sense = 1;      ///< -1: a positive field shortens it
    double end_lower = 0;  ///< m, mechanical ends
    double end_upper = 0;
    double block_lower = kFree[0];  ///< m, a thing in the way
    double block_upper = kFree[1];
    double friction = 0;     ///< Nm at the motor
    double load = 0;         ///< N on this leg alone; positive lengthens it
    std::int64_t field = 0;  ///< of the module, as turned so far
    bool resting = true;
    bool loose = false;  ///< its motor's lead; contact goes with the next motion
    Instant time{};      ///< of the motor
  };

  void wake(std::size_t leg);
  void run_motors(Instant now);
  void run_motor(std::size_t leg, Instant now);
  void set_supply(double volts);
  double length(std::size_t leg, double angle) const;

  Instant now_;
  double volts_ = kNominalVolts;
  double payload_ = 0;  ///< kg on the platform
  std::array<Tmc222, kLegs> modules_;
  IcpController controller_;
  std::array<StepperMotor, kLegs> motors_;
  std::array<Leg, kLegs> legs_;
};

}  // namespace sinew::sim
