#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>

#include "sinew/core/units.h"
#include "sinew/model/device_settings.h"

namespace sinew {

inline constexpr std::size_t kBigRobotArmJoints = 5;

/// One joint of the BigRobotArm's firmware.
struct BigRobotArmJoint {
  double steps_per_rad = 0;  ///< signed: the firmware's positive may be the model's negative
  double steps_per_motor_rev = 0;
  std::int32_t multiplier_boot = 100;  ///< speed and acceleration at power-up, motor rev/s x 100
};

using BigRobotArmJoints = std::array<BigRobotArmJoint, kBigRobotArmJoints>;

enum class BigRobotArmWire : std::uint8_t { kByte, kText };

/// The text wire's two generations. A host works with either; a simulated device is one of them.
enum class BigRobotArmDialect : std::uint8_t { k2021, k2026 };

struct BigRobotArmDevice final : SettingsOf<BigRobotArmDevice> {
  static constexpr double kNudgeMax = from_deg(5);  ///< rad, on each of its wires

  BigRobotArmJoints joints;
  BigRobotArmWire wire = BigRobotArmWire::kByte;
  BigRobotArmDialect dialect = BigRobotArmDialect::k2021;  ///< of the text wire
  bool probe_wire = false;  ///< wire and dialect are found out when the port opens
  std::int32_t multiplier_max = 300;
  std::int32_t gripper_max = 180;

  void identify(IdentityText& out) const override {
    for (const BigRobotArmJoint& joint : joints) out.add(joint.steps_per_rad);
  }
  bool shows_power_loss() const override { return true; }
  bool counts_from_power_up() const override { return true; }
  StopFacts stop_facts() const override {
    return {false, "none: finishes its move",
            "steppers hold; without power the arm sinks or drops"};
  }
  double resolution(std::size_t joint) const override {
    return 1 / std::abs(joints[joint].steps_per_rad);
  }
  /// The robot's file has the limits of power-up; its document's M203 and M201 go on from there.
  double firmware_reach(std::size_t joint) const override {
    const BigRobotArmJoint& motor = joints[joint];
    return multiplier_max * (motor.steps_per_motor_rev / 100) / std::abs(motor.steps_per_rad);
  }
  MotionDelay motion_delay() const override {
    return {std::chrono::milliseconds(3), std::chrono::milliseconds(17)};
  }
  bool takes_acceleration() const override { return true; }
  std::optional<Error> target_refusal(const RobotModel& robot, std::span<const double> q,
                                      std::span<const double> from) const override;
  std::optional<Error> gripper_refusal(const GripperTo& gripper) const override;
  std::vector<std::string> profiles() const override { return {"document", "as-built", "sinew"}; }
  std::vector<std::string> wires() const override;
  void use_wire(const std::string& name, Device& device) override;
  bool use_setting(const DeviceSetting& setting, Device& device) override;
};

/// The arm behind one of its wires, the maker's or ours; nullptr: the device is another one.
const BigRobotArmDevice* big_robot_arm_of(const DeviceSettings& settings);

}  // namespace sinew
