#pragma once

#include <array>
#include <span>

#include "sinew/kinematics/arm_dynamics.h"
#include "sinew/kinematics/palletizer.h"
#include "sinew/model/dynamics.h"

namespace sinew::kinematics {

/// Masses of a four-bar palletizer: base, upper arm, forearm, and a payload at the nozzle, which
/// the linkage never tilts. The thin rods of the linkage count with the links that they follow.
/// Torques by virtual work; docs/torque.md, eq. (7) to (10). @rt
class PalletizerDynamics {
 public:
  /// @param links  base, upper arm, forearm in the frames that LinkMass names; or none.
  PalletizerDynamics(const PalletizerGeometry& geometry, std::span<const LinkMass> links);

  /// @param mass  kg, >= 0, at the nozzle
  void set_payload(double mass) { payload_ = mass; }

  /// Nm that each servo has to give, positive where it pushes its angle up.
  /// @param q        rad, as the firmware counts them
  /// @param gravity  m/s^2 along -z of the base
  JointVector torque(std::span<const double> q, const JointMotion& motion,
                     double gravity = kGravity) const;

  /// J, zero with all masses at the height of the base's origin.
  double potential_energy(std::span<const double> q, double gravity = kGravity) const;

 private:
  /// One body in the frame that turns with the base: r outwards, s to its left, z up. Its centre
  /// is at start + upper + fore, of which `upper` turns with the shoulder and `fore` with the
  /// forearm's servo.
  struct Body {
    double mass = 0;
    Vec3 inertia;  ///< about the centre along the axes of R
    Rotation R;
    Vec3 start, upper, fore;
    std::size_t tilts_with = 0;  ///< joint; 0 where it never tilts
    Vec3 centre() const { return start + upper + fore; }
  };
  std::array<Body, 4> bodies(std::span<const double> q) const;

  PalletizerGeometry geometry_;
  FixedVector<LinkMass, kPalletizerJoints> links_;
  double payload_ = 0;
};

}  // namespace sinew::kinematics
