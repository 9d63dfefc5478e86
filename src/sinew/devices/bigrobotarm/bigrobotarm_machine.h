#pragma once

#include <array>
#include <cstdint>
#include <memory>

#include "sinew/devices/bigrobotarm/bigrobotarm_device.h"
#include "sinew/devices/bigrobotarm/bigrobotarm_settings.h"
#include "sinew/sim/arm_load.h"
#include "sinew/sim/machine.h"
#include "sinew/sim/stepper_motor.h"

namespace sinew::sim {

/// Drives and masses of the BigRobotArm; gears and microsteps follow from its settings, everything
/// else is ASSUMED, each number with its reason in the source.
Dynamics big_robot_arm_dynamics(const BigRobotArmDevice& device);

/// The BigRobotArm: its firmware, five stepper motors with their gears, and the arm's weight.
///
/// At power-up it stands upright, each motor up to two full steps beside it, where the power stage
/// caught it; no sensor tells. Below 7 V the board and its motors are off; when power comes back
/// the counters are 0 wherever the arm stands, and the motors snap up to two full steps. A port
/// that opens pulls the board's reset line, with the same outcome.
///
/// A mechanical end (10 deg beyond each limit, or a block) pushes back like rubber, as hard as a
/// tick of 1 ms allows. Costs nothing while it stands. All chance comes from the seed. @rt apart
/// from construction.
class BigRobotArmMachine : public ByteMachine {
 public:
  /// @param robot  its device is a BigRobotArmDevice with the wire that is simulated; masses and
  ///               motors are big_robot_arm_dynamics() where the robot says nothing.
  BigRobotArmMachine(const RobotModel& robot, BigRobotArmProfile profile,
                     BigRobotArmDialect dialect, std::uint64_t seed, Instant boot);

  /// A host opened the port: on a board whose reset line hangs on DTR it starts again, and hears
  /// nothing for 1.5 s.
  void port_opened(Instant now);

  void advance(Instant now) override;
  std::optional<Instant> next_event() const override;
  Truth truth() const override;
  void disturb(const Disturbance& what) override;
  /// Motor shafts; the board has nothing that lasts.
  LastingState lasting_state() const override;
  bool restore(const LastingState& state) override;
  void receive(std::span<const std::uint8_t> bytes, Instant now) override;
  std::size_t take_output(std::span<std::uint8_t> out) override;

  const BigRobotArmBoard& firmware() const { return *firmware_; }
  Instant now() const { return now_; }

 private:
  struct Axis {
    Axis(const StepperDrive& stepper, double joint_inertia, double ratio, double angle);

    StepperDrive drive;
    double inertia;          ///< kg m^2 at the motor
    double joint_per_motor;  ///< signed
    double lower = 0;        ///< rad of the joint, mechanical ends
    double upper = 0;
    double extra_torque = 0;  ///< Nm at the joint
    double pulses = 0;        ///< of the firmware that the field has followed
    StepperMotor motor;

    double q() const { return motor.angle() * joint_per_motor; }
    double contact_torque() const;  ///< Nm at the motor
    double load(double weight) const;
  };

  static std::array<Axis, bigrobotarm::kJoints> make_axes(const RobotModel& robot,
                                                          const Dynamics& dynamics, ArmLoad& load,
                                                          std::uint64_t seed);
  void tick(Instant end);
  bool at_rest() const;  ///< nothing will happen by itself
  bool turning() const;
  void update_load();
  void restart(Duration deaf, bool power);
  bool supplied() const;

  const BigRobotArmDevice device_;
  std::unique_ptr<BigRobotArmBoard> firmware_;
  std::array<double, bigrobotarm::kJoints> lower_{};
  std::array<double, bigrobotarm::kJoints> upper_{};
  ArmLoad load_;
  std::array<Axis, bigrobotarm::kJoints> axes_;
  double volts_;
  Instant now_;
  Instant ticked_;  ///< the motors have lived up to here
};

}  // namespace sinew::sim
