#pragma once

#include <array>
#include <cstdint>
#include <string>

#include "sinew/core/units.h"
#include "sinew/devices/icp/icp_settings.h"
#include "sinew/model/robot_model.h"

namespace sinew::test {

/// M4 spindles of 0.7 mm a turn, 3200 microsteps a turn.
inline constexpr double kIcpUnitsPerM = 3200 / 0.7e-3;

inline IcpDevice icp_device() {
  IcpDevice device;
  device.units_per_m = kIcpUnitsPerM;
  for (std::size_t i = 0; i < kLegs; ++i) {
    device.legs[i].address = static_cast<std::uint8_t>(0x61 + i);
  }
  return device;
}

/// Six legs of 195 to 345 mm that stand at 268 mm.
inline RobotModel icp_robot(const IcpDevice& device = icp_device()) {
  RobotModel model;
  model.id = "hexapod";
  for (std::size_t i = 0; i < kLegs; ++i) {
    model.joints.push_back({.name = "leg" + std::to_string(i + 1),
                            .kind = JointKind::kPrismatic,
                            .lower = from_mm(195),
                            .upper = from_mm(345),
                            .velocity_max = from_mm(0.00875),
                            .acceleration_max = from_mm(0.1),
                            .jerk_max = from_mm(1),
                            .home = from_mm(268)});
  }
  model.device.protocol = "icp";
  model.device.baud = 9600;
  model.device.settings = device;
  return model;
}

}  // namespace sinew::test
