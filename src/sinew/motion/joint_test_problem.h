#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "sinew/motion/joint_profile.h"
#include "sinew/motion/state_to_state.h"
#include "support/how_many.h"
#include "support/property.h"

namespace sinew::motion::test {

using sinew::test::Random;

/// One joint from a state to a state.
struct JointProblem {
  AxisState start;
  AxisState target;
  ProfileBounds bounds;
};

/// Cases of the large properties: SINEW_MOTION_CASES where it is set.
inline std::uint64_t cases_wanted(std::uint64_t usual) {
  return sinew::test::how_many("SINEW_MOTION_CASES", usual);
}

inline double spread(Random& random, double decades) {
  return std::pow(10, random.uniform(-decades, decades));
}

/// Limits with sides of their own, over so many decades each way around 1.
inline ProfileBounds random_bounds(Random& random, double decades) {
  ProfileBounds bounds;
  bounds.velocity_upper = spread(random, decades);
  bounds.velocity_lower = -spread(random, decades);
  bounds.acceleration_upper = spread(random, decades);
  bounds.acceleration_lower = -spread(random, decades);
  bounds.jerk = 10 * spread(random, decades);
  if (random.chance(0.3)) {
    bounds.velocity_lower = -bounds.velocity_upper;
    bounds.acceleration_lower = -bounds.acceleration_upper;
  }
  return bounds;
}

/// Inside, and often right at a limit: at rest, at a velocity limit, with an acceleration at its
/// limit, or so that the velocity just comes to its limit with full jerk.
inline AxisState random_state(Random& random, const ProfileBounds& bounds) {
  const double low = bounds.velocity_lower;
  const double high = bounds.velocity_upper;
  for (;;) {
    AxisState state{random.uniform(-3, 3), random.uniform(low, high),
                    random.uniform(bounds.acceleration_lower, bounds.acceleration_upper)};
    if (random.chance(0.1)) state.qdd = bounds.acceleration_upper;
    if (random.chance(0.1)) state.qdd = bounds.acceleration_lower;
    if (random.chance(0.3)) state.qdd = 0;
    const double margin = state.qdd * state.qdd / (2 * bounds.jerk);
    if (random.chance(0.1)) state.qd = high - margin;
    if (random.chance(0.1)) state.qd = low + margin;
    if (random.chance(0.2)) state.qd = 0;
    if (!refusal_of_target(state, bounds)) return state;
  }
}

inline JointProblem random_problem(Random& random, double decades = 1) {
  JointProblem problem;
  problem.bounds = random_bounds(random, decades);
  problem.start = random_state(random, problem.bounds);
  problem.target = random_state(random, problem.bounds);
  if (random.chance(0.3)) {
    const double distance = std::pow(10, random.uniform(-9, 2));
    problem.target.q = problem.start.q + (random.chance(0.5) ? distance : -distance);
  }
  if (random.chance(0.05)) {
    problem.target.qd = problem.start.qd;
    problem.target.qdd = problem.start.qdd;
  }
  if (random.chance(0.02)) problem.target = problem.start;
  return problem;
}

inline JointProblem mirrored(const JointProblem& problem) {
  const auto turn = [](const AxisState& s) { return AxisState{-s.q, -s.qd, -s.qdd}; };
  return {turn(problem.start), turn(problem.target), problem.bounds.mirrored()};
}

inline StateToState planner(const JointProblem& problem) {
  return {problem.start, problem.target, problem.bounds};
}

/// What double numbers can hold of a motion of this duration: instants are known to `t`, and an
/// error of one instant grows with the rest of the time. 1e-9 where moves last a minute or less.
struct Slack {
  Slack(const ProfileBounds& bounds, double duration, double rounding = 1e-15) {
    const double a = std::max(bounds.acceleration_upper, -bounds.acceleration_lower);
    const double v = std::max(bounds.velocity_upper, -bounds.velocity_lower);
    const double t = rounding * duration;
    qdd = 1e-9 + 10 * t * bounds.jerk;
    qd = 1e-9 + t * a;
    q = 1e-9 + t * (a * duration + v);
  }
  double q, qd, qdd;
};

/// Walks through the phases by itself: they join, keep the bounds at every instant (velocity and
/// acceleration have their extremes where a phase begins or where the acceleration is 0) and end at
/// the target.
/// @param from      s: when the bounds must be kept
/// @param rounding  of an instant, relative
inline void expect_sound(const JointProblem& problem, const JointProfile& profile, double from = 0,
                         double rounding = 1e-15) {
  const Slack slack(problem.bounds, profile.duration(), rounding);
  const ProfileBounds& bounds = problem.bounds;
  AxisState state = problem.start;
  double time = 0;
  const auto expect_inside = [&](const AxisState& now) {
    ASSERT_LE(now.qd, bounds.velocity_upper + slack.qd) << "at " << time;
    ASSERT_GE(now.qd, bounds.velocity_lower - slack.qd) << "at " << time;
    ASSERT_LE(now.qdd, bounds.acceleration_upper + slack.qdd) << "at " << time;
    ASSERT_GE(now.qdd, bounds.acceleration_lower - slack.qdd) << "at " << time;
  };
  for (std::size_t i = 0; i < profile.size(); ++i) {
    const ProfilePhase phase = profile.phase(i);
    ASSERT_GT(phase.duration, 0);
    ASSERT_LE(std::abs(phase.jerk), bounds.jerk * (1 + 1e-12));
    ASSERT_EQ(phase.start, time);
    ASSERT_NEAR(phase.state.q, state.q, slack.q);
    ASSERT_NEAR(phase.state.qd, state.qd, slack.qd);
    ASSERT_NEAR(phase.state.qdd, state.qdd, slack.qdd);
    state = phase.state;
    if (time >= from) expect_inside(state);
    const double turn = -state.qdd / phase.jerk;
    if (turn > 0 && turn < phase.duration && time + turn >= from) {
      expect_inside(advanced(state, phase.jerk, turn));
    }
    state = advanced(state, phase.jerk, phase.duration);
    time += phase.duration;
  }
  expect_inside(state);
  ASSERT_EQ(profile.duration(), time);
  ASSERT_NEAR(state.q, problem.target.q, slack.q);
  ASSERT_NEAR(state.qd, problem.target.qd, slack.qd);
  ASSERT_NEAR(state.qdd, problem.target.qdd, slack.qdd);
  const AxisState end = profile.at(profile.duration());
  ASSERT_EQ(end.q, problem.target.q);
  ASSERT_EQ(end.qd, problem.target.qd);
  ASSERT_EQ(end.qdd, problem.target.qdd);
}

inline std::ostream& operator<<(std::ostream& out, const JointProblem& p) {
  const auto old = out.precision(17);
  out << "from " << p.start.q << ' ' << p.start.qd << ' ' << p.start.qdd << " to " << p.target.q
      << ' ' << p.target.qd << ' ' << p.target.qdd << ", v " << p.bounds.velocity_lower << ".."
      << p.bounds.velocity_upper << ", a " << p.bounds.acceleration_lower << ".."
      << p.bounds.acceleration_upper << ", j " << p.bounds.jerk;
  out.precision(old);
  return out;
}

}  // namespace sinew::motion::test
