#pragma once

#include <array>
#include <cstddef>

#include "sinew/motion/rest_to_rest.h"

namespace sinew::motion {

/// One axis at one instant: rad (or m), and its first two derivatives.
struct AxisState {
  double q = 0;
  double qd = 0;
  double qdd = 0;
};

/// What a profile may do, with sides of their own: lower < 0 < upper, jerk > 0. Seen from a target
/// that moves, an axis may still speed up in one direction when it hardly can in the other.
struct ProfileBounds {
  double velocity_lower = 0;
  double velocity_upper = 0;
  double acceleration_lower = 0;
  double acceleration_upper = 0;
  double jerk = 0;

  ProfileBounds() = default;
  explicit ProfileBounds(const AxisLimits& limits)
      : velocity_lower(-limits.velocity),
        velocity_upper(limits.velocity),
        acceleration_lower(-limits.acceleration),
        acceleration_upper(limits.acceleration),
        jerk(limits.jerk) {}
  /// The same, with the axis turned round.
  ProfileBounds mirrored() const;
};

struct PositionRange {
  double lower = 0;
  double upper = 0;
};

/// Jerk-limited motion of one axis from any state to rest: a ramp to a steady speed, a while at
/// that speed, a ramp to rest. Where the start keeps the bounds, so does every instant after it.
/// It is not always the quickest: an axis that must shorten its way slows down first.
///
/// Replanned from any instant of itself to any target inside [a, b], a motion that would have
/// stopped inside [a, b] stays there: the ramps brake as hard as the bounds allow, so a later plan
/// never needs more room than the earlier one had left. That is why limits of position are limits
/// of targets.
///
/// Source: L. Biagiotti, C. Melchiorri, Trajectory Planning for Automatic Machines and Robots,
/// 2008, section 3.4, for the ramps; the speed between them is a root search over the distance,
/// which is continuous in that speed. At most 70 evaluations, no allocation. @rt
class OnlineProfile {
 public:
  /// At rest at 0.
  OnlineProfile() = default;

  /// @param start, target  finite.
  static OnlineProfile to(const AxisState& start, double target, const ProfileBounds& bounds);
  /// To rest, as soon as the bounds allow.
  static OnlineProfile stop(const AxisState& start, const ProfileBounds& bounds);

  /// State at t (s) >= 0. From duration() on it is at rest at target(), exactly.
  AxisState at(double t) const;
  double duration() const { return duration_; }  ///< s
  double target() const { return target_; }
  /// Everywhere it comes by.
  PositionRange range() const;

 private:
  struct Phase {
    AxisState start;
    double jerk = 0;
    double duration = 0;  ///< s
  };
  struct Ramp;

  static Ramp ramp(double qd, double qdd, double qd_end, const ProfileBounds& bounds);
  static double distance(const AxisState& start, double speed, const ProfileBounds& bounds);
  static double cruise_speed(const AxisState& start, double way, const ProfileBounds& bounds);
  void append(double jerk, double duration, AxisState& state);
  void append(const Ramp& ramp, AxisState& state);

  static constexpr std::size_t kPhasesMax = 7;
  std::array<Phase, kPhasesMax> phases_{};
  std::size_t size_ = 0;
  double duration_ = 0;
  double target_ = 0;
};

/// State after `dt` (s) of constant jerk. @rt
inline AxisState advanced(const AxisState& state, double jerk, double dt) {
  return {state.q + dt * (state.qd + dt * (0.5 * state.qdd + dt * jerk * (1.0 / 6))),
          state.qd + dt * (state.qdd + dt * (0.5 * jerk)), state.qdd + dt * jerk};
}

}  // namespace sinew::motion
