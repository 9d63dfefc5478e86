#pragma once

#include <array>
#include <span>

#include "sinew/core/fixed_vector.h"
#include "sinew/kinematics/serial_chain.h"
#include "sinew/model/dynamics.h"
#include "sinew/model/robot_model.h"

namespace sinew::kinematics {

/// m/s^2, standard; along -z of the base.
inline constexpr double kGravity = 9.80665;

/// A thing in the tool, as a point.
struct PayloadMass {
  double mass = 0;  ///< kg
  Vec3 p_FL;        ///< from the flange's origin, in F, m
};

/// Motion of all joints at one instant; rad/s and rad/s^2 (m/s, m/s^2).
struct JointMotion {
  std::span<const double> qd;
  std::span<const double> qdd;
};

/// The masses of a serial arm at one configuration, and what they ask of its joints. Made by
/// ArmDynamics. Joint torques are Nm (N of a prismatic joint), positive where they push q up. @rt
class PlacedMasses {
 public:
  std::size_t size() const { return size_; }

  /// What each joint has to give so that the arm moves as `motion` says: recursive Newton-Euler
  /// with all vectors in the base. Source: R. Featherstone, Rigid Body Dynamics Algorithms, 2008,
  /// section 5.3; docs/torque.md, eq. (1) to (5). Rotors and friction are the drive's, not here.
  ///
  /// @param gravity  m/s^2 along -z of the base
  JointVector torque(const JointMotion& motion, double gravity = kGravity) const;

  /// What joint i has to give against the weight of the arm at rest.
  double weight(std::size_t i) const;

  /// Element (i, j) of the mass matrix, kg m^2 (kg m, kg of prismatic joints): sum of J_v^T m J_v +
  /// J_w^T I J_w over the bodies behind both joints; docs/torque.md, eq. (6).
  double inertia(std::size_t i, std::size_t j) const;

  /// J, zero with all masses at the height of the base's origin.
  double potential_energy(double gravity = kGravity) const;
  /// J, of links and payload.
  double kinetic_energy(std::span<const double> qd) const;

 private:
  friend class ArmDynamics;
  struct Body {
    double mass = 0;
    Vec3 p_BC;
    Rotation R_BC;
    Vec3 inertia;  ///< about C along the axes of R_BC
  };
  /// How fast joint i moves a point that it carries, per rad/s (m/s).
  Vec3 rate_of(std::size_t i, const Vec3& p_B) const {
    return slides_[i] ? axis_[i] : cross(axis_[i], p_B - origin_[i]);
  }
  /// How fast joint i turns what it carries, per rad/s (m/s).
  Vec3 turn_of(std::size_t i) const { return slides_[i] ? Vec3{} : axis_[i]; }

  /// The first body that joint i moves. The payload is the last one, with or without links.
  std::size_t first_body(std::size_t i) const { return bodies_.size() > size_ ? i : 0; }

  std::size_t size_ = 0;
  std::array<Vec3, kMaxJoints> axis_;  ///< z of the frame that joint i turns about, in the base
  std::array<bool, kMaxJoints> slides_{};
  std::array<Vec3, kMaxJoints> origin_;  ///< of that frame
  FixedVector<Body, kMaxJoints + 1> bodies_;
};

/// Masses of a serial arm: its links, and a payload at the tool. @rt apart from construction.
class ArmDynamics {
 public:
  /// @param links  one per row of the chain, or none: a weightless arm. The payload, none at
  ///               first, sits at the tool point X_FT.p.
  ArmDynamics(const SerialGeometry& geometry, std::span<const LinkMass> links);

  /// @param mass  kg, >= 0, at the tool point
  void set_payload(double mass) { payload_.mass = mass; }
  void set_payload(const PayloadMass& payload) { payload_ = payload; }
  const PayloadMass& payload() const { return payload_; }
  const SerialChain& chain() const { return chain_; }

  /// @param q  rad, one per joint
  PlacedMasses at(std::span<const double> q) const;

 private:
  SerialChain chain_;
  FixedVector<LinkMass, kMaxJoints> links_;
  PayloadMass payload_;
};

}  // namespace sinew::kinematics
