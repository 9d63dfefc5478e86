#pragma once

#include "sinew/motion/online_profile.h"

namespace sinew::motion {

/// Follows a stream of setpoints, each of which says where the axis shall be when the next one
/// comes, and how fast then. Arrivals jitter, and a host takes its setpoints from its motion when
/// it sends them: a millisecond at 30 deg/s is 0.03 deg that the setpoints are apart and the motion
/// is not. Their velocities are hardly touched by that, so the axis goes by the velocities, and the
/// positions only pull, slowly (first-order complementary filter). What comes of it is smoothed.
///
/// The smoothing is three first-order lags in a row. Their answer to an impulse is never negative,
/// so what comes out is a weighted mean of what went in: a stream that keeps its limits still
/// does, kDelay later, and all axes of an arm are late by the same.
///
/// Velocity, acceleration and jerk stay inside the limits whatever the stream says, and at every
/// instant a stop would still end inside the position limits, and no farther than kBeyond behind
/// the place where the stream itself could stop: who catches up does not run past. A stream that
/// jumps is caught up with, with what the limits leave beside its own motion. When it ends, the
/// last velocity is kept for kHold or for two setpoints that might have got lost, whichever is
/// longer; then the axis comes to rest.
///
/// Seconds and rad (or m); no clock, no allocation. @rt
class SetpointFollower {
 public:
  static constexpr double kLag = 0.010;       ///< s, each of the three
  static constexpr double kDelay = 3 * kLag;  ///< s, behind the stream
  static constexpr double kHold = 0.020;      ///< s
  static constexpr double kBeyond = 2e-4;     ///< rad: two microsteps of a 17:1 gear

  SetpointFollower() = default;
  SetpointFollower(const AxisLimits& limits, const PositionRange& range)
      : limits_(limits), range_(range), room_(range) {}

  /// The first setpoint will be the next; until it comes the axis comes to rest. From beyond the
  /// position limits setpoints on the way back in are taken too.
  void begin(const AxisState& state);
  /// Taken at the next step(). @param q, qd  finite, q in the range.
  void setpoint(double q, double qd);
  /// Where the axis shall be `dt` > 0 after `state`.
  AxisState step(const AxisState& state, double dt);
  /// No setpoint for so long that it brakes.
  bool silent() const { return silent_; }
  /// Way from the stream, the delay allowed for, to a state; 0 where there is no stream.
  double astray(const AxisState& state) const {
    return running_ && !silent_ ? state.q - goal_.q : 0;
  }

 private:
  void take_setpoint();
  void draw(double dt);
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
  PositionRange room_;  ///< of setpoints: wider where it began outside
  Knot next_;           ///< setpoint that came since the last step()
  bool pending_ = false;
  bool running_ = false;
  bool silent_ = true;
  double age_ = 0;       ///< s since the last setpoint
  double period_ = 0;    ///< s, mean of the arrivals
  int arrivals_ = 0;     ///< intervals that the mean is made of
  Knot line_;            ///< the stream, now: its velocities, drawn together
  double towards_ = 0;   ///< velocity of the newest setpoint, reached a period after it came
  double apart_ = 0;     ///< rad from the line to the setpoints' positions
  AxisState goal_;       ///< the line, smoothed
  PositionRange reach_;  ///< where a stop of the stream could end, now
};

}  // namespace sinew::motion
