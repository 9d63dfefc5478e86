#include "sinew/motion/setpoint_follower.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace sinew::motion {
namespace {

// s. A stream is expected every 2 to 10 ms; beyond these it is not one.
constexpr double kPeriodMin = 5e-4;
constexpr double kPeriodMax = 0.05;
constexpr double kPeriodFirst = 5e-3;  ///< until two setpoints have shown it
/// Shares of an arrival's lateness that move the phase and the period, once the rhythm is known:
/// jitter of one control tick is evened out over some thirty setpoints.
constexpr double kPhaseGain = 0.06;
constexpr double kPeriodGain = 0.001;
/// Setpoints in a row that come after more than one period, until that is the new period.
constexpr int kGapsMax = 2;
/// Periods after the end of a cubic for which its last velocity is kept.
constexpr double kLostSetpoints = 2;
/// Poles of the pull towards the goal, 1/s: the strongest one that the jerk allows. What rounding
/// or a lost setpoint left is gone in 0.2 s.
constexpr std::array kPulls{20.0, 10.0, 5.0, 2.5};
constexpr int kSearchSteps = 8;
constexpr double kStateTolerance = 1e-9;  // of a limit

}  // namespace

void SetpointFollower::begin(const AxisState& state) {
  clock_ = 0;
  from_ = to_ = {state.q, 0};
  goal_ = state;
  pending_ = running_ = false;
  silent_ = true;
  period_ = kPeriodFirst;
}

void SetpointFollower::setpoint(double q, double qd) {
  next_ = {std::clamp(q, range_.lower, range_.upper),
           std::clamp(qd, -limits_.velocity, limits_.velocity)};
  pending_ = true;
}

void SetpointFollower::take_setpoint() {
  pending_ = false;
  const bool first = !running_ || silent_;
  const double since = clock_ - begin_;
  const double periods = first ? 0 : std::round(since / period_);
  from_ = to_;
  if (first) {
    begin_ = clock_;
    rhythm_known_ = false;
  } else if (!rhythm_known_ || periods < 1 || (periods > 1 && gaps_ >= kGapsMax)) {
    // The first interval, or another rhythm: the evened one is worth nothing.
    period_ = std::clamp(since, kPeriodMin, kPeriodMax);
    begin_ = clock_;
    rhythm_known_ = true;
    arrivals_ = 2;
    gaps_ = 0;
  } else {
    const double late = since - periods * period_;
    gaps_ = periods > 1 ? gaps_ + 1 : 0;
    // Where setpoints were lost, the axis went on with the last velocity.
    from_.q += (periods - 1) * period_ * from_.qd;
    // A straight line through all arrivals so far, then through the latest ones (E. Brookner,
    // Tracking and Kalman Filtering Made Easy, 1998, section 1.2.10, expanding memory).
    arrivals_ = std::min(arrivals_ + 1, 1000);
    const double n = arrivals_;
    const double phase_gain = std::max(kPhaseGain, 2 * (2 * n - 1) / (n * (n + 1)));
    const double period_gain = std::max(kPeriodGain, 6 / (n * (n + 1)));
    begin_ += periods * period_ + phase_gain * late;
    period_ = std::clamp(period_ + period_gain * late / periods, kPeriodMin, kPeriodMax);
  }
  to_ = next_;
  running_ = true;
  silent_ = false;
}

/// Cubic Hermite from the last knot to the newest; after it, the newest one's velocity.
double SetpointFollower::drawn(double clock) const {
  const double u = std::max((clock - begin_) / period_, -0.5);
  if (u >= 1) return to_.q + (u - 1) * period_ * to_.qd;
  const double way = to_.q - from_.q;
  const double at_start = from_.qd * period_;
  const double at_end = to_.qd * period_;
  return from_.q +
         u * (at_start + u * (3 * way - 2 * at_start - at_end + u * (at_start + at_end - 2 * way)));
}

