#include "sinew/motion/trapezoid.h"

#include <algorithm>
#include <cmath>

#include "sinew/core/assert.h"

namespace sinew::motion {

Trapezoid::Trapezoid(double distance, double velocity_max, double acceleration_max)
    : distance_(distance), acceleration_(acceleration_max) {
  SINEW_ASSERT(velocity_max > 0 && acceleration_max > 0 && std::isfinite(distance));
  const double way = std::abs(distance);
  if (way == 0) return;
  velocity_ = std::min(velocity_max, std::sqrt(acceleration_max * way));
  ramp_ = velocity_ / acceleration_max;
  // The square root's rounding may leave a hair below zero on a triangle.
  cruise_ = std::max(0.0, way / velocity_ - ramp_);
}

Trapezoid::Point Trapezoid::at(double t) const {
  if (t <= 0) return {};
  if (t >= duration()) return {distance_, 0};
  const double sign = distance_ < 0 ? -1 : 1;
  if (t < ramp_) return {sign * 0.5 * acceleration_ * t * t, sign * acceleration_ * t};
  const double left = duration() - t;
  // The last ramp counts back from the end, so that the end is met without rounding.
  if (left < ramp_) {
    return {distance_ - sign * 0.5 * acceleration_ * left * left, sign * acceleration_ * left};
  }
  return {sign * velocity_ * (t - 0.5 * ramp_), sign * velocity_};
}

Trapezoid Trapezoid::stretched(double duration) const {
  const double own = this->duration();
  SINEW_ASSERT(duration >= own);
  Trapezoid slower = *this;
  if (own == 0) return slower;
  const double k = own / duration;
  slower.velocity_ *= k;
  slower.acceleration_ *= k * k;
  slower.ramp_ /= k;
  slower.cruise_ /= k;
  return slower;
}

}  // namespace sinew::motion
