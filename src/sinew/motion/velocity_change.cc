#include "sinew/motion/velocity_change.h"

#include <algorithm>
#include <cmath>

namespace sinew::motion {

VelocityChange::VelocityChange(const AxisState& start, double velocity, const ProfileBounds& bounds)
    : start_(start), velocity_(velocity) {
  const double jerk = bounds.jerk;
  const auto add = [&](double sign, double duration) {
    if (duration > 0) phases_.push_back({sign * jerk, duration});
  };
  const double inside = std::clamp(start.qdd, bounds.acceleration_lower, bounds.acceleration_upper);
  const double outside = start.qdd - inside;
  add(outside > 0 ? -1 : 1, std::abs(outside) / jerk);
  const double now = start.qd + outside / jerk * (start.qdd + inside) / 2 * (outside > 0 ? 1 : -1);

  // Upwards where it would end too slow if the acceleration were taken back at once.
  const double natural = now + inside * std::abs(inside) / (2 * jerk);
  const double side = velocity >= natural ? 1 : -1;
  const double cap = side > 0 ? bounds.acceleration_upper : -bounds.acceleration_lower;
  const double first = side * inside;
  const double gain = side * (velocity - now);
  // gain = (peak^2 - first^2 / 2) / jerk where the peak is not held.
  const double peak_square = jerk * gain + first * first / 2;
  const double peak = std::min(cap, std::sqrt(std::max(0.0, peak_square)));
  add(side, (peak - first) / jerk);
  const double hold = peak < cap ? 0 : (peak_square - cap * cap) / (jerk * cap);
  add(0, hold);
  add(-side, peak / jerk);
  if (hold > 0) binding_ = Binding::kAcceleration;
}

void VelocityChange::profile(JointProfile& out) const {
  out.restart(start_);
  for (const auto& [jerk, duration] : phases_) out.append(jerk, duration);
  const AxisState end{out.end().q, velocity_, 0};
  out.finish(end, AfterEnd::kContinue);
}

JointProfile VelocityChange::profile() const {
  JointProfile result;
  profile(result);
  return result;
}

}  // namespace sinew::motion
