#include "sinew/motion/velocity_change.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "sinew/motion/joint_test_problem.h"

namespace sinew::motion::test {
namespace {

double random_velocity(Random& random, const ProfileBounds& bounds) {
  if (random.chance(0.3)) return 0;
  if (random.chance(0.1)) return bounds.velocity_upper;
  return random.uniform(bounds.velocity_lower, bounds.velocity_upper);
}

TEST(VelocityChange, arrives_exactly_and_stays_inside_its_limits) {
  sinew::test::for_random_cases(cases_wanted(200'000), [](Random& random) {
    const ProfileBounds bounds = random_bounds(random, 1);
    const AxisState start = random_state(random, bounds);
    const double velocity = random_velocity(random, bounds);
    const JointProfile profile = VelocityChange(start, velocity, bounds).profile();
    const AxisState end = profile.at(profile.duration());
    ASSERT_EQ(end.qd, velocity);
    ASSERT_EQ(end.qdd, 0);
    expect_sound({start, end, bounds}, profile);
  });
}

// The farthest motions exist from the shortest duration on in which the velocity can be had: a
// second derivation of the same time.
TEST(VelocityChange, takes_the_shortest_time_there_is) {
  sinew::test::for_random_cases(100'000, [](Random& random) {
    const ProfileBounds bounds = random_bounds(random, 1);
    const AxisState start = random_state(random, bounds);
    const double velocity = random_velocity(random, bounds);
    const double j = bounds.jerk;
    const Farthest farthest(
        {start.qd / j, start.qdd / j}, {velocity / j, 0},
        {bounds.acceleration_upper / j, -bounds.acceleration_lower / j, bounds.velocity_upper / j});
    const double shortest = farthest.spans(0)[1].first;
    const double duration = VelocityChange(start, velocity, bounds).profile().duration();
    ASSERT_NEAR(duration, shortest, 1e-9 * shortest + 1e-7) << start.qd << ' ' << start.qdd;
  });
}

TEST(VelocityChange, no_random_jerk_is_quicker) {
  sinew::test::for_random_cases(50'000, [](Random& random) {
    const ProfileBounds bounds = random_bounds(random, 0.5);
    const AxisState start = random_state(random, bounds);
    // Any motion inside the limits that ends without acceleration.
    AxisState state = start;
    double time = 0;
    for (int i = 0; i < 3; ++i) {
      const double jerk = random.uniform(-1, 1) * bounds.jerk;
      const double target =
          i == 2 ? 0 : random.uniform(bounds.acceleration_lower, bounds.acceleration_upper);
      const double full = i == 2 ? std::copysign(bounds.jerk, -state.qdd) : jerk;
      const double duration = (target - state.qdd) / full;
      if (!(duration > 0)) continue;
      state = advanced(state, full, duration);
      time += duration;
    }
    if (state.qd < bounds.velocity_lower || state.qd > bounds.velocity_upper)
      return random.discard();
    if (std::abs(state.qdd) > 1e-12) return random.discard();
    const JointProfile profile = VelocityChange(start, state.qd, bounds).profile();
    ASSERT_LE(profile.duration(), time * (1 + 1e-9) + 1e-7);
  });
}

TEST(VelocityChange, from_outside_its_limits_nothing_grows) {
  sinew::test::for_random_cases(100'000, [](Random& random) {
    const ProfileBounds bounds = random_bounds(random, 1);
    const AxisState start{0, random.uniform(3, -3) * bounds.velocity_upper,
                          random.uniform(3, -3) * bounds.acceleration_upper};
    const JointProfile profile = VelocityChange(start, 0, bounds).profile();
    // What is too much at the start, or is forced by full jerk from there.
    const double forced = start.qd + start.qdd * std::abs(start.qdd) / (2 * bounds.jerk);
    const VelocityRange range = profile.velocity_range();
    const double slack = 1e-9 * (1 + bounds.velocity_upper);
    ASSERT_LE(range.upper, std::max({0.0, start.qd, forced}) + slack);
    ASSERT_GE(range.lower, std::min({0.0, start.qd, forced}) - slack);
    for (std::size_t i = 0; i < profile.size(); ++i) {
      const double a = profile.phase(i).state.qdd;
      ASSERT_LE(a, std::max(start.qdd, bounds.acceleration_upper) * (1 + 1e-12));
      ASSERT_GE(a, std::min(start.qdd, bounds.acceleration_lower) * (1 + 1e-12));
    }
    ASSERT_EQ(profile.at(profile.duration()).qd, 0);
  });
}

TEST(VelocityChange, at_its_velocity_already_it_takes_no_time) {
  const ProfileBounds bounds(AxisLimits{1, 2, 8});
  EXPECT_EQ(VelocityChange({3, 0.5, 0}, 0.5, bounds).profile().duration(), 0);
  EXPECT_EQ(VelocityChange({3, 0, 0}, 0, bounds).profile().at(7).q, 3);
}

TEST(VelocityChange, says_what_binds) {
  const ProfileBounds bounds(AxisLimits{1, 2, 8});
  EXPECT_EQ(VelocityChange({0, 0, 0}, 0.4, bounds).binding(), Binding::kJerk);
  EXPECT_EQ(VelocityChange({0, 0, 0}, 1, bounds).binding(), Binding::kAcceleration);
}

}  // namespace
}  // namespace sinew::motion::test
