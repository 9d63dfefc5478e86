#include "sinew/model/device_settings.h"

#include <cmath>

#include "sinew/model/robot_model.h"

namespace sinew {

double jaws_share(const JawGripper& gripper, double width, std::optional<double> jaws) {
  return jaws ? std::abs(width - *jaws) / gripper.width_max : 1;
}

Duration DeviceSettings::tool_time(const RobotModel& robot, const ToolAction& action,
                                   std::optional<double> jaws) const {
  const auto* geometry = std::get_if<SerialGeometry>(&robot.geometry);
  const auto* to = std::get_if<JawsTo>(&action);
  if (to == nullptr || geometry == nullptr || !geometry->gripper) return {};
  const double share = jaws_share(*geometry->gripper, to->width, jaws);
  return from_seconds(share * to_seconds(IdealDevice::kJawsStroke)) + motion_delay().report;
}

}  // namespace sinew
