#include "sinew/motion/online_profile.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "sinew/core/units.h"
#include "support/allocation_guard.h"
#include "support/property.h"

namespace sinew::motion {
namespace {

using test::for_random_cases;
using test::Random;

const AxisLimits kArm{from_deg(100), from_deg(10), from_deg(10)};

AxisLimits random_limits(Random& random) {
  return {std::pow(10.0, random.uniform(-2, 1)), std::pow(10.0, random.uniform(-1, 2)),
          std::pow(10.0, random.uniform(-1, 3))};
}

void expect_inside(const AxisState& state, const AxisLimits& limits) {
  ASSERT_LE(std::abs(state.qd), limits.velocity * (1 + 1e-9));
  ASSERT_LE(std::abs(state.qdd), limits.acceleration * (1 + 1e-9));
}

TEST(OnlineProfile, from_rest_it_is_the_rest_to_rest_profile) {
  for (const double way : {1e-6, 0.01, 0.3, 1.0, 6.0, -0.2, -6.0}) {
    const auto profile = OnlineProfile::to({}, way, ProfileBounds(kArm));
    const auto reference = plan_axis(std::abs(way), kArm);
    EXPECT_NEAR(profile.duration(), reference.duration(), 1e-6 * reference.duration()) << way;
    const AxisState middle = profile.at(profile.duration() / 2);
    EXPECT_NEAR(middle.q, way / 2, 1e-9) << way;
    EXPECT_NEAR(std::abs(middle.qd), reference.velocity(), 1e-6) << way;
  }
}

TEST(OnlineProfile, ninety_degrees_take_the_documented_7_083_seconds) {
  // The first firmware's own figures for this move: 7.083 s, at most 25.4 deg/s.
  const auto profile = OnlineProfile::to({}, from_deg(90), ProfileBounds(kArm));
  EXPECT_NEAR(profile.duration(), 7.083, 5e-4);
  EXPECT_NEAR(to_deg(profile.at(profile.duration() / 2).qd), 25.4, 0.05);
}

TEST(OnlineProfile, ends_exactly_on_its_target) {
  const AxisState start{0.1, -0.05, 0.02};
  const auto profile = OnlineProfile::to(start, 1.0 / 3, ProfileBounds(kArm));
  const AxisState end = profile.at(profile.duration());
  EXPECT_EQ(end.q, 1.0 / 3);
  EXPECT_EQ(end.qd, 0);
  EXPECT_EQ(end.qdd, 0);
  const AxisState before = profile.at(profile.duration() - 1e-9);
  EXPECT_NEAR(before.q, 1.0 / 3, 1e-11);
  EXPECT_EQ(profile.at(0).q, start.q);
  EXPECT_EQ(profile.at(0).qd, start.qd);
}

TEST(OnlineProfile, target_at_the_place_where_it_stands_needs_no_time) {
  EXPECT_EQ(OnlineProfile::to({0.5, 0, 0}, 0.5, ProfileBounds(kArm)).duration(), 0);
}

TEST(OnlineProfile, stop_is_as_short_as_the_limits_allow) {
  // 3 deg/s with 10 deg/s^3 alone: two phases of sqrt(v / j), over v sqrt(v / j).
  const auto profile = OnlineProfile::stop({0, from_deg(3), 0}, ProfileBounds(kArm));
  EXPECT_NEAR(profile.duration(), 2 * std::sqrt(0.3), 1e-9);
  EXPECT_NEAR(to_deg(profile.target()), 3 * std::sqrt(0.3), 1e-9);
}

TEST(OnlineProfile, target_too_near_to_stop_for_is_passed_and_come_back_to) {
  const auto profile = OnlineProfile::to({0, from_deg(20), 0}, from_deg(1), ProfileBounds(kArm));
  EXPECT_EQ(profile.at(profile.duration()).q, from_deg(1));
  // It turns round without coming to rest in between, so it needs less room than a stop.
  const auto stop = OnlineProfile::stop({0, from_deg(20), 0}, ProfileBounds(kArm));
  EXPECT_LT(profile.range().upper, stop.target());
  EXPECT_GT(profile.range().upper, 0.95 * stop.target());
}

TEST(OnlineProfile, range_is_what_a_fine_look_at_it_finds) {
  for_random_cases(2'000, [](Random& random) {
    const AxisLimits limits = random_limits(random);
    const AxisState start{random.uniform(-3, 3), random.uniform(-1, 1) * limits.velocity / 2,
                          random.uniform(-1, 1) * limits.acceleration};
    const auto profile = OnlineProfile::to(start, random.uniform(-3, 3), ProfileBounds(limits));
    PositionRange seen{profile.target(), profile.target()};
    for (int i = 0; i <= 2000; ++i) {
      const double q = profile.at(profile.duration() * i / 2000).q;
      seen = {std::min(seen.lower, q), std::max(seen.upper, q)};
    }
    // Between two looks it strays from both by no more than v dt.
    const double slack =
        std::max(limits.velocity, std::abs(start.qd) * 2) * profile.duration() / 2e3;
    ASSERT_LE(profile.range().lower, seen.lower + 1e-9);
    ASSERT_GE(profile.range().upper, seen.upper - 1e-9);
    ASSERT_GE(profile.range().lower, seen.lower - slack);
    ASSERT_LE(profile.range().upper, seen.upper + slack);
  });
}

/// One random case is a chain of retargets and stops at random instants of what went before.
TEST(OnlineProfile, retargets_at_any_instant_keep_every_limit_and_arrive) {
  for_random_cases(5'000, [](Random& random) {
    const AxisLimits limits = random_limits(random);
    const ProfileBounds bounds(limits);
    const double lower = random.uniform(-3, 0), upper = lower + random.uniform(0.01, 6);
    AxisState state{random.uniform(lower, upper), 0, 0};
    for (int round = 0; round < 20; ++round) {
      // Three in ten on an end itself.
      const double beyond = 0.2 * (upper - lower);
      const double target =
          std::clamp(random.uniform(lower - beyond, upper + beyond), lower, upper);
      const auto profile = random.chance(0.2) ? OnlineProfile::stop(state, bounds)
                                              : OnlineProfile::to(state, target, bounds);
      const double until = profile.duration() * random.uniform(0, 1.1);
      const double dt = profile.duration() / 61;
      AxisState last = profile.at(0);
      ASSERT_NEAR(last.q, state.q, 1e-12);
      ASSERT_NEAR(last.qd, state.qd, 1e-12);
      for (int i = 1; i * dt < until; ++i) {
        const AxisState now = profile.at(i * dt);
        expect_inside(now, limits);
        ASSERT_GE(now.q, lower - 1e-9);
        ASSERT_LE(now.q, upper + 1e-9);
        // Jerk, and that the three belong together.
        ASSERT_LE(std::abs(now.qdd - last.qdd), limits.jerk * dt * (1 + 1e-6) + 1e-9);
        ASSERT_LE(std::abs(now.q - last.q - dt * (now.qd + last.qd) / 2),
                  limits.jerk * dt * dt * dt + 1e-9);
        last = now;
        if (::testing::Test::HasFailure()) return;
      }
      ASSERT_GE(profile.range().lower, lower - 1e-9);
      ASSERT_LE(profile.range().upper, upper + 1e-9);
      ASSERT_NEAR(profile.at(profile.duration() * (1 - 1e-12)).q, profile.target(), 1e-8);
      state = profile.at(until);
    }
  });
}

