#include "sinew/motion/online_profile.h"

#include <algorithm>
#include <cmath>

#include "sinew/core/assert.h"

namespace sinew::motion {

/// From one velocity and acceleration to another velocity at acceleration 0: the acceleration goes
/// to its peak, stays, and goes back to 0.
struct OnlineProfile::Ramp {
  std::array<double, 3> jerk{};
  std::array<double, 3> duration{};
};

namespace {

constexpr int kSearchSteps = 32;  // of two evaluations each
/// Of the way that is left, what the search may leave out; at() still ends exactly.
constexpr double kWayTolerance = 1e-13;

AxisState mirrored(const AxisState& state) {
  return {-state.q, -state.qd, -state.qdd};
}

/// Velocity that is left when the acceleration is taken back as quickly as the jerk allows.
double natural_velocity(const AxisState& state, double jerk) {
  return state.qd + state.qdd * std::abs(state.qdd) / (2 * jerk);
}

}  // namespace

ProfileBounds ProfileBounds::mirrored() const {
  ProfileBounds result = *this;
  result.velocity_lower = -velocity_upper;
  result.velocity_upper = -velocity_lower;
  result.acceleration_lower = -acceleration_upper;
  result.acceleration_upper = -acceleration_lower;
  return result;
}

OnlineProfile::Ramp OnlineProfile::ramp(double qd, double qdd, double qd_end,
                                        const ProfileBounds& bounds) {
  // Upwards by construction: a downward ramp is an upward one in the mirror.
  const double natural = natural_velocity({0, qd, qdd}, bounds.jerk);
  const double sign = qd_end >= natural ? 1 : -1;
  const double limit = sign > 0 ? bounds.acceleration_upper : -bounds.acceleration_lower;
  const double gain = sign * (qd_end - qd);
  const double first = sign * qdd;

  // gain = (peak^2 - first^2 / 2) / jerk where the peak is not held.
  const double peak =
      std::min(limit, std::sqrt(std::max(0.0, bounds.jerk * gain + first * first / 2)));
  Ramp result;
  result.jerk = {std::copysign(bounds.jerk, sign * (peak - first)), 0, -sign * bounds.jerk};
  result.duration[0] = std::abs(peak - first) / bounds.jerk;
  result.duration[2] = peak / bounds.jerk;
  const double gained = (first + peak) / 2 * result.duration[0] + peak / 2 * result.duration[2];
  if (peak > 0) result.duration[1] = std::max(0.0, gain - gained) / peak;
  return result;
}

double OnlineProfile::distance(const AxisState& start, double speed, const ProfileBounds& bounds) {
  AxisState state{0, start.qd, start.qdd};
  const Ramp up = ramp(state.qd, state.qdd, speed, bounds);
  for (std::size_t i = 0; i < 3; ++i) state = advanced(state, up.jerk[i], up.duration[i]);
  const Ramp down = ramp(speed, 0, 0, bounds);
  state = {state.q, speed, 0};
  for (std::size_t i = 0; i < 3; ++i) state = advanced(state, down.jerk[i], down.duration[i]);
  return state.q;
}

/// A speed in [0, upper bound] whose two ramps cover `way` or a little less; a cruise fills the
/// rest. By Ridders' method (C. Ridders, IEEE Trans. Circuits and Systems 26, 1979), which never
/// leaves its bracket and halves it at least. The lower end of the bracket is the answer: near
/// the natural velocity the way grows as a square root, so that no double speed meets it exactly.
double OnlineProfile::cruise_speed(const AxisState& start, double way,
                                   const ProfileBounds& bounds) {
  const auto excess = [&](double speed) { return distance(start, speed, bounds) - way; };
  double lower = 0;
  double upper = bounds.velocity_upper;
  double at_lower = excess(lower);
  double at_upper = excess(upper);
  if (at_upper <= 0) return upper;
  if (at_lower >= 0) return lower;
  // Above the speed that it has anyway, the way grows with the speed: the quicker of two answers.
  const double natural = natural_velocity(start, bounds.jerk);
  if (natural > lower && natural < upper) {
    const double at_natural = excess(natural);
    (at_natural <= 0 ? lower : upper) = natural;
    (at_natural <= 0 ? at_lower : at_upper) = at_natural;
  }
  const double tolerance = kWayTolerance * (std::abs(way) - at_lower);
  double best = lower;
  for (int i = 0; i < kSearchSteps && at_lower < -tolerance; ++i) {
    const double middle = (lower + upper) / 2;
    const double at_middle = excess(middle);
    // The ends differ in sign, so the root is real, and 0 only where the middle is the answer.
    const double root = std::sqrt(at_middle * at_middle - at_lower * at_upper);
    best = root > 0 ? middle - (middle - lower) * at_middle / root : middle;
    best = std::clamp(best, lower, upper);
    const double at_best = excess(best);
    const auto narrow = [&](double speed, double at_speed) {
      if (speed <= lower || speed >= upper) return;
      (at_speed <= 0 ? lower : upper) = speed;
      (at_speed <= 0 ? at_lower : at_upper) = at_speed;
    };
    narrow(middle, at_middle);
    narrow(best, at_best);
    if (std::abs(at_best) <= tolerance) {
      const double below = best - 1e-9 * (best - lower);
      narrow(below, excess(below));
      break;
    }
  }
  return lower > 0 ? lower : best;
}

void OnlineProfile::append(double jerk, double duration, AxisState& state) {
  if (!(duration > 0)) return;
  SINEW_ASSERT(size_ < kPhasesMax);
  phases_[size_++] = {state, jerk, duration};
  duration_ += duration;
  state = advanced(state, jerk, duration);
}

void OnlineProfile::append(const Ramp& ramp, AxisState& state) {
  for (std::size_t i = 0; i < 3; ++i) append(ramp.jerk[i], ramp.duration[i], state);
}

OnlineProfile OnlineProfile::stop(const AxisState& start, const ProfileBounds& bounds) {
  OnlineProfile profile;
  AxisState state = start;
  profile.append(ramp(state.qd, state.qdd, 0, bounds), state);
  profile.target_ = state.q;
  return profile;
}

OnlineProfile OnlineProfile::to(const AxisState& start, double target,
                                const ProfileBounds& bounds) {
  SINEW_ASSERT(std::isfinite(start.q) && std::isfinite(start.qd) && std::isfinite(start.qdd));
  SINEW_ASSERT(std::isfinite(target));
  SINEW_ASSERT(bounds.jerk > 0 && bounds.velocity_upper > 0 && bounds.velocity_lower < 0);
  SINEW_ASSERT(bounds.acceleration_upper > 0 && bounds.acceleration_lower < 0);
  const bool forwards = target - start.q >= distance(start, 0, bounds);
  const AxisState from = forwards ? start : mirrored(start);
  const ProfileBounds sided = forwards ? bounds : bounds.mirrored();
  const double way = forwards ? target - start.q : start.q - target;

  const double speed = cruise_speed(from, way, sided);
  OnlineProfile profile;
  AxisState state = from;
  profile.append(ramp(state.qd, state.qdd, speed, sided), state);
  // Rounding at the ramp's end must not grow over a long cruise.
  state.qd = speed;
  state.qdd = 0;
  if (speed > 0) profile.append(0, (way - distance(from, speed, sided)) / speed, state);
  profile.append(ramp(speed, 0, 0, sided), state);
  if (!forwards) {
    for (std::size_t i = 0; i < profile.size_; ++i) {
      profile.phases_[i].start = mirrored(profile.phases_[i].start);
      profile.phases_[i].jerk = -profile.phases_[i].jerk;
    }
  }
  profile.target_ = target;
  return profile;
}

AxisState OnlineProfile::at(double t) const {
  if (t >= duration_) return {target_, 0, 0};
  for (std::size_t i = 0; i < size_; ++i) {
    const Phase& phase = phases_[i];
    if (t < phase.duration) return advanced(phase.start, phase.jerk, std::max(0.0, t));
    t -= phase.duration;
  }
  return {target_, 0, 0};
}

PositionRange OnlineProfile::range() const {
  PositionRange result{target_, target_};
  const auto take = [&](double q) {
    result.lower = std::min(result.lower, q);
    result.upper = std::max(result.upper, q);
  };
  for (std::size_t i = 0; i < size_; ++i) {
    const Phase& phase = phases_[i];
    take(phase.start.q);
    // It turns where qd + qdd t + jerk t^2 / 2 = 0, in the form that loses no digits.
    const double root = phase.start.qdd * phase.start.qdd - 2 * phase.jerk * phase.start.qd;
    if (root < 0) continue;
    const double w = -(phase.start.qdd + std::copysign(std::sqrt(root), phase.start.qdd));
    for (const double t : {w / phase.jerk, 2 * phase.start.qd / w}) {
      if (t > 0 && t < phase.duration) take(advanced(phase.start, phase.jerk, t).q);
    }
  }
  return result;
}

}  // namespace sinew::motion
