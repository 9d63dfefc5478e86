#include "sinew/motion/setpoint_follower.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace sinew::motion {
namespace {

// s. A stream is expected every 1 to 10 ms; beyond these it is not one.
constexpr double kPeriodMin = 5e-4;
constexpr double kPeriodMax = 0.05;
constexpr double kPeriodFirst = 5e-3;  ///< until two setpoints have shown it
/// Intervals that the mean period is made of; one counts as two of the mean at most, so that a
/// pause of the host is no new period.
constexpr int kPeriodMemory = 50;
constexpr double kIntervalMax = 2;
/// s. Time constant of the pull of the setpoints' positions: a position that is off by the way of
/// a millisecond at 30 deg/s shows as 0.06 deg/s.
constexpr double kPullTime = 0.5;
/// A position that is farther off than jitter explains is a jump: the line jumps with it.
constexpr double kJitterTime = 0.01;    // s of the stream's own speed
constexpr double kJitterPeriods = 2;    // likewise; the longer one counts
constexpr double kJitterAtRest = 2e-5;  // rad: units of a wire
/// Setpoints in a row that may get lost.
constexpr double kLostSetpoints = 2;
/// Poles of the pull towards the goal, 1/s: the strongest one that the jerk allows. What rounding
/// or a lost setpoint left is gone in 0.2 s.
constexpr std::array kPulls{20.0, 10.0, 5.0, 2.5};
constexpr int kSearchSteps = 8;
constexpr double kStateTolerance = 1e-9;  // of a limit

}  // namespace

void SetpointFollower::begin(const AxisState& state) {
  line_ = {state.q, 0};
  room_ = {std::min(range_.lower, state.q), std::max(range_.upper, state.q)};
  goal_ = state;
  pending_ = running_ = false;
  silent_ = true;
  period_ = kPeriodFirst;
  arrivals_ = 0;
  age_ = towards_ = apart_ = 0;
}

void SetpointFollower::setpoint(double q, double qd) {
  next_ = {std::clamp(q, room_.lower, room_.upper),
           std::clamp(qd, -limits_.velocity, limits_.velocity)};
  pending_ = true;
}

void SetpointFollower::take_setpoint() {
  pending_ = false;
  const bool first = !running_ || silent_;
  if (!first) {
    arrivals_ = std::min(arrivals_ + 1, kPeriodMemory);
    const double most = arrivals_ == 1 ? kPeriodMax : kIntervalMax * period_;
    const double interval = std::clamp(age_, kPeriodMin, std::min(most, kPeriodMax));
    period_ += (interval - period_) / arrivals_;
  } else {
    line_ = {next_.q - period_ * next_.qd, next_.qd};
    goal_ = {line_.q - kDelay * next_.qd, next_.qd, 0};
  }
  age_ = 0;
  towards_ = next_.qd;
  apart_ = next_.q - line_.q - period_ * (line_.qd + towards_) / 2;
  const double speed = std::max(std::abs(line_.qd), std::abs(towards_));
  const double jitter = kJitterAtRest + speed * std::max(kJitterTime, kJitterPeriods * period_);
  const double jump = apart_ - std::clamp(apart_, -jitter, jitter);
  apart_ -= jump;
  line_.q += jump;
  goal_.q += jump;
  running_ = true;
  silent_ = false;
}

/// The line goes on for `dt`: evenly to the newest velocity within a period of its arrival, then
/// with that one.
void SetpointFollower::draw(double dt) {
  const double left = period_ - age_;
  const double share = left > dt ? dt / left : 1;
  const double before = line_.qd;
  line_.qd += share * (towards_ - before);
  const double ramp = std::clamp(left, 0.0, dt);
  const double pulled = apart_ * (1 - std::exp(-dt / kPullTime));
  line_.q += ramp * (before + line_.qd) / 2 + (dt - ramp) * line_.qd + pulled;
  apart_ -= pulled;
  age_ += dt;
}

/// Draws the line on and smooths it, over the next `dt`; the mean jerk.
double SetpointFollower::advance_goal(double dt) {
  const int steps = static_cast<int>(std::ceil(dt / (kLag / 5)));
  const double h = dt / steps;
  const double before = goal_.qdd;
  for (int i = 0; i < steps; ++i) {
    const double ahead = line_.q - goal_.q;
    draw(h);
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
      std::clamp(OnlineProfile::stop(goal, bounds).target(), room_.lower, room_.upper);
  return (OnlineProfile::to(state, rest, bounds).at(dt).qdd - state.qdd) / dt;
}

/// Would a stop from `after` still keep every limit, and not pass where the stream could stop?
/// Where the axis was outside already, it may stay but not go farther.
bool SetpointFollower::keeps_limits(const AxisState& before, const AxisState& after) const {
  const double slack = 1 + kStateTolerance;
  if (std::abs(after.qdd) > limits_.acceleration * slack) return false;
  const double released = after.qd + after.qdd * std::abs(after.qdd) / (2 * limits_.jerk);
  if (std::abs(released) > limits_.velocity * slack) return false;
  if (std::abs(after.qd) > limits_.velocity * slack) return false;
  const PositionRange stop = OnlineProfile::stop(after, ProfileBounds(limits_)).range();
  return stop.lower >= std::min(reach_.lower, before.q) &&
         stop.upper <= std::max(reach_.upper, before.q);
}

AxisState SetpointFollower::step(const AxisState& state, double dt) {
  const bool follows = running_ && !silent_;
  double jerk = 0;
  if (follows) {
    const AxisState goal = goal_;
    jerk = wanted_jerk(state, goal, advance_goal(dt), dt);
  }
  if (pending_) take_setpoint();
  silent_ = !running_ || age_ > std::max(kHold, (1 + kLostSetpoints) * period_) + dt;
  const ProfileBounds bounds(limits_);
  const AxisState stopping = OnlineProfile::stop(state, bounds).at(dt);
  if (!follows || silent_) return stopping;
  // A stream that keeps the limits can never stop sooner later on, so whoever can stop there now
  // will not pass it when it stops.
  const PositionRange stream = OnlineProfile::stop(goal_, bounds).range();
  reach_ = {std::max(range_.lower, stream.lower - kBeyond),
            std::min(range_.upper, stream.upper + kBeyond)};
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
