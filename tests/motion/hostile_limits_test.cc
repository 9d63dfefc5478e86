#include <gtest/gtest.h>

#include <limits>

#include "sinew/core/error_code.h"
#include "sinew/core/units.h"
#include "sinew/motion/state_to_state.h"
#include "sinew/motion/synchronised.h"
#include "sinew/planning/timing/path_timing.h"
#include "sinew/planning/timing/path_timing_test_paths.h"
#include "support/property.h"

namespace sinew::planning {
namespace {

using motion::AxisState;
using motion::ProfileBounds;
using test::for_random_cases;
using test::Random;

/// What no limit can be.
double no_limit(Random& random) {
  constexpr std::array kNumbers{std::numeric_limits<double>::quiet_NaN(),
                                kInfinity,
                                -kInfinity,
                                0.0,
                                -0.0,
                                -1e-300,
                                -1.0,
                                -1e300};
  return kNumbers[static_cast<std::size_t>(random.integer(0, std::ssize(kNumbers) - 1))];
}

TEST(HostileLimits, of_a_path_s_joints_are_refused_by_name_and_the_next_good_plan_is_as_before) {
  PathTiming timing;
  TimeLaw law(timing.phases_max());
  for_random_cases(300, [&](Random& random) {
    const auto good = test_paths::random_case(random, 5);
    const LawUse use = random.chance(0.5) ? LawUse::kQuickest : LawUse::kChangeable;
    ASSERT_FALSE(timing.prepare(good.path, good.limits, 1, use));
    ASSERT_FALSE(timing.plan({}, 1, law));
    const double duration = law.duration();
    auto limits = good.limits;
    const auto j = static_cast<std::size_t>(random.integer(0, std::ssize(limits) - 1));
    const auto which = random.integer(0, 2);
    double& number = which == 0   ? limits[j].velocity
                     : which == 1 ? limits[j].acceleration
                                  : limits[j].jerk;
    number = no_limit(random);
    const auto refused = timing.prepare(good.path, limits, 1, use);
    ASSERT_TRUE(refused);
    EXPECT_EQ(refused->code, ErrorCode::kMotionInput);
    EXPECT_EQ(refused->index, static_cast<int>(j));
    const auto no_feed = timing.prepare(good.path, good.limits, no_limit(random), use);
    ASSERT_TRUE(no_feed);
    EXPECT_EQ(no_feed->code, ErrorCode::kMotionInput);
    limits.pop_back();
    ASSERT_TRUE(timing.prepare(good.path, limits, 1, use));
    ASSERT_FALSE(timing.prepare(good.path, good.limits, 1, use));
    ASSERT_FALSE(timing.plan({}, 1, law));
    EXPECT_EQ(law.duration(), duration);
  });
}

TEST(HostileLimits, of_what_a_path_s_sections_ask_for_are_refused) {
  PathTiming timing;
  for_random_cases(300, [&](Random& random) {
    auto spoilt = test_paths::random_case(random, 5);
    auto& sections = spoilt.path.sections;
    PathSection& section =
        sections[static_cast<std::size_t>(random.integer(0, std::ssize(sections) - 1))];
    double number = no_limit(random);
    const auto which = random.integer(0, 2);
    // An infinite speed is one that nobody asked for.
    if (which < 2 && number > 0) number = std::numeric_limits<double>::quiet_NaN();
    (which == 0   ? section.tool_speed
     : which == 1 ? section.tool_acceleration
                  : section.joint_share) = number;
    const auto refused = timing.prepare(spoilt.path, spoilt.limits);
    ASSERT_TRUE(refused);
    EXPECT_EQ(refused->code, ErrorCode::kMotionInput);
  });
}

ProfileBounds random_bounds(Random& random) {
  ProfileBounds bounds;
  const auto some = [&] { return test_paths::ten_to(random, -1.5, 1.5); };
  bounds.velocity_lower = -some();
  bounds.velocity_upper = some();
  bounds.acceleration_lower = -some();
  bounds.acceleration_upper = some();
  bounds.jerk = some();
  return bounds;
}

void spoil(Random& random, ProfileBounds& bounds) {
  const double number = no_limit(random);
  switch (random.integer(0, 4)) {
    case 0:
      bounds.velocity_upper = number;
      break;
    case 1:
      bounds.acceleration_upper = number;
      break;
    case 2:
      bounds.jerk = number;
      break;
    case 3:
      bounds.velocity_lower = -number;
      break;
    default:
      bounds.acceleration_lower = -number;
      break;
  }
}

void expect_inside(const motion::MotionProfile& profile, std::span<const ProfileBounds> bounds) {
  motion::AxisStates at{};
  motion::AxisStates last{};
  profile.sample(0, last);
  constexpr int kLooks = 60;
  const double dt = profile.duration() / kLooks;
  for (int k = 1; k <= kLooks; ++k) {
    profile.sample(dt * k, at);
    for (std::size_t j = 0; j < bounds.size(); ++j) {
      constexpr double kRounding = 1 + 1e-9;
      const ProfileBounds& b = bounds[j];
      EXPECT_TRUE(std::isfinite(at.q[j]));
      EXPECT_LE(at.qd[j], b.velocity_upper * kRounding);
      EXPECT_GE(at.qd[j], b.velocity_lower * kRounding);
      EXPECT_LE(at.qdd[j], b.acceleration_upper * kRounding);
      EXPECT_GE(at.qdd[j], b.acceleration_lower * kRounding);
      EXPECT_LE(std::abs(at.qdd[j] - last.qdd[j]),
                b.jerk * dt * kRounding + 1e-9 * (b.acceleration_upper - b.acceleration_lower));
    }
    last = at;
  }
}

TEST(HostileLimits, of_profiles_are_refused_by_name_and_lopsided_ones_are_kept) {
  for_random_cases(3000, [&](Random& random) {
    const auto joints = static_cast<std::size_t>(random.integer(1, 6));
    std::vector<AxisState> from, to;
    std::vector<ProfileBounds> bounds;
    std::vector<double> velocities;
    for (std::size_t j = 0; j < joints; ++j) {
      bounds.push_back(random_bounds(random));
      from.push_back({random.uniform(-3, 3), 0, 0});
      to.push_back({random.uniform(-3, 3), 0, 0});
      velocities.push_back(random.uniform(bounds[j].velocity_lower, bounds[j].velocity_upper));
    }
    const auto moved = motion::plan_motion(from, to, bounds);
    const auto jogged = motion::plan_velocity(from, velocities, bounds);
    ASSERT_TRUE(moved && jogged && motion::plan_stop(from, bounds));
    expect_inside(*moved, bounds);
    expect_inside(*jogged, bounds);

    const auto j = static_cast<std::size_t>(random.integer(0, std::ssize(bounds) - 1));
    const auto refused = [&](const auto& profile) {
      ASSERT_FALSE(profile);
      EXPECT_EQ(profile.error().code, ErrorCode::kMotionInput);
      EXPECT_EQ(profile.error().index, static_cast<int>(j));
    };
    const ProfileBounds good = bounds[j];
    spoil(random, bounds[j]);
    refused(motion::plan_motion(from, to, bounds));
    refused(motion::plan_velocity(from, velocities, bounds));
    refused(motion::plan_stop(from, bounds));
    EXPECT_TRUE(motion::refusal(from[j], bounds[j]));
    bounds[j] = good;
    const double nowhere =
        random.chance(0.5) ? std::nan("") : std::numeric_limits<double>::infinity();
    (random.chance(0.5) ? from[j].q : from[j].qdd) = random.chance(0.5) ? nowhere : -nowhere;
    refused(motion::plan_motion(from, to, bounds));
    refused(motion::plan_stop(from, bounds));
  });
}

}  // namespace
}  // namespace sinew::planning
