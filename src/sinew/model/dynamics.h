#pragma once

#include "sinew/core/fixed_vector.h"
#include "sinew/core/units.h"
#include "sinew/core/vec3.h"
#include "sinew/model/device.h"

namespace sinew {

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
  double coulomb_friction = 0;  ///< Nm at the joint
  double viscous_friction = 0;  ///< Nm s/rad at the joint
  double backlash = 0;          ///< rad at the joint, whole gap
};

/// One link, in the frame that its DH row ends with.
struct LinkMass {
  double mass = 0;  ///< kg
  Vec3 p_JC;        ///< centre of mass C in the link's frame, m
  Vec3 inertia;     ///< about C along the frame's axes, kg m^2
};

/// One entry per joint, or none at all.
struct Dynamics {
  FixedVector<StepperDrive, kMaxJoints> drives;
  FixedVector<LinkMass, kMaxJoints> links;
};

}  // namespace sinew
