#pragma once

#include <chrono>

#include "sinew/devices/bigrobotarm/bigrobotarm_settings.h"
#include "sinew/model/device.h"
#include "sinew/model/device_settings.h"

namespace sinew {

/// The BigRobotArm's board with Sinew's own firmware, over the arm link.
struct ArmLinkDevice final : SettingsOf<ArmLinkDevice> {
  /// What its joints and its gripper count in; of its wires none.
  BigRobotArmDevice arm = of_no_wire({});
  Duration deadline = std::chrono::milliseconds(200);  ///< silence that stops the arm; 20..500 ms

  static BigRobotArmDevice of_no_wire(BigRobotArmDevice arm);

  void identify(IdentityText& out) const override { arm.identify(out); }
  bool shows_power_loss() const override { return true; }
  bool counts_from_power_up() const override { return true; }
  StopFacts stop_facts() const override {
    return {true, "one frame until told, then it brakes: up to 1 s at full speed",
            arm.stop_facts().falls, true};
  }
  double resolution(std::size_t joint) const override { return arm.resolution(joint); }
  /// The board begins once it has some segments; and is asked in between.
  MotionDelay motion_delay() const override {
    return {std::chrono::milliseconds(6), std::chrono::milliseconds(16)};
  }
  std::optional<Error> gripper_refusal(const GripperTo& gripper) const override {
    return arm.gripper_refusal(gripper);
  }
  std::vector<std::string> profiles() const override { return {"sinew"}; }
  std::vector<std::string> wires() const override { return {"framed"}; }
  bool use_setting(const DeviceSetting& setting, Device& device) override {
    return arm.use_setting(setting, device);
  }
};

/// What a host can ask of a board on the arm link.
DeviceCapability arm_link_capability(double nudge_max);

}  // namespace sinew
