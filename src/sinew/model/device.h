#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <limits>
#include <span>
#include <string>
#include <utility>
#include <variant>

#include "sinew/core/angle_encoding.h"
#include "sinew/core/fixed_vector.h"
#include "sinew/core/instant.h"

namespace sinew {

inline constexpr std::size_t kMaxJoints = 8;

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
  HandDrive hand = HandDrive::kNone;
};

inline constexpr std::size_t kBigRobotArmJoints = 5;

/// One joint of the BigRobotArm's firmware.
struct BigRobotArmJoint {
  double steps_per_rad = 0;  ///< signed: the firmware's positive may be the model's negative
  double steps_per_motor_rev = 0;
  std::int32_t multiplier_boot = 100;  ///< speed and acceleration at power-up, motor rev/s x 100
};

enum class BigRobotArmWire : std::uint8_t { kByte, kText };

/// The text wire's two generations. A host works with either; a simulated device is one of them.
enum class BigRobotArmDialect : std::uint8_t { k2021, k2026 };

struct BigRobotArmDevice {
  std::array<BigRobotArmJoint, kBigRobotArmJoints> joints;
  BigRobotArmWire wire = BigRobotArmWire::kByte;
  BigRobotArmDialect dialect = BigRobotArmDialect::k2021;  ///< of the text wire
  bool probe_wire = false;  ///< wire and dialect are found out when the port opens
  std::int32_t multiplier_max = 300;
  std::int32_t gripper_max = 180;
};

// robot-arm-2: one controller board per axis on an SPI bus.

/// Where the registers of a board stand; the defaults are the document's.
struct AxisRegisterMap {
  std::uint16_t homing = 0;
  std::uint16_t move_angle = 1;
  std::uint16_t diag_control = 2;
  std::uint16_t diag_status = 3;
  std::uint16_t emergency_stop = 4;
  friend bool operator==(const AxisRegisterMap&, const AxisRegisterMap&) = default;
};

/// One axis board and its wires. Boards may share a bus, or have one each.
struct AxisBoard {
  std::uint8_t spi_bus = 0;
  std::uint8_t spi_device = 0;
  std::uint8_t select_gpio = 0;       ///< BCM number of the chip select
  std::uint8_t ready_gpio = 0;        ///< READY, which is shown and never relied on
  double zero = 0;                    ///< rad: the joint angle that kDegU32 calls 0
  std::uint8_t homing_place = 0;      ///< 1: homes first; 0 of all of them: in the joints' order
  std::int8_t homing_direction = -1;  ///< in which its search goes: -1 towards lower angles
  double step_rate_max = 5000;        ///< microsteps/s that it makes; the first firmware's ceiling
};

/// Of its step rate, what motions may use; the rest is for a board's loop to correct with.
inline constexpr double kStepRateShare = 0.9;

using AxisBoards = FixedVector<AxisBoard, kMaxJoints>;  ///< one per joint

/// Joints in the order in which they look for their zeros.
inline FixedVector<std::uint8_t, kMaxJoints> homing_order(const AxisBoards& boards) {
  FixedVector<std::uint8_t, kMaxJoints> order;
  for (std::size_t i = 0; i < boards.size(); ++i) order.push_back(static_cast<std::uint8_t>(i));
  std::ranges::sort(
      order, {}, [&](std::uint8_t joint) { return std::pair(boards[joint].homing_place, joint); });
  return order;
}

struct AxisRegistersDevice {
  AngleEncoding encoding = AngleEncoding::kDegU32;
  AxisRegisterMap registers;
  std::uint8_t slave_id = 1;
  std::uint32_t clock_hz = 500'000;
  /// DIAG_STATUS tells something. Boards with the first firmware always answer 0: a move is done
  /// there when its predicted time is over, and positions are `commanded`.
  bool reports_status = true;
  AxisBoards boards;
};

/// robot-arm-2 with axis boards that run Sinew's own firmware.
struct AxisLinkDevice {
  std::uint32_t clock_hz = 4'000'000;
  Duration deadline = std::chrono::milliseconds(100);  ///< silence that stops an axis; 20..500 ms
  AxisBoards boards;
};

// learm

enum class LscProfile : std::uint8_t {
  kLsc6,   ///< six PWM servos, open loop: the classic board
  kBus,    ///< bus servos, positions can be read
  kEsp32,  ///< PWM servos, commanded positions can be read; some commands mean other things
};

