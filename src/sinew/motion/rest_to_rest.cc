#include "sinew/motion/rest_to_rest.h"

#include <algorithm>
#include <cmath>

#include "sinew/core/assert.h"
#include "sinew/core/dispatch.h"

namespace sinew::motion {

JerkLimitedMove plan_axis(double distance, const AxisLimits& limits) {
  const auto& [v, a, j] = limits;
  if (distance == 0) return {};
  // A ramp to full speed; it is too short for full acceleration where v j < a^2.
  const bool full_acceleration = v * j >= a * a;
  const double jerk_time = full_acceleration ? a / j : std::sqrt(v / j);
  const double ramp_time = full_acceleration ? v / a + jerk_time : 2 * jerk_time;
  if (distance >= v * ramp_time) {
    return {j, jerk_time, ramp_time, distance / v - ramp_time};
  }
  // No cruise. With steady acceleration for s seconds: a (tj + s) (2 tj + s) = distance, tj = a/j.
  const double full_jerk_time = a / j;
  if (distance >= 2 * a * full_jerk_time * full_jerk_time) {
    const double half = full_jerk_time / 2;
    return {j, full_jerk_time, half + std::sqrt(half * half + distance / a), 0};
  }
  const double short_jerk_time = std::cbrt(distance / (2 * j));
  return {j, short_jerk_time, 2 * short_jerk_time, 0};
}

RestToRest::RestToRest(std::span<const double> start, std::span<const double> target,
                       std::span<const AxisLimits> limits)
    : size_(start.size()) {
  SINEW_ASSERT(size_ <= kAxesMax && target.size() == size_ && limits.size() == size_);
  std::array<JerkLimitedMove, kAxesMax> moves;
  Lanes distance{};
  for (std::size_t i = 0; i < size_; ++i) {
    distance[i] = std::abs(target[i] - start[i]);
    SINEW_ASSERT(std::isfinite(distance[i]));
    start_[i] = start[i];
    target_[i] = target[i];
    moves[i] = plan_axis(distance[i], limits[i]);
    if (moves[i].duration() > moves[slowest_].duration()) slowest_ = i;
  }
  if (size_ == 0 || distance[slowest_] == 0) return;
  const JerkLimitedMove& lead = moves[slowest_];
  duration_ = lead.duration();
  for (std::size_t i = 0; i < size_; ++i) {
    if (distance[i] == 0) continue;
    const double share = distance[i] / distance[slowest_];
    const bool follows = i == slowest_ || (share * lead.velocity() <= limits[i].velocity &&
                                           share * lead.acceleration() <= limits[i].acceleration &&
                                           share * lead.jerk <= limits[i].jerk);
    const double direction = target[i] > start[i] ? 1 : -1;
    if (follows) {
      set_axis(i, lead, direction * share * lead.jerk);
      continue;
    }
    straight_ = false;
    const double stretch = duration_ / moves[i].duration();
    const JerkLimitedMove slower{0, stretch * moves[i].jerk_time, stretch * moves[i].ramp_time, 0};
    set_axis(i, slower, direction * moves[i].jerk / (stretch * stretch * stretch));
  }
}

void RestToRest::set_axis(std::size_t i, const JerkLimitedMove& move, double jerk) {
  jerk_[i] = jerk;
  jerk_end_[i] = move.jerk_time;
  fall_start_[i] = move.ramp_time - move.jerk_time;
  ramp_end_[i] = move.ramp_time;
  velocity_[i] = jerk * move.jerk_time * (move.ramp_time - move.jerk_time);
}

void RestToRest::sample(double t, AxisStates& out) const {
  dispatched([&] { sample_portable(t, out); });
}

void RestToRest::sample_portable(double t, AxisStates& out) const {
  // The second half is the first one seen from the target: one ramp and half a cruise serve both.
  const double now = std::clamp(t, 0.0, duration_);
  const bool leaving = now <= duration_ - now;
  const double tau = leaving ? now : duration_ - now;
  const double side = leaving ? 1 : -1;
  const Lanes& origin = leaving ? start_ : target_;
  // Both lanes of a pair, used or not: the compiler puts two axes into one vector.
  static_assert(kAxesMax % 2 == 0);
  const std::size_t lanes = (size_ + 1) / 2 * 2;
  for (std::size_t i = 0; i < lanes; ++i) {
    const double ramp = std::min(tau, ramp_end_[i]);
    const double cruise = tau - ramp;
    const double rising = std::min(ramp, jerk_end_[i]);
    const double steady = ramp - rising;
    const double falling = std::max(0.0, ramp - fall_start_[i]);
    const double falling_squared = falling * falling;
    // Jerk is +j, then 0, then -j: the three integrals of that, as sums without cancellation.
    const double linear = rising - falling;
    const double square = rising * (ramp + steady) - falling_squared;
    const double cube =
        rising * (ramp * (ramp + steady) + steady * steady) - falling * falling_squared;
    out.qdd[i] = side * jerk_[i] * linear;
    out.qd[i] = 0.5 * jerk_[i] * square;
    out.q[i] = origin[i] + side * (jerk_[i] * (1.0 / 6) * cube + velocity_[i] * cruise);
  }
}

}  // namespace sinew::motion
