#pragma once

#include <cmath>
#include <cstddef>
#include <variant>

#include "sinew/model/robot_model.h"

namespace sinew {

/// The smallest way that a joint's device can be told, rad or m; 0 where the device says with each
/// position how fine it is.
inline double device_resolution(const RobotModel& robot, std::size_t joint) {
  struct Unit {
    std::size_t joint;
    double operator()(const BigRobotArmDevice& device) const {
      return 1 / std::abs(device.joints[joint].steps_per_rad);
    }
    double operator()(const LscDevice& device) const {
      return 1 / std::abs(device.servos[joint].units_per_rad);
    }
    double operator()(const MaxArmDevice& device) const {
      return 1 / std::abs(device.servos[joint].pulses_per_rad);
    }
    double operator()(const IcpDevice& device) const { return 1 / device.units_per_m; }
    double operator()(const AxisRegistersDevice& /*device*/) const { return 0; }
    double operator()(const AxisLinkDevice& /*device*/) const { return 0; }
    double operator()(const IdealDevice& /*device*/) const { return 1e-6; }
  };
  return std::visit(Unit{joint}, robot.device.settings);
}

}  // namespace sinew
