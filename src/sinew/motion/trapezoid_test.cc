#include "sinew/motion/trapezoid.h"

#include <gtest/gtest.h>

#include <cmath>

#include "support/property.h"

namespace sinew::motion {
namespace {

TEST(Trapezoid, long_way_takes_its_length_over_speed_and_one_ramp) {
  // The elbow of the BigRobotArm over 5000 steps at its boot multipliers.
  const Trapezoid profile(5000, 3200, 3200);
  EXPECT_DOUBLE_EQ(profile.duration(), 2.5625);
  EXPECT_DOUBLE_EQ(profile.at(0.5).position, 400);
  EXPECT_DOUBLE_EQ(profile.at(0.5).velocity, 1600);
  EXPECT_DOUBLE_EQ(profile.at(1.28125).position, 2500);
  EXPECT_DOUBLE_EQ(profile.at(1.28125).velocity, 3200);
}

TEST(Trapezoid, short_way_never_reaches_the_speed) {
  const Trapezoid profile(-4, 1000, 1);
  EXPECT_DOUBLE_EQ(profile.duration(), 4);
  EXPECT_DOUBLE_EQ(profile.at(2).velocity, -2);
  EXPECT_DOUBLE_EQ(profile.at(2).position, -2);
}

TEST(Trapezoid, no_way_takes_no_time) {
  const Trapezoid profile(0, 10, 10);
  EXPECT_EQ(profile.duration(), 0);
  EXPECT_EQ(profile.at(1).position, 0);
  EXPECT_EQ(profile.stretched(3).at(1).velocity, 0);
}

TEST(Trapezoid, any_profile_keeps_its_limits_and_joins_without_a_jump) {
  test::for_random_cases(100'000, [](test::Random& random) {
    const double distance = random.uniform(-20'000, 20'000);
    const double velocity = random.uniform(1, 10'000);
    const double acceleration = random.uniform(1, 10'000);
    Trapezoid profile(distance, velocity, acceleration);
    if (random.chance(0.3)) {
      const double longer = profile.duration() * random.uniform(1, 5);
      profile = profile.stretched(longer);
      EXPECT_NEAR(profile.duration(), longer, 1e-9 * longer);
    }
    const double h = profile.duration() * 1e-6;
    const double t = random.uniform(0, profile.duration());
    const auto before = profile.at(t);
    const auto after = profile.at(t + h);
    EXPECT_LE(std::abs(before.velocity), velocity * (1 + 1e-12));
    EXPECT_LE(std::abs(after.velocity - before.velocity), acceleration * h * (1 + 1e-6) + 1e-9);
    // Between two instants the way is the mean speed's, up to the ramp's curvature.
    EXPECT_NEAR(after.position - before.position, 0.5 * (before.velocity + after.velocity) * h,
                acceleration * h * h + 1e-9);
    EXPECT_EQ(profile.at(profile.duration()).position, distance);
  });
}

}  // namespace
}  // namespace sinew::motion
