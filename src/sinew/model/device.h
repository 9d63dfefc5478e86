#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <variant>

namespace sinew {

/// Who makes the motion: the host, setpoint by setpoint, or the device, from target to target.
enum class MotionKind : std::uint8_t { kStream, kPointToPoint };

/// What a device can say about where it stands.
enum class PositionFeedback : std::uint8_t { kMeasured, kCommanded, kNone };

/// What the wire and the device behind it can do; the planner never asks for more.
struct DeviceCapability {
  MotionKind motion = MotionKind::kPointToPoint;
  PositionFeedback feedback = PositionFeedback::kNone;
};

inline constexpr std::size_t kBigRobotArmJoints = 5;

/// One joint of the BigRobotArm's firmware.
struct BigRobotArmJoint {
  double steps_per_rad = 0;  ///< signed: the firmware's positive may be the model's negative
  double steps_per_motor_rev = 0;
  std::int32_t multiplier_boot = 100;  ///< speed and acceleration at power-up, motor rev/s x 100
};

enum class BigRobotArmWire : std::uint8_t { kByte, kText };

struct BigRobotArmDevice {
  std::array<BigRobotArmJoint, kBigRobotArmJoints> joints;
  BigRobotArmWire wire = BigRobotArmWire::kByte;
  std::int32_t multiplier_max = 300;
  std::int32_t gripper_max = 180;
};

/// A device whose wire this version of Sinew does not speak yet.
struct NoDriver {};

struct Device {
  std::string protocol;  ///< name of the wire in the robot's file
  std::uint32_t baud = 0;
  DeviceCapability capability;
  std::variant<NoDriver, BigRobotArmDevice> settings;
};

}  // namespace sinew
