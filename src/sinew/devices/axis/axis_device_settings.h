#pragma once

#include <cstddef>
#include <cstdint>

#include "sinew/core/instant.h"
#include "sinew/core/units.h"
#include "sinew/model/dynamics.h"
#include "sinew/model/robot_model.h"
#include "sinew/motion/cascade.h"
#include "sinew/motion/rest_to_rest.h"

namespace sinew {

/// What emergency_stop() does once the steps are frozen.
enum class EmergencyStopAction : std::uint8_t {
  kHold,      ///< current stays on: a loaded axis does not fall
  kPowerOff,  ///< current off; the axis may fall
};

/// How the two encoders of an axis are read.
struct AxisEncoderSettings {
  JointEncoder joint = JointEncoder::kQuadrature;
  bool joint_node = false;              ///< a joint AS5600 is read over RS-485, by its node
  double joint_counts_per_turn = 2400;  ///< of the joint, signed: negative counts backwards
  double motor_counts_per_turn = 4096;  ///< of the motor shaft, signed
  double gear_ratio = 17;
  /// No shaft turns faster; rad/s of the joint. A reading that would need more is a glitch.
  double speed_max = from_deg(200);
  /// Without a good reading for longer, the turns are no longer known. In this time the motor
  /// turns by less than half a turn at speed_max: 0.19 of one.
  Duration gap_max = std::chrono::milliseconds(20);
};

/// The search for the end stop. Angles in the model's frame, rad.
struct HomingSettings {
  double direction = -1;    ///< of the search: -1 towards lower angles
  double end_stop_angle{};  ///< where the switch closes, approached slowly in `direction`
  /// At least. axis_settings() takes the highest speed from which the axis stops within 1.64 deg,
  /// once the debounced switch is closed. The mechanical end must be farther behind the switch.
  double approach_speed = from_deg(3);
  double slow_speed = from_deg(0.5);
  double back_off = from_deg(3);      ///< beyond the place where the switch closed
  double back_off_max = from_deg(8);  ///< still closed after that: stuck
  double clear_angle{};               ///< where it rests when homed; inside the limits
  double travel_max{};                ///< farthest search: the whole way between the ends, and some
  Duration debounce = std::chrono::milliseconds(10);  ///< as the first firmware had it
};

/// When something counts as wrong.
struct AxisSupervision {
  /// Following error, rad, and for how long. A stepper that follows is within a quarter of an
  /// electrical turn, 0.11 deg at the joint; backlash is 0.2.
  double following_error = from_deg(1.5);
  Duration following_time = std::chrono::milliseconds(50);
  /// Motor shaft against microsteps, rad of the motor: half an electrical turn of a 200-step
  /// motor, beyond which the rotor hangs on to another pole.
  double stall_angle = from_deg(3.6);
  Duration stall_time = std::chrono::milliseconds(5);
  /// Joint encoder against motor encoder, rad of the joint: backlash 0.2 deg, a count 0.15 deg,
  /// and as much again for a printed gear.
  double disagreement = from_deg(1.0);
  Duration disagreement_filter = std::chrono::milliseconds(50);
  double supply_min = 18;       ///< V; motors of a 24 V supply lose torque below
  double supply_off = 9;        ///< V; no current in the windings below
  double temperature_max = 90;  ///< deg C at the power stage
  Duration supply_time = std::chrono::milliseconds(20);
};

/// Everything that an axis controller must know about its axis; angles of the joint in the model's
/// frame, rad.
struct AxisSettings {
  double lower = 0;  ///< position limits
  double upper = 0;
  motion::AxisLimits limits;  ///< of every profile; velocity is within reach of step_rate_max
  /// Of track() alone: arrivals that jitter, lost setpoints and rounding cost jerk that the stream
  /// itself does not have. Velocity and acceleration keep `limits`.
  double tracking_jerk = 0;
  double gear_ratio = 17;
  double backlash = 0;  ///< rad at the joint, whole gap
  /// rad at the joint by which the gear gives under all that its motor can hold. ASSUMED, as
  /// docs/simulation.md says.
  double give = from_deg(0.1);
  double full_steps_per_turn = 200;
  double microsteps = 16;
  double step_rate_max = 5000;  ///< microsteps/s
  AxisEncoderSettings encoders;
  HomingSettings homing;
  motion::CascadeSettings cascade;
  AxisSupervision supervision;
  EmergencyStopAction emergency_stop = EmergencyStopAction::kHold;
  /// rad, nearer than this it has arrived: weight and one count leave up to 0.15 deg
  /// (docs/closed_loop.md).
  double position_tolerance = from_deg(0.2);

  /// rad, at most, between the joint at rest and what the motor's encoder says of it.
  double uncertainty() const;

  double steps_per_rad() const { return full_steps_per_turn * microsteps * gear_ratio / (2 * kPi); }
};

/// The settings of one joint of a model; gear, motor and joint encoder are the model's where it has
/// dynamics, else the 17:1 gear, the 200 x 16 steps and the quadrature of robot-arm-2's shoulder.
AxisSettings axis_settings(const RobotModel& model, std::size_t joint);

}  // namespace sinew