TEST(OnlineProfile, sides_of_their_own_are_kept) {
  for_random_cases(20'000, [](Random& random) {
    ProfileBounds bounds;
    bounds.velocity_lower = -random.uniform(0.1, 2);
    bounds.velocity_upper = random.uniform(0.1, 2);
    bounds.acceleration_lower = -random.uniform(0.1, 20);
    bounds.acceleration_upper = random.uniform(0.1, 20);
    bounds.jerk = random.uniform(1, 100);
    const double target = random.uniform(-2, 2);
    const auto profile = OnlineProfile::to({random.uniform(-2, 2), 0, 0}, target, bounds);
    for (int i = 0; i <= 100; ++i) {
      const AxisState state = profile.at(profile.duration() * i / 100);
      ASSERT_LE(state.qd, bounds.velocity_upper + 1e-9);
      ASSERT_GE(state.qd, bounds.velocity_lower - 1e-9);
      ASSERT_LE(state.qdd, bounds.acceleration_upper + 1e-9);
      ASSERT_GE(state.qdd, bounds.acceleration_lower - 1e-9);
    }
    ASSERT_EQ(profile.at(profile.duration()).q, target);
  });
}

TEST(OnlineProfile, start_outside_the_limits_comes_back_to_rest) {
  for_random_cases(20'000, [](Random& random) {
    const AxisLimits limits = random_limits(random);
    const AxisState start{0, random.uniform(-3, 3) * limits.velocity,
                          random.uniform(-3, 3) * limits.acceleration};
    const double target = random.uniform(-3, 3);
    const auto profile = OnlineProfile::to(start, target, ProfileBounds(limits));
    ASSERT_TRUE(std::isfinite(profile.duration()));
    const double scale = 1 + std::abs(profile.range().upper) + std::abs(profile.range().lower);
    ASSERT_NEAR(profile.at(profile.duration() * (1 - 1e-12)).q, target, 1e-8 * scale);
  });
}

TEST(OnlineProfile, planning_and_looking_allocates_nothing) {
  const test::AllocationCounter counter;
  const auto profile = OnlineProfile::to({0, 0.1, -0.05}, 2, ProfileBounds(kArm));
  const double q = profile.at(1).q + profile.range().upper;
  EXPECT_EQ(counter.count(), 0U);
  EXPECT_GT(q, 0);
}

}  // namespace
}  // namespace sinew::motion
