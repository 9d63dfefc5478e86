#include "sinew/runtime/robot_driver.h"

#include "sinew/devices/device_kinds.h"
#include "sinew/devices/ideal/ideal_driver.h"
#include "sinew/driver/axis_link.h"
#include "sinew/driver/axis_registers.h"
#include "sinew/driver/bigrobotarm.h"
#include "sinew/driver/icp.h"
#include "sinew/driver/lsc.h"
#include "sinew/driver/maxarm.h"

namespace sinew::runtime {
namespace {

/// Picks the driver that belongs to the settings.
struct DriverMaker {
  const RobotModel& robot;
  double patience;

  Duration stretched(Duration duration) const {
    return from_seconds(to_seconds(duration) * patience);
  }

  RobotDriver operator()(const IdealDevice& /*device*/) const {
    IdealTiming timing;
    timing.reply_timeout = stretched(timing.reply_timeout);
    const auto* geometry = std::get_if<SerialGeometry>(&robot.geometry);
    return {std::make_unique<IdealDriver>(robot.joints,
                                          geometry != nullptr ? geometry->gripper : std::nullopt,
                                          robot.device.baud, timing),
            nullptr};
  }

  RobotDriver operator()(const BigRobotArmDevice& device) const {
    BigRobotArmTiming timing;
    timing.wire.reply_timeout = stretched(timing.wire.reply_timeout);
    timing.wire.move_margin = stretched(timing.wire.move_margin);
    timing.wire.quiet_limit = stretched(timing.wire.quiet_limit);
    timing.opening_limit = stretched(timing.opening_limit);
    return {std::make_unique<BigRobotArmDriver>(device, robot.joints, timing), nullptr};
  }
  RobotDriver operator()(const AxisRegistersDevice& device) const {
    return {nullptr, std::make_unique<AxisRegistersDriver>(device, robot.joints)};
  }
  RobotDriver operator()(const AxisLinkDevice& device) const {
    return {nullptr, std::make_unique<AxisLinkDriver>(device, robot.joints)};
  }
  RobotDriver operator()(const LscDevice& device) const {
    LscTiming timing;
    timing.reply_timeout = stretched(timing.reply_timeout);
    timing.output_timeout = stretched(timing.output_timeout);
    timing.lead = stretched(timing.lead);
    const auto& geometry = std::get<SerialGeometry>(robot.geometry);
    return {std::make_unique<LscDriver>(device, robot.joints, geometry.gripper, timing), nullptr};
  }
  RobotDriver operator()(const MaxArmDevice& device) const {
    MaxArmTiming timing;
    timing.reply_timeout = stretched(timing.reply_timeout);
    timing.patience = stretched(timing.patience);
    return {std::make_unique<MaxArmDriver>(device, robot.joints, timing), nullptr};
  }
  RobotDriver operator()(IcpDevice device) const {
    device.reply_timeout = stretched(device.reply_timeout);
    return {std::make_unique<IcpDriver>(device, robot.joints), nullptr};
  }
};

}  // namespace

RobotDriver make_driver(const RobotModel& robot, double patience) {
  return visit_kind(DriverMaker{robot, patience}, robot.device.settings);
}

}  // namespace sinew::runtime
