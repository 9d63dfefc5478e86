#include "sinew/driver/motion_delay.h"

#include <algorithm>
#include <cmath>
#include <variant>

#include "sinew/driver/lsc.h"
#include "sinew/driver/maxarm.h"

namespace sinew {
namespace {

using namespace std::chrono_literals;

struct Delays {
  // It is asked every 10 ms how far it is.
  MotionDelay operator()(const IdealDevice& /*device*/) const { return {2ms, 8ms}; }
  MotionDelay operator()(const BigRobotArmDevice& /*device*/) const { return {3ms, 17ms}; }
  MotionDelay operator()(const AxisRegistersDevice& /*device*/) const { return {}; }
  // The loop is that far behind its setpoint; the driver knows when the setpoint has arrived.
  MotionDelay operator()(const AxisLinkDevice& /*device*/) const { return {34ms, 2ms}; }
  MotionDelay operator()(const LscDevice& device) const {
    // Boards that can be asked are asked when their servos have settled.
    return {36ms, device.profile == LscProfile::kLsc6 ? 109ms : 480ms};
  }
  // The loops of its servos are that far behind their ramps.
  MotionDelay operator()(const MaxArmDevice& device) const {
    const MaxArmPace pace = pace_of(device.variant);
    return {pace.begins + 12ms, pace.told()};
  }
  MotionDelay operator()(const IcpDevice& /*device*/) const { return {4ms, 113ms}; }
};

}  // namespace

MotionDelay motion_delay(const Device& device) {
  return std::visit(Delays{}, device.settings);
}

Duration tool_time(const RobotModel& robot, const ToolAction& action, std::optional<double> jaws) {
  if (const auto* arm = std::get_if<MaxArmDevice>(&robot.device.settings)) {
    return maxarm_tool_time(arm->variant, action);
  }
  const auto* geometry = std::get_if<SerialGeometry>(&robot.geometry);
  const auto* to = std::get_if<JawsTo>(&action);
  if (to == nullptr || geometry == nullptr || !geometry->gripper) return {};
  const LscTiming timing;
  const Duration report = motion_delay(robot.device).report;
  const auto* board = std::get_if<LscDevice>(&robot.device.settings);
  const bool blind = board != nullptr && board->profile == LscProfile::kLsc6;
  if (!jaws && blind) return timing.first_move_min + report;
  // A board that can be asked knows where they are; nobody has told the planner.
  const double way = jaws ? std::abs(to->width - *jaws) : geometry->gripper->width_max;
  const double own = way / geometry->gripper->width_max * to_seconds(timing.jaws_stroke);
  return std::max(timing.segment_max, from_seconds(own)) + report;
}

}  // namespace sinew
