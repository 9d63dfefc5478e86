#pragma once

#include <array>
#include <cstddef>
#include <span>

namespace sinew::motion {

inline constexpr std::size_t kAxesMax = 8;

/// What one axis may do, all > 0; rad (or m) per s, s^2, s^3.
struct AxisLimits {
  double velocity = 0;
  double acceleration = 0;
  double jerk = 0;
};

/// State of all axes at one instant: q in rad or m, its first and second derivative.
struct AxisStates {
  std::array<double, kAxesMax> q;
  std::array<double, kAxesMax> qd;
  std::array<double, kAxesMax> qdd;
};

/// The quickest jerk-limited move of one axis over a distance, from rest to rest. It is symmetric:
/// jerk up, steady acceleration, jerk down, cruise, and the same backwards.
///
/// Source: L. Biagiotti, C. Melchiorri, Trajectory Planning for Automatic Machines and Robots,
/// 2008, section 3.4; every peak is as high as its limit or the distance allows.
struct JerkLimitedMove {
  double jerk = 0;         ///< >= 0
  double jerk_time = 0;    ///< s, each of the two jerk phases of one ramp
  double ramp_time = 0;    ///< s, from rest to cruise
  double cruise_time = 0;  ///< s
  double duration() const { return 2 * ramp_time + cruise_time; }
  double velocity() const { return jerk * jerk_time * (ramp_time - jerk_time); }
  double acceleration() const { return jerk * jerk_time; }
};

/// @param distance  >= 0 and finite; rad or m. @rt
JerkLimitedMove plan_axis(double distance, const AxisLimits& limits);

/// Rest-to-rest move of several axes that all start and arrive together, in the shortest time in
/// which the slowest of them can do it. Where the limits allow, every axis follows the slowest
/// one's shape, so that the path is straight in joint space; else an axis keeps its own shape,
/// stretched in time. Velocity, acceleration and jerk of every axis stay inside its limits. @rt
class RestToRest {
 public:
  /// @param start, target  rad or m, finite, one per axis, at most kAxesMax.
  RestToRest(std::span<const double> start, std::span<const double> target,
             std::span<const AxisLimits> limits);

  std::size_t size() const { return size_; }
  double duration() const { return duration_; }  ///< s
  /// The slowest axis, which sets the duration.
  std::size_t slowest() const { return slowest_; }
  /// All axes share one shape: the path is a straight line in joint space.
  bool straight() const { return straight_; }

  /// States at t (s), clamped to [0, duration]; exactly start and target at the ends. Elements
  /// from size() on are not defined.
  void sample(double t, AxisStates& out) const;

  /// The same, in the version that sample() takes on a processor without wide vectors.
  void sample_portable(double t, AxisStates& out) const;

 private:
  void set_axis(std::size_t i, const JerkLimitedMove& move, double jerk);

  using Lanes = std::array<double, kAxesMax>;
  std::size_t size_ = 0;
  std::size_t slowest_ = 0;
  bool straight_ = true;
  double duration_ = 0;
  Lanes start_{}, target_{}, jerk_{}, velocity_{};  // jerk and velocity carry the direction
  Lanes jerk_end_{}, fall_start_{}, ramp_end_{};    // s: ends of the phases of a ramp
};

}  // namespace sinew::motion
