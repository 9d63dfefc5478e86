#pragma once

#include <cstdint>
#include <optional>

#include "sinew/devices/encoder/encoder_wire_magnet.h"

namespace sinew {

/// Why an axis controller does not move; bits 8..15 of DIAG_STATUS carry the number.
enum class AxisFault : std::uint8_t {
  kNone = 0,
  kFollowingError = 1,    ///< the joint is too far behind its setpoint
  kStalled = 2,           ///< steps are made and the motor does not turn
  kEncodersDisagree = 3,  ///< joint and motor encoder tell different stories
  kJointEncoder = 4,      ///< no reading: no magnet, broken line
  kMotorEncoder = 5,
  kEndStop = 6,        ///< an end stop closed outside homing
  kHomingTimeout = 7,  ///< the end stop was not reached in time
  kEndStopStuck = 8,   ///< it did not open again
  kSupplyLow = 9,
  kTooHot = 10,
  kLinkSilent = 11,  ///< no good frame within the deadline
  kSelfTest = 12,
};

/// What became of a request to an axis controller.
enum class AxisVerdict : std::uint8_t {
  kAccepted,
  kNotHomed,
  kOutOfLimits,  ///< outside the joint's limits, or not a number
  kFaulted,
  kEmergencyStopped,
  kBusy,  ///< homing or testing itself
};

/// All that an axis controller tells; angles of the joint in the model's frame, rad.
struct AxisStatus {
  double q = 0;   ///< measured
  double qd = 0;  ///< rad/s, measured
  double q_target = 0;
  bool motor_ok = true;
  bool sensor_ok = true;
  bool communication_ok = true;
  bool position_ok = false;  ///< homed, encoders agree, nothing lost
  bool homed = false;
  bool homing = false;
  bool moving = false;
  bool end_stop = false;
  bool emergency_stopped = false;  ///< latched
  AxisFault fault = AxisFault::kNone;
  std::optional<double> supply_volts = std::nullopt;
  std::optional<double> temperature_c = std::nullopt;
  Magnet motor_magnet = Magnet::kUnknown;
  Magnet joint_magnet = Magnet::kUnknown;
};

/// An axis controller as its wire sees it; whatever the wire, these are the words. Nothing here
/// waits: a request is taken or refused at once, and status() tells how it goes on. @rt
class Axis {
 public:
  virtual ~Axis() = default;

  virtual AxisStatus status() const = 0;

  /// Starts (again) or cancels homing against the end stop.
  virtual AxisVerdict home() = 0;
  virtual void cancel_homing() = 0;
  /// To an angle, from rest or from a move under way, with a profile of its own.
  virtual AxisVerdict move_to(double q) = 0;
  /// Follow: where the joint shall be at the next setpoint, and how fast then; rad, rad/s.
  virtual AxisVerdict track(double q, double qd) = 0;
  /// Decelerates inside its limits and holds; a fault is latched where one is named.
  virtual void stop(AxisFault why = AxisFault::kNone) = 0;
  /// Acts at once whatever else runs, and stays until released. Releasing resumes nothing.
  virtual void emergency_stop() = 0;
  virtual void release_emergency_stop() = 0;
  virtual void clear_faults() = 0;
  virtual void self_test() = 0;
};

/// What the electronics of an axis sense at one control tick.
struct AxisInputs {
  std::int64_t steps = 0;          ///< microsteps made when the encoders were read; signed
  std::int32_t joint_counts = 0;   ///< quadrature counter, or AS5600 position 0..4095
  bool joint_encoder_ok = true;    ///< replies, with its magnet in place
  bool joint_fresh = true;         ///< joint_counts is a reading since the last tick
  double joint_age = 0;            ///< s between that reading and the motor's
  std::uint16_t motor_counts = 0;  ///< AS5600 on the motor shaft, 0..4095
  bool motor_encoder_ok = true;
  Magnet joint_magnet = Magnet::kUnknown;
  Magnet motor_magnet = Magnet::kUnknown;
  bool end_stop = false;      ///< closed
  bool driver_fault = false;  ///< the power stage shut itself down
  bool stop_line = false;     ///< a wired stop is asked for: an emergency stop while it lasts
  bool has_meters = true;  ///< the next two are measured; else they count as good and are not told
  double supply_volts = 24;
  double temperature_c = 25;
};

/// What they are told to do until the next tick.
struct AxisOutputs {
  bool enabled = false;    ///< current in the windings
  std::int64_t steps = 0;  ///< microstep count to reach, evenly, by the next tick; signed
  bool frozen = false;     ///< no further step at once; `steps` will be where that left it
};

}  // namespace sinew
