#include "sinew/planning/motion_limits.h"

namespace sinew::planning {

std::vector<motion::AxisLimits> motion_limits(const RobotModel& model) {
  std::vector<motion::AxisLimits> limits;
  const double share = model.device.capability.limits_share;
  for (const Joint& joint : model.joints) {
    limits.push_back(
        {share * joint.velocity_max, share * joint.acceleration_max, share * joint.jerk_max});
  }
  return limits;
}

}  // namespace sinew::planning
