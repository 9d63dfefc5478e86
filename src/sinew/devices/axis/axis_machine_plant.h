#pragma once

#include <cstdint>
#include <optional>

#include "sinew/core/split_mix.h"
#include "sinew/core/units.h"
#include "sinew/devices/axis/axis_device.h"
#include "sinew/devices/axis/axis_machine_quadrature.h"
#include "sinew/devices/encoder/as5600_machine.h"
#include "sinew/model/dynamics.h"
#include "sinew/sim/stepper_motor.h"

namespace sinew::sim {

/// What one axis is built of. docs/simulation.md says of each number where it comes from.
struct AxisPlantSettings {
  StepperDrive drive;
  double end_lower = from_deg(-180);  ///< rad, mechanical ends
  double end_upper = from_deg(180);
  double switch_angle = from_deg(-175);  ///< rad: here the end stop closes
  double switch_direction = -1;          ///< -1: it is closed below that angle, 1: above
  bool joint_as5600 = false;             ///< else 600 PPR quadrature; both on the joint's axis
  double windup = from_deg(0.1);         ///< rad by which the gear gives under its stall torque
  double supply_nominal = 24;            ///< V
  double brown_out = 10;                 ///< V: below, board and power stage are off
  double ambient = 25;                   ///< deg C
};

/// One joint as physics has it: stepper motor, gear with backlash, friction and losses, the joint
/// with its load, mechanical ends, a switch near the lower one, encoders, supply and heat. It turns
/// an AxisController's outputs into its inputs, and it alone knows the truth.
///
/// Two bodies, rotor and joint, touch each other through the gear when its play is used up, as a
/// damped spring that only pushes. Losses of the gear are dry friction in proportion to what it
/// carries: (1/efficiency - 1) |torque|, so that the motor gets `efficiency` through to the joint
/// and the joint 2 - 1/efficiency back to the motor. Source: as for any self-braking gear,
/// G. Niemann, Maschinenelemente II, ch. 21. @rt
class AxisPlant {
 public:
  /// Without current, at rest at `q`.
  AxisPlant(const AxisPlantSettings& settings, double q, std::uint64_t seed);

  /// What the rest of the arm does to it from now on: Nm, positive pushes q up; kg m^2.
  void set_load(double torque, double inertia);
  void set_extra_load(double torque) { extra_load_ = torque; }
  /// V from now on. Below `brown_out` there is no current, whatever the outputs say.
  void set_supply(double volts) { supply_ = volts; }
  /// A thing in the way: from where it is now, the joint cannot pass `q`.
  void block(double q);
  void unblock();
  /// Field of the magnet on the motor's shaft, or on the joint's where that has one; 1 is right.
  void set_field(double field);
  /// The coupling (the magnet's seat) between the joint and its encoder. One that slips leaves the
  /// encoder's shaft where it is; one that holds again takes it along from there.
  void set_coupling(bool holds);
  /// deg C around it from now on: a heat gun.
  void set_ambient(double celsius) { settings_.ambient = celsius; }
  /// A finger on the end stop's lever, whatever the joint does; false lets it go.
  void hold_switch(bool held) { switch_held_ = held; }

  /// Joint and rotor are there and turn so fast; rad and rad/s, the rotor at its own shaft.
  void place(double q, double qd, double rotor, double rotor_speed);
  /// The board starts again: its step count and its quadrature counter stand at 0.
  void reboot();
  /// Lets `dt` (s) pass, in which the steps are made evenly.
  void advance(const AxisOutputs& outputs, double dt);
  AxisInputs inputs() const;
  /// The sensor on the joint's shaft, where it has one.
  As5600& joint_sensor() { return joint_sensor_; }

  double q() const { return q_; }
  double qd() const { return qd_; }
  bool stalled() const { return motor_.slipped(); }
  bool powered() const { return motor_.powered(); }
  /// It leans against an end or a thing in the way.
  bool at_end() const { return at_end_; }
  bool resting() const { return resting_; }
  bool browned_out() const { return supply_ < settings_.brown_out; }
  double motor_angle() const { return motor_.angle(); }  ///< rad at the motor's shaft
  double motor_speed() const { return motor_.speed(); }  ///< rad/s there
  /// J in the motion of rotor and joint and in what is wound up, gear and ends; without weight.
  double mechanical_energy() const;

 private:
  double gear_torque() const;
  double end_torque() const;
  double joint_torque(double gear) const;
  bool at_rest(double turn) const;
  void step(double turn, double h);
  void read_sensors(double dt);
  void read_switch(double dt);

  AxisPlantSettings settings_;
  SplitMix64 random_;
  StepperMotor motor_;
  double rotor_inertia_;
  double stall_torque_;  ///< Nm at the joint
  double stiffness_;     ///< Nm/rad at the joint

  double q_;
  double qd_ = 0;
  double load_ = 0;
  double inertia_;
  double extra_load_ = 0;
  double supply_;
  double lower_;  ///< rad: end or thing in the way
  double upper_;
  bool at_end_ = false;
  bool resting_ = false;
  double temperature_;
  std::int64_t steps_ = 0;

  /// rad: the shaft of the joint's encoder.
  double joint_shaft() const { return coupled_ ? q_ + joint_slip_ : slipping_at_; }

  double motor_mounting_;  ///< rad by which the sensors are turned on their shafts
  double joint_mounting_;
  As5600 motor_sensor_;
  As5600 joint_sensor_;
  Quadrature quadrature_;
  bool coupled_ = true;
  double joint_slip_ = 0;   ///< rad by which the encoder's shaft has come off the joint
  double slipping_at_ = 0;  ///< where it stands while nothing takes it along
  bool switch_held_ = false;
  bool switch_pressed_ = false;
  bool switch_level_ = false;
  double bounce_left_ = 0;  ///< s
};

}  // namespace sinew::sim
