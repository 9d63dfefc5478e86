#include "sinew/driver/tool_time.h"

#include <algorithm>
#include <cmath>

#include "sinew/devices/lsc/lsc_settings.h"
#include "sinew/devices/maxarm/maxarm_settings.h"
#include "sinew/driver/lsc.h"
#include "sinew/driver/maxarm.h"

namespace sinew {

Duration tool_time(const RobotModel& robot, const ToolAction& action, std::optional<double> jaws) {
  if (const auto* arm = robot.device.settings.as<MaxArmDevice>()) {
    return maxarm_tool_time(arm->variant, action);
  }
  const auto* geometry = std::get_if<SerialGeometry>(&robot.geometry);
  const auto* to = std::get_if<JawsTo>(&action);
  if (to == nullptr || geometry == nullptr || !geometry->gripper) return {};
  const LscTiming timing;
  const Duration report = robot.device.settings->motion_delay().report;
  const auto* board = robot.device.settings.as<LscDevice>();
  const bool blind = board != nullptr && board->profile == LscProfile::kLsc6;
  if (!jaws && blind) return timing.first_move_min + report;
  // A board that can be asked knows where they are; nobody has told the planner.
  const double way = jaws ? std::abs(to->width - *jaws) : geometry->gripper->width_max;
  const double own = way / geometry->gripper->width_max * to_seconds(timing.jaws_stroke);
  return std::max(timing.segment_max, from_seconds(own)) + report;
}

}  // namespace sinew
