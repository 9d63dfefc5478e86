#pragma once

#include <array>
#include <span>

#include "sinew/kinematics/serial_chain.h"
#include "sinew/model/dynamics.h"
#include "sinew/model/robot_model.h"

namespace sinew::sim {

/// What the links of a serial arm and its payload do to each joint's axis: the torque of their
/// weight, and the inertia that the joint has to turn while the others stand still.
///
/// Weight: torque i = z_i . sum over k >= i of (C_k - p_i) x m_k g. Inertia: element (i, i) of the
/// mass matrix, which does not depend on q_i. Torques that one joint's acceleration puts on another
/// are left out: at 10 deg/s^2 they are below 1 % of the weight's. Source: R. Featherstone, Rigid
/// Body Dynamics Algorithms, 2008, ch. 6. @rt apart from construction.
class ArmLoad {
 public:
  /// @param dynamics  one link per row of the chain, or none: a weightless arm.
  ArmLoad(const SerialGeometry& geometry, const Dynamics& dynamics);

  /// A point mass at the tool point, kg.
  void set_payload(double mass) { payload_ = mass; }
  double payload() const { return payload_; }

  /// @param q  rad, one per joint. What follows speaks of this configuration.
  void update(std::span<const double> q);

  /// Nm on joint i by weight; positive pushes q up.
  double torque(std::size_t i) const { return torque_[i]; }
  /// kg m^2 that joint i turns, rotors not counted.
  double inertia(std::size_t i) const { return inertia_[i]; }
  /// J, zero with all masses at the height of the base's origin.
  double potential_energy() const { return potential_energy_; }

 private:
  struct Body {
    double mass = 0;
    Vec3 p_BC;
    Rotation R_BC;
    Vec3 inertia;  ///< about C along the axes of R_BC
  };
  void place(std::span<const double> q);

  kinematics::SerialChain chain_;
  FixedVector<LinkMass, kMaxJoints> links_;
  Vec3 p_FT_;
  double payload_ = 0;

  std::array<Vec3, kMaxJoints> axis_;    ///< z of the frame that joint i turns about, in the base
  std::array<Vec3, kMaxJoints> origin_;  ///< of that frame
  FixedVector<Body, kMaxJoints + 1> bodies_;
  std::array<double, kMaxJoints> torque_{};
  std::array<double, kMaxJoints> inertia_{};
  double potential_energy_ = 0;
};

/// Drives and masses of robot-arm-2. Torques, motors per joint, gear and microsteps are its
/// author's; everything else is ASSUMED, each number with its reason in the source.
Dynamics robot_arm_2_dynamics();

}  // namespace sinew::sim