/// One servo: device units at the joint's zero and per rad, signed. On PWM boards a unit is a
/// microsecond of pulse, on bus boards a thousandth of 240 degrees.
struct LscServo {
  std::uint8_t id = 0;
  double centre = 1500;      ///< units at q = 0
  double units_per_rad = 0;  ///< signed: the servo may turn against the model
  double trim = 0;           ///< units, added to the centre
  std::int32_t lower = 500;  ///< units that may be sent
  std::int32_t upper = 2500;
};

/// The gripper's servo: jaw width is linear in its units.
struct LscGripper {
  std::uint8_t id = 1;
  double open = 1500;    ///< units with the jaws at width_max
  double closed = 2500;  ///< units with the jaws closed
};

struct LscDevice {
  LscProfile profile = LscProfile::kLsc6;
  FixedVector<LscServo, kMaxJoints> servos;  ///< one per joint
  LscGripper gripper;
};

// maxarm

enum class MaxArmChecksum : std::uint8_t { kSpec, kWithHeader };
enum class MaxArmVariant : std::uint8_t { kArduino, kMicroPython };

/// What the wire calls servo angles: pulse = offset + pulses_per_rad * q, 0..1000.
struct MaxArmServo {
  double offset = 0;
  double pulses_per_rad = 0;
};

struct MaxArmDevice {
  std::array<MaxArmServo, 3> servos;  ///< base, shoulder, forearm
  /// What a simulated device answers like; a host accepts both.
  MaxArmChecksum checksum = MaxArmChecksum::kSpec;
  MaxArmVariant variant = MaxArmVariant::kArduino;
};

// hexapod

/// One leg's motor.
struct IcpLeg {
  bool invert = false;       ///< direction bit 0 shortens the leg
  std::uint8_t address = 0;  ///< 7-bit I2C address of its TMC222, for the simulated device
};

/// What the simulated controller's firmware makes of what the document leaves open or says twice;
/// the host never reads it. The defaults are what a host expects.
struct IcpFirmware {
  bool knows_wake = true;             ///< C0 is a command; else it fails the check of its ones
  bool checks_selector = false;       ///< a status selector must be a whole positioning byte
  bool bit_one_is_plus = false;       ///< direction bit 1 is sent to the motor as +1
  bool minus_one_is_fffe = false;     ///< a -1 is sent as its ones' complement
  bool silent_without_motor = false;  ///< motor 0 or 7: no reply at all instead of 11
  bool ack_without_module = false;    ///< 00 although the module did not acknowledge; else silence
  Duration processing{};              ///< from a byte that needs the modules to its reply
  Duration boot = std::chrono::milliseconds(20);  ///< deaf after power-up
  /// Without a byte for so long it is dead until its power is cut; 0: never.
  Duration idle_shutdown{};
  friend bool operator==(const IcpFirmware&, const IcpFirmware&) = default;
};

struct IcpDevice {
  double units_per_m = 0;     ///< position units (microsteps) per metre of leg
  double units_per_down = 1;  ///< units that a "-1" really moves: 2 where it is sent as FFFE
  std::array<IcpLeg, 6> legs;
  Duration reply_timeout = std::chrono::milliseconds(50);  ///< beyond the time on the wire
  int tries = 3;
  IcpFirmware firmware;
};

/// The device of a robot whose file names none: it does exactly what it is told, within the file's
/// limits.
struct IdealDevice {};

/// What is left as it is here is the ideal device.
struct Device {
  std::string protocol = "ideal";  ///< name of the wire in the robot's file
  std::uint32_t baud = 1'000'000;
  DeviceCapability capability{.motion = MotionKind::kStream,
                              .feedback = PositionFeedback::kMeasured,
                              .segment = std::chrono::milliseconds(20),
                              .hand = HandDrive::kJaws};
  std::variant<IdealDevice, BigRobotArmDevice, AxisRegistersDevice, AxisLinkDevice, LscDevice,
               MaxArmDevice, IcpDevice>
      settings;
};

/// The boards of a robot that hangs on SPI, one per joint; none of any other. They live in it.
inline std::span<const AxisBoard> boards_of(const Device& device) {
  if (const auto* registers = std::get_if<AxisRegistersDevice>(&device.settings)) {
    return {registers->boards.data(), registers->boards.size()};
  }
  if (const auto* link = std::get_if<AxisLinkDevice>(&device.settings)) {
    return {link->boards.data(), link->boards.size()};
  }
  return {};
}

}  // namespace sinew
