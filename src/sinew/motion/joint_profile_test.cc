#include "sinew/motion/joint_profile.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "support/property.h"

namespace sinew::motion {
namespace {

JointProfile random_profile(test::Random& random) {
  JointProfile profile({random.uniform(-1, 1), random.uniform(-1, 1), random.uniform(-1, 1)});
  const std::int64_t phases = random.integer(1, JointProfile::kPhasesMax);
  for (std::int64_t i = 0; i < phases; ++i) {
    const double jerk = random.chance(0.3) ? 0 : random.uniform(-3, 3);
    profile.append(jerk, random.uniform(0.01, 1));
  }
  return profile;
}

TEST(JointProfile, is_the_integral_of_its_jerk) {
  test::for_random_cases(20'000, [](test::Random& random) {
    const JointProfile profile = random_profile(random);
    const double t = random.uniform(0, 1) * profile.duration();
    const double h = 1e-4;
    const AxisState before = profile.at(std::max(0.0, t - h));
    const AxisState after = profile.at(std::min(profile.duration(), t + h));
    const double span = std::min(profile.duration(), t + h) - std::max(0.0, t - h);
    const AxisState middle =
        profile.at((std::max(0.0, t - h) + std::min(profile.duration(), t + h)) / 2);
    ASSERT_NEAR((after.q - before.q) / span, middle.qd, 1e-7);
    ASSERT_NEAR((after.qd - before.qd) / span, middle.qdd, 1e-3);
    ASSERT_LE(std::abs(after.qdd - before.qdd), 3.001 * span);
    ASSERT_LE(std::abs(profile.jerk_at(t)), 3);
  });
}

TEST(JointProfile, its_ranges_hold_every_instant_and_are_touched) {
  test::for_random_cases(20'000, [](test::Random& random) {
    const JointProfile profile = random_profile(random);
    const PositionRange q = profile.position_range();
    const VelocityRange qd = profile.velocity_range();
    AxisState low = profile.at(0);
    AxisState high = low;
    constexpr int kSamples = 500;
    for (int i = 0; i <= kSamples; ++i) {
      const AxisState now = profile.at(profile.duration() * i / kSamples);
      low.q = std::min(low.q, now.q);
      high.q = std::max(high.q, now.q);
      low.qd = std::min(low.qd, now.qd);
      high.qd = std::max(high.qd, now.qd);
    }
    ASSERT_GE(low.q, q.lower - 1e-9);
    ASSERT_LE(high.q, q.upper + 1e-9);
    ASSERT_GE(low.qd, qd.lower - 1e-9);
    ASSERT_LE(high.qd, qd.upper + 1e-9);
    ASSERT_NEAR(low.q, q.lower, 1e-2);
    ASSERT_NEAR(high.q, q.upper, 1e-2);
    ASSERT_NEAR(low.qd, qd.lower, 1e-2);
    ASSERT_NEAR(high.qd, qd.upper, 1e-2);
  });
}

TEST(JointProfile, is_held_at_both_ends) {
  JointProfile profile({1, 2, 0});
  profile.append(0, 2);
  profile.finish({5, 2, 0});
  EXPECT_EQ(profile.at(-1).q, 1);
  EXPECT_EQ(profile.at(1).q, 3);
  EXPECT_EQ(profile.at(2).q, 5);
  EXPECT_EQ(profile.at(9).q, 5);
  EXPECT_EQ(profile.jerk_at(9), 0);
  profile.finish({5, 2, 0}, AfterEnd::kContinue);
  EXPECT_EQ(profile.at(9).q, 19);
}

TEST(JointProfile, phases_of_no_duration_are_none) {
  JointProfile profile({1, 2, 3});
  profile.append(1, 0);
  profile.append(1, -1);
  EXPECT_EQ(profile.size(), 0U);
  EXPECT_EQ(profile.duration(), 0);
  EXPECT_EQ(profile.at(0).qdd, 3);
}

TEST(JointProfile, one_phase_too_many_is_a_bug) {
  JointProfile profile;
  for (std::size_t i = 0; i < JointProfile::kPhasesMax; ++i) profile.append(1, 0.1);
  EXPECT_DEATH(profile.append(1, 0.1), "kPhasesMax");
}

}  // namespace
}  // namespace sinew::motion
