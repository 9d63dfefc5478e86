#pragma once

#include "sinew/model/dynamics.h"

namespace sinew::sim {

/// A stepper motor as physics has it: the field turns as it is stepped, the rotor follows it like a
/// spring, and slips by whole electrical turns (four full steps) where the load is too much.
///
/// Torque is T(w) sin(Z e) with Z = steps_per_turn / 4 pole pairs, e the angle by which the rotor
/// trails the field, and T(w) the holding torque up to the corner speed of the field and falling as
/// corner/w beyond. Without current only a twentieth of it is left, held by the magnets at every
/// full step. Source: T. Kenjo, Stepping Motors and their Microprocessor Controls, 1984, ch. 2.
///
/// Angles and torques at the motor's shaft, rad and Nm, for all motors of the drive together. @rt
class StepperMotor {
 public:
  /// @param inertia  kg m^2 that turns with the rotor without play, the rotor's own included.
  StepperMotor(const StepperDrive& drive, double inertia, double angle = 0);

  /// Current on or off. The power stage comes back at its home phase, so that the rotor snaps to
  /// the next such place, up to two full steps away.
  void set_power(bool on);
  bool powered() const { return powered_; }
  /// Torque that the supply allows, 1 at its nominal voltage.
  void set_supply_ratio(double ratio) { supply_ratio_ = ratio; }

  /// Turns the field by `turn` (rad), evenly over `dt` (s), against `load` (Nm, positive pushes
  /// the angle up) and a friction of `coulomb` (Nm) and `viscous` (Nm s/rad).
  void advance(double turn, double load, double coulomb, double viscous, double dt);

  /// The rotor is there and turns so fast, rad and rad/s; its field stands where it does.
  void place(double angle, double speed);

  double angle() const { return angle_; }
  double speed() const { return speed_; }  ///< rad/s
  /// Where the rotor would stand without load, had it never slipped.
  double field() const { return field_; }
  /// It lost steps since it was switched on first. Where current comes on, the rotor goes to the
  /// one pole or the other; that is no loss, for until then it held none.
  bool slipped() const { return slipped_; }
  /// It stands, the field stands, and nothing would change that.
  bool settled(double load, double coulomb) const;

 private:
  double available_torque(double field_speed) const;
  double pull(double field, double angle) const;

  double pole_pairs_;
  double holding_torque_;
  double corner_speed_;
  double inertia_;
  bool powered_ = true;
  bool slipped_ = false;
  bool in_step_ = true;  ///< it has reached its field since the current came on
  double supply_ratio_ = 1;
  double angle_;
  double speed_ = 0;
  double field_;
};

}  // namespace sinew::sim
