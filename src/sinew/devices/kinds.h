#pragma once

#include <span>

#include "sinew/devices/kind.h"

namespace sinew {

std::span<const DeviceKind* const> device_kinds();

const DeviceKind& kind_of(const Device& device);

/// DeviceKind::driver of the robot's device.
inline RobotDriver make_driver(const RobotModel& robot, double patience = 1) {
  return kind_of(robot.device).driver(robot, patience);
}
/// DeviceKind::machine of the robot's device.
inline std::expected<RobotMachine, std::string> make_machine(const RobotModel& robot,
                                                             const MachineVariant& variant,
                                                             Instant boot) {
  return kind_of(robot.device).machine(robot, variant, boot);
}
/// DeviceKind::listener of the device.
inline std::unique_ptr<WireReader> listener_for(const Device& device, const DeviceFacts& facts) {
  return kind_of(device).listener(device, facts);
}

/// What the driver of the robot's device can report beside positions.
DeviceStatements statements_of(const Driver& driver, const RobotModel& robot);

}  // namespace sinew
