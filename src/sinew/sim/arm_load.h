#pragma once

#include <array>
#include <span>

#include "sinew/kinematics/arm_dynamics.h"
#include "sinew/model/dynamics.h"
#include "sinew/model/robot_model.h"

namespace sinew::sim {

/// What the links of a serial arm and its payload do to each joint's axis: the torque of their
/// weight, and the inertia that the joint has to turn while the others stand still.
///
/// Inertia is element (i, i) of the mass matrix, which does not depend on q_i. Torques that one
/// joint's acceleration puts on another are left out: at 10 deg/s^2 they are below 1 % of the
/// weight's. Both from kinematics/arm_dynamics. @rt apart from construction.
class ArmLoad {
 public:
  /// @param dynamics  one link per row of the chain, or none: a weightless arm.
  ArmLoad(const SerialGeometry& geometry, const Dynamics& dynamics);

  /// A point mass at the tool point, kg.
  void set_payload(double mass) { arm_.set_payload(mass); }
  double payload() const { return arm_.payload().mass; }

  /// @param q  rad, one per joint. What follows speaks of this configuration.
  void update(std::span<const double> q);

  /// Nm on joint i by weight; positive pushes q up.
  double torque(std::size_t i) const { return torque_[i]; }
  /// kg m^2 that joint i turns, rotors not counted.
  double inertia(std::size_t i) const { return inertia_[i]; }
  /// J, zero with all masses at the height of the base's origin.
  double potential_energy() const { return potential_energy_; }

 private:
  kinematics::ArmDynamics arm_;
  std::array<double, kMaxJoints> torque_{};
  std::array<double, kMaxJoints> inertia_{};
  double potential_energy_ = 0;
};

/// The masses of the robot's file, or those of an arm of hobby servos: assumed, a servo of 60 g and
/// its bracket at each end of a link, and a hand with its gripper.
/// @pre a serial arm
Dynamics masses_of_servo_arm(const RobotModel& model);
/// The arm with its tool point where its jaws hold things.
SerialGeometry tool_at_tips(SerialGeometry geometry);

}  // namespace sinew::sim
