#include "sinew/devices/arm_link/arm_link_settings.h"

#include <algorithm>

namespace sinew {

BigRobotArmDevice ArmLinkDevice::of_no_wire(BigRobotArmDevice arm) {
  // The text wire sends any number.
  arm.wire = BigRobotArmWire::kText;
  arm.dialect = BigRobotArmDialect::k2026;
  arm.probe_wire = false;
  arm.gripper_max = std::min(arm.gripper_max, 180);
  return arm;
}

DeviceCapability arm_link_capability(double nudge_max) {
  return {.motion = MotionKind::kStream,
          .feedback = PositionFeedback::kCommanded,
          .segment = std::chrono::milliseconds(20),
          .nudge_max = nudge_max,
          .hand = HandDrive::kServo};
}

}  // namespace sinew
