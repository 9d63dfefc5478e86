#pragma once

#include <cstdint>
#include <limits>
#include <span>
#include <string>

#include "sinew/core/instant.h"
#include "sinew/model/device_settings.h"

namespace sinew {

/// Who makes the motion: the host, setpoint by setpoint, or the device, from target to target.
enum class MotionKind : std::uint8_t { kStream, kPointToPoint };

/// What a device can say about where it stands.
enum class PositionFeedback : std::uint8_t { kMeasured, kCommanded, kNone };

/// What a device drives at the end of an arm.
enum class HandDrive : std::uint8_t {
  kNone,
  kJaws,     ///< to a width between them
  kServo,    ///< a gripper to an angle
  kSuction,  ///< a pump, and a nozzle that turns
};

/// What the wire and the device behind it can do; the planner never asks for more.
struct DeviceCapability {
  MotionKind motion = MotionKind::kPointToPoint;
  PositionFeedback feedback = PositionFeedback::kNone;
  /// kStream: how long one segment of a motion shall be. Short ones stop sooner and follow closer,
  /// long ones cost less of the wire.
  Duration segment{};
  /// kStream: share of the joints' limits that a motion is planned with. An axis that closes its
  /// own loop needs the rest to catch up where a setpoint came late.
  double limits_share = 1;
  /// kStream: where one wire carries the ways of all joints one after the other, the sum of their
  /// speeds that it carries, m/s (rad/s); infinite where it does not count.
  double shared_velocity = std::numeric_limits<double>::infinity();
  /// kPointToPoint: how quickly a motion is made can be asked for. Else the device has one speed.
  bool takes_speed = true;
  /// How far one joint may be moved at a time while nobody knows where it is, rad or m; 0: this
  /// device moves to places only.
  double nudge_max = 0;
  /// The same of a joint that slides in an arm whose others turn, m.
  double nudge_slide_max = 0;
  HandDrive hand = HandDrive::kNone;
  /// Its motors can be switched off and on again by themselves, and positions are measured
  /// meanwhile: the arm can be guided by hand.
  bool free_drive = false;
  /// It has an input that ends a joint's way where it closes.
  bool probes = false;
};

/// What is left as it is here is the ideal device.
struct Device {
  std::string protocol = "ideal";  ///< name of the wire in the robot's file
  std::uint32_t baud = 1'000'000;
  DeviceCapability capability{.motion = MotionKind::kStream,
                              .feedback = PositionFeedback::kMeasured,
                              .segment = std::chrono::milliseconds(20),
                              .hand = HandDrive::kJaws};
  SomeSettings settings;  ///< of its kind
};

/// The boards of a robot that hangs on SPI, one per joint; none of any other. They live in it.
inline std::span<const AxisBoard> boards_of(const Device& device) {
  return device.settings->axis_boards();
}

}  // namespace sinew
