#include "sinew/devices/axis/axis_search.h"

#include <algorithm>
#include <cmath>

#include "sinew/devices/axis/axis_device_settings.h"
#include "sinew/motion/rest_to_rest.h"

namespace sinew {
namespace {

/// The exchanges before and behind an axis' search, 82 ms each on the register wire, and the time
/// that it takes to come to rest.
constexpr double kTalk = 2;  // s

double way_time(double way, double speed, motion::AxisLimits limits) {
  limits.velocity = std::min(limits.velocity, speed);
  return motion::plan_axis(way, limits).duration();
}

/// From a speed to rest; its longest part is the ramp, whose own ends need acceleration / jerk.
double stop_time(double speed, const motion::AxisLimits& limits) {
  return speed / limits.acceleration + limits.acceleration / limits.jerk;
}

double longest_search(const AxisSettings& axis) {
  const HomingSettings& homing = axis.homing;
  const double search = way_time(homing.travel_max, homing.approach_speed, axis.limits) +
                        stop_time(homing.approach_speed, axis.limits);
  const double back_off = way_time(homing.back_off_max, homing.approach_speed, axis.limits);
  // It turns round where it has backed off, and goes a little beyond the place of contact.
  const double overshoot =
      homing.approach_speed * stop_time(homing.approach_speed, axis.limits) / 2;
  const double edge_way = homing.back_off_max + overshoot + homing.back_off;
  const double edge = stop_time(homing.approach_speed, axis.limits) +
                      way_time(edge_way, homing.slow_speed, axis.limits) +
                      stop_time(homing.slow_speed, axis.limits);
  const double clear_way = std::abs(homing.clear_angle - homing.end_stop_angle) + homing.back_off;
  return search + back_off + edge + way_time(clear_way, axis.limits.velocity, axis.limits) + kTalk;
}

}  // namespace

ZeroSearch axis_search(const RobotModel& robot, std::size_t joint) {
  const AxisSettings axis = axis_settings(robot, joint);
  return {longest_search(axis), axis.homing.clear_angle};
}

}  // namespace sinew
