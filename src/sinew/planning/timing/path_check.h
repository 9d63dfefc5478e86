#pragma once

#include <array>
#include <limits>
#include <span>

#include "sinew/motion/rest_to_rest.h"
#include "sinew/planning/paths/planned_path.h"
#include "sinew/planning/timing/time_law.h"

namespace sinew::planning {

/// The worst of a motion, as shares of what is allowed: <= 1 (to rounding) holds every limit.
struct PathLoad {
  JointArray velocity{};
  JointArray acceleration{};
  JointArray jerk{};
  double tool_speed = 0;
  double tool_acceleration = 0;
  double shared = 0;  ///< the sum of all joints' speeds

  /// The largest of all.
  double worst() const;
};

/// What `law` asks of the robot along `path`, looked at `samples` times in each phase and each
/// piece of the path, both ends included: made without anything that the planner knows.
/// @param feed  of the asked-for speeds. @param shared_velocity  as PathTiming::prepare.
PathLoad check(const PlannedPath& path, const TimeLaw& law,
               std::span<const motion::AxisLimits> limits, double feed = 1, int samples = 8,
               double shared_velocity = std::numeric_limits<double>::infinity());

}  // namespace sinew::planning
