#include "sinew/planning/paths/motion_limits.h"

#include <algorithm>
#include <cmath>

#include "sinew/model/limit_reach.h"

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

std::vector<motion::AxisLimits> farthest_limits(const RobotModel& model) {
  auto limits = motion_limits(model);
  for (std::size_t j = 0; j < limits.size(); ++j) {
    const LimitReach reach = limit_reach(model, j);
    limits[j].velocity *= reach.velocity;
    limits[j].acceleration *= reach.acceleration;
    limits[j].jerk *= reach.acceleration;
  }
  return limits;
}

double shared_velocity(const RobotModel& model) {
  return model.device.capability.limits_share * model.device.capability.shared_velocity;
}

std::vector<motion::AxisLimits> straight_limits(const RobotModel& model,
                                                std::span<const double> from,
                                                std::span<const double> to) {
  auto limits = motion_limits(model);
  double ways = 0;
  for (std::size_t j = 0; j < limits.size(); ++j) ways += std::abs(to[j] - from[j]);
  for (std::size_t j = 0; j < limits.size(); ++j) {
    const double share = std::abs(to[j] - from[j]) / ways;
    // One that stays keeps its own limit: no axis has none.
    if (share > 0) {
      limits[j].velocity = std::min(limits[j].velocity, share * shared_velocity(model));
    }
  }
  return limits;
}

}  // namespace sinew::planning
