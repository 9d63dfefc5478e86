#pragma once

#include <cstdint>

#include "sinew/core/fixed_vector.h"
#include "sinew/core/units.h"
#include "sinew/core/vec3.h"
#include "sinew/model/device.h"

namespace sinew {

/// What turns with the joint itself, behind the gear.
enum class JointEncoder : std::uint8_t {
  kNone,        ///< the motor's encoder is not checked by a second one
  kQuadrature,  ///< incremental, 600 pulses = 2400 counts per turn; a free running counter
  kAs5600,      ///< 4096 positions per turn
};

/// The stepper motors and the gear of one joint. SI; torques of one motor at its own shaft.
struct StepperDrive {
  double holding_torque = 0;  ///< Nm
  int motors = 1;             ///< on one gear, stepped together
  double gear_ratio = 1;      ///< motor turns per joint turn; rad per m for a spindle
  double gear_efficiency = 1;
  double steps_per_turn = 200;  ///< full steps
  double microsteps = 16;       ///< per full step
  double rotor_inertia = 0;     ///< kg m^2, one motor
  /// Motor speed, rad/s, up to which it has its full torque; beyond, torque falls as corner/speed.
  double corner_speed = 0;
  double coulomb_friction = 0;  ///< Nm at the joint; N at a leg, and so on below
  double viscous_friction = 0;  ///< Nm s/rad at the joint
  double backlash = 0;          ///< rad at the joint, whole gap
  JointEncoder joint_encoder = JointEncoder::kNone;

  double steps_per_rad() const { return steps_per_turn * microsteps * gear_ratio / (2 * kPi); }
};

/// A hobby servo with its gear inside, as data sheets give it: torque falls in a straight line from
/// stall to no load. At the horn.
struct ServoRating {
  double stall_torque = 0;   ///< Nm, nominal supply
  double no_load_speed = 0;  ///< rad/s, nominal supply
  double friction = 0;       ///< Nm
};

/// One link, in the frame that its DH row ends with. Upper arm and forearm of a palletizer: x from
/// the link's near joint to its far one, y upwards in the arm's plane, origin in the far one; its
/// base: B turned with the arm, which points along -y. A hexapod's platform: P.
struct LinkMass {
  double mass = 0;  ///< kg
  Vec3 p_JC;        ///< centre of mass C in the link's frame, m
  Vec3 inertia;     ///< about C along the frame's axes, kg m^2
};

/// How stiffly an axis board holds its joint to the reference; docs/closed_loop.md says how they
/// are chosen.
struct AxisGains {
  double position_gain = 0;  ///< 1/s
  double velocity_gain = 0;  ///< share of a velocity error that is added to the rate
  double integral_gain = 0;  ///< 1/s
};

/// One entry per joint, or none at all; drives or servos, never both.
struct Dynamics {
  FixedVector<StepperDrive, kMaxJoints> drives;
  FixedVector<ServoRating, kMaxJoints> servos;
  FixedVector<LinkMass, kMaxJoints> links;   ///< one for a hexapod: its platform
  FixedVector<AxisGains, kMaxJoints> gains;  ///< of boards that close their own loop
};

}  // namespace sinew