/// Smooths the cubic over the next `dt`; the mean jerk.
double SetpointFollower::advance_goal(double dt) {
  const int steps = static_cast<int>(std::ceil(dt / (kLag / 5)));
  const double h = dt / steps;
  const double before = goal_.qdd;
  for (int i = 0; i < steps; ++i) {
    const double ahead = drawn(clock_ + i * h) - goal_.q;
    const double jerk = ((ahead / kLag - 3 * goal_.qd) / kLag - 3 * goal_.qdd) / kLag;
    goal_ = advanced(goal_, jerk, h);
  }
  return (goal_.qdd - before) / dt;
}

double SetpointFollower::wanted_jerk(const AxisState& state, const AxisState& goal,
                                     double goal_jerk, double dt) const {
  const AxisState error{goal.q - state.q, goal.qd - state.qd, goal.qdd - state.qdd};
  const double jerk = limits_.jerk;
  for (const double pole : kPulls) {
    const double pull_q = pole * pole * pole * error.q;
    const double pull_qd = 3 * pole * pole * error.qd;
    const double pull_qdd = 3 * pole * error.qdd;
    if (std::abs(pull_q) + std::abs(pull_qd) + std::abs(pull_qdd) > jerk) continue;
    return std::clamp(goal_jerk + pull_q + pull_qd + pull_qdd, -jerk, jerk);
  }
  // Far away: to where the goal would come to rest if it began to brake now. That place never
  // comes back towards the axis, so it is approached without passing it.
  const ProfileBounds bounds(limits_);
  const double rest =
      std::clamp(OnlineProfile::stop(goal, bounds).target(), range_.lower, range_.upper);
  return (OnlineProfile::to(state, rest, bounds).at(dt).qdd - state.qdd) / dt;
}

/// Would a stop from `after` still keep every limit? Where the axis was outside the position
/// limits already, it may stay but not go farther.
bool SetpointFollower::keeps_limits(const AxisState& before, const AxisState& after) const {
  const double slack = 1 + kStateTolerance;
  if (std::abs(after.qdd) > limits_.acceleration * slack) return false;
  const double released = after.qd + after.qdd * std::abs(after.qdd) / (2 * limits_.jerk);
  if (std::abs(released) > limits_.velocity * slack) return false;
  if (std::abs(after.qd) > limits_.velocity * slack) return false;
  const PositionRange stop = OnlineProfile::stop(after, ProfileBounds(limits_)).range();
  return stop.lower >= std::min(range_.lower, before.q) &&
         stop.upper <= std::max(range_.upper, before.q);
}

AxisState SetpointFollower::step(const AxisState& state, double dt) {
  if (pending_ && (!running_ || silent_)) {
    goal_ = state;
    to_ = {state.q, state.qd};
  }
  const bool follows = running_ && !silent_;
  double jerk = 0;
  if (follows) {
    const AxisState goal = goal_;
    jerk = wanted_jerk(state, goal, advance_goal(dt), dt);
  }
  clock_ += dt;
  if (pending_) take_setpoint();
  silent_ = !running_ || clock_ > begin_ + (1 + kLostSetpoints) * period_ + dt;
  const AxisState stopping = OnlineProfile::stop(state, ProfileBounds(limits_)).at(dt);
  if (!follows || silent_) return stopping;
  const double room = limits_.acceleration;
  jerk = std::clamp(jerk, std::min(0.0, (-room - state.qdd) / dt),
                    std::max(0.0, (room - state.qdd) / dt));
  const AxisState after = advanced(state, jerk, dt);
  if (keeps_limits(state, after)) return after;
  return nearest_allowed(state, stopping, jerk, dt);
}

/// The jerk nearest to the wanted one after which the axis could still stop in time. Braking
/// always is allowed, so the search narrows from there.
AxisState SetpointFollower::nearest_allowed(const AxisState& state, const AxisState& stopping,
                                            double jerk, double dt) const {
  double good = (stopping.qdd - state.qdd) / dt;
  double bad = jerk;
  AxisState best = stopping;
  for (int i = 0; i < kSearchSteps; ++i) {
    const double middle = (good + bad) / 2;
    const AxisState after = advanced(state, middle, dt);
    const bool allowed = keeps_limits(state, after);
    (allowed ? good : bad) = middle;
    if (allowed) best = after;
  }
  return best;
}

}  // namespace sinew::motion
