#pragma once

namespace sinew::motion {

/// One axis from rest to rest with a trapezoid (or triangle) of speed: the profile that a
/// point-to-point device makes for itself. Any unit of length; seconds. @rt
class Trapezoid {
 public:
  /// Stays at 0.
  Trapezoid() = default;

  /// The fastest way over `distance` (either sign). velocity_max > 0 and acceleration_max > 0 are
  /// the caller's promise, asserted.
  ///
  /// Source: with D = |distance| the top speed is v = min(velocity_max, sqrt(a D)); the ramps take
  /// v / a each, the way between them (D - v^2 / a) / v.
  Trapezoid(double distance, double velocity_max, double acceleration_max);

  struct Point {
    double position = 0;  ///< from 0 at the start to `distance`
    double velocity = 0;  ///< per s, signed
  };

  /// Where it is `t` s after the start; held at both ends.
  Point at(double t) const;

  double duration() const { return 2 * ramp_ + cruise_; }
  double distance() const { return distance_; }
  double velocity() const { return velocity_; }  ///< of the level part, unsigned

  /// The same way in `duration` >= duration(), slowed evenly: speed by k, acceleration by k^2.
  Trapezoid stretched(double duration) const;

 private:
  double distance_ = 0;
  double velocity_ = 0;
  double acceleration_ = 0;
  double ramp_ = 0;    ///< s, each
  double cruise_ = 0;  ///< s
};

}  // namespace sinew::motion
