#pragma once

#include "sinew/motion/online_profile.h"

namespace sinew::motion {

/// Follows a stream of setpoints, each of which says where the axis shall be when the next one
/// comes, and how fast then. It learns the stream's period from the arrivals and evens their
/// jitter out, draws a cubic through the setpoints (position and velocity), smooths it, and follows
/// that at its own rate.
///
/// The smoothing is three first-order lags in a row. Their answer to an impulse is never negative,
/// so what comes out is a weighted mean of what went in: a stream that keeps its limits still
/// does, kDelay later, and all axes of an arm are late by the same.
///
/// Velocity, acceleration and jerk stay inside the limits whatever the stream says, and at every
/// instant a stop would still end inside the position limits. A stream that jumps is caught up
/// with, with what the limits leave beside its own motion. When it ends, the last velocity is kept
/// for as long as two setpoints might have got lost; then the axis comes to rest.
///
/// Seconds and rad (or m); no clock, no allocation. @rt
class SetpointFollower {
 public:
  static constexpr double kLag = 0.010;       ///< s, each of the three
  static constexpr double kDelay = 3 * kLag;  ///< s, behind the stream

  SetpointFollower() = default;
  SetpointFollower(const AxisLimits& limits, const PositionRange& range)
      : limits_(limits), range_(range) {}

  /// The first setpoint will be the next; until it comes the axis comes to rest.
  void begin(const AxisState& state);
  /// Taken at the next step(). @param q, qd  finite, q in the range.
  void setpoint(double q, double qd);
  /// Where the axis shall be `dt` > 0 after `state`.
  AxisState step(const AxisState& state, double dt);
  /// No setpoint for so long that it brakes.
  bool silent() const { return silent_; }
  double last_setpoint() const { return to_.q; }

 private:
  void take_setpoint();
  double drawn(double clock) const;
  double advance_goal(double dt);
  double wanted_jerk(const AxisState& state, const AxisState& goal, double goal_jerk,
                     double dt) const;
  bool keeps_limits(const AxisState& before, const AxisState& after) const;
  AxisState nearest_allowed(const AxisState& state, const AxisState& stopping, double jerk,
                            double dt) const;

  struct Knot {
    double q = 0;
    double qd = 0;
  };

  AxisLimits limits_;
  PositionRange range_;
  double clock_ = 0;  ///< s since begin()
  Knot from_, to_, next_;
  bool pending_ = false;
  bool running_ = false;
  bool silent_ = true;
  double begin_ = 0;  ///< s, evened out: the cubic runs from here for one period
  double period_ = 0;
  bool rhythm_known_ = false;  ///< two arrivals have shown the period
  int arrivals_ = 0;           ///< since the rhythm began
  int gaps_ = 0;
  AxisState goal_;  ///< the smoothed stream, now
};

}  // namespace sinew::motion
