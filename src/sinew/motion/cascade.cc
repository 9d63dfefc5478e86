#include "sinew/motion/cascade.h"

#include <algorithm>
#include <cmath>

namespace sinew::motion {

double Cascade::rate(double q_ref, double qd_ref, double q, double qd, double dt) {
  const double error = q_ref - q;
  if (qd_ref == 0 && std::abs(error) <= settings_.dead_band) {
    integral_ = 0;
    return 0;
  }
  const double velocity = settings_.feed_forward * qd_ref + settings_.position_gain * error;
  const double velocity_error = velocity - qd;
  const double wanted = velocity + settings_.velocity_gain * velocity_error + integral_;
  const double rate = std::clamp(wanted, -settings_.rate_max, settings_.rate_max);
  const bool pushes_further = wanted != rate && (wanted > 0) == (velocity_error > 0);
  if (!pushes_further) {
    const double most = settings_.integral_share * settings_.rate_max;
    integral_ = std::clamp(integral_ + settings_.integral_gain * velocity_error * dt, -most, most);
  }
  return rate;
}

}  // namespace sinew::motion
