#pragma once

#include <cstdint>

#include "sinew/devices/axis/axis_device.h"

namespace sinew {

/// What an axis board's LED says, in flashes (mcu/blink_code.h); docs/firmware/axis_controller.md
/// has the table. 0: nothing is wrong. @rt
constexpr std::uint8_t flashes_of(const AxisStatus& status, bool set_up) {
  if (!set_up) return 1;
  if (status.emergency_stopped) return 2;
  switch (status.fault) {
    case AxisFault::kNone:
      break;
    case AxisFault::kEncodersDisagree:
    case AxisFault::kJointEncoder:
    case AxisFault::kMotorEncoder:
      return 3;
    case AxisFault::kFollowingError:
    case AxisFault::kStalled:
      return 4;
    case AxisFault::kEndStop:
    case AxisFault::kHomingTimeout:
    case AxisFault::kEndStopStuck:
      return 5;
    case AxisFault::kSupplyLow:
    case AxisFault::kTooHot:
      return 6;
    case AxisFault::kLinkSilent:
      return 7;
    case AxisFault::kSelfTest:
      return 8;
  }
  return 0;
}

}  // namespace sinew
