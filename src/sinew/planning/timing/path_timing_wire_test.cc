#include <gtest/gtest.h>

#include <cmath>

#include "sinew/core/error_code.h"
#include "sinew/planning/motion_planner.h"
#include "sinew/planning/timing/path_check.h"
#include "sinew/planning/timing/path_follower.h"
#include "sinew/planning/timing/path_timing_test_paths.h"
#include "support/robots.h"

/// Joints that share a wire: the sum of their speeds is limited as well.
namespace sinew::planning {
namespace {

using test::for_random_cases;
using test::Random;

double largest_sum(const PlannedPath& path, const TimeLaw& law) {
  const Trajectory trajectory(path, law);
  JointMotion at;
  double largest = 0;
  for (int k = 0; k <= 2000; ++k) {
    trajectory.sample(law.duration() * k / 2000, at);
    double sum = 0;
    for (const double qd : at.qd) sum += std::abs(qd);
    largest = std::max(largest, sum);
  }
  return largest;
}

TEST(SharedWire, random_laws_ask_no_more_than_it_carries_and_say_that_it_limits) {
  PathTiming timing;
  TimeLaw law(timing.phases_max());
  int limited = 0;
  double used = 0;
  for_random_cases(150, [&](Random& random) {
    const auto test = test_paths::random_case(random);
    const LawUse use = random.chance(0.7) ? LawUse::kQuickest : LawUse::kChangeable;
    ASSERT_FALSE(timing.prepare(test.path, test.limits, 1, use).has_value());
    ASSERT_FALSE(timing.plan({}, 1, law).has_value());
    const double alone = law.duration();
    const double needed = largest_sum(test.path, law);
    const double shared = needed * test_paths::ten_to(random, -1.5, 0.3);
    ASSERT_FALSE(timing.prepare(test.path, test.limits, 1, use, shared).has_value());
    ASSERT_FALSE(timing.plan({}, 1, law).has_value());
    const PathLoad load = check(test.path, law, test.limits, 1, 20, shared);
    ASSERT_LE(load.worst(), 1 + 1e-9);
    if (shared > 0.5 * needed) return;
    EXPECT_GT(law.duration(), alone);
    if (timing.limit_times().largest() != PathLimit{LimitKind::kWire, -1}) return;
    ++limited;
    used = std::max(used, load.shared);
  });
  EXPECT_GT(limited, 40);
  EXPECT_GT(used, 0.98);
}

TEST(SharedWire, feeds_and_pauses_keep_it_too) {
  PathFollower follower;
  int changes = 0, waited = 0, steps = 0;
  for_random_cases(60, [&](Random& random) {
    const auto test = test_paths::random_case(random);
    const double shared = test_paths::ten_to(random, -1, 0) * test.limits[0].velocity;
    ASSERT_FALSE(follower.start(test.path, test.limits, 1, shared).has_value());
    const double dt = follower.time_left() / 300;
    for (int i = 0; i < 100000 && !follower.finished(); ++i) {
      ++steps;
      double sum = 0;
      for (const double qd : follower.step(dt).qd) sum += std::abs(qd);
      ASSERT_LE(sum, shared * (1 + 1e-9));
      // A change that waits brakes, and is carried out from rest at the latest.
      const bool rests = follower.state().v == 0 && follower.state().a == 0;
      ASSERT_FALSE(follower.waits() && rests) << i;
      if (follower.waits()) ++waited;
      if (i % 40 == 13 || i % 40 == 35) {
        ++changes;
        if (i % 40 == 35) {
          follower.resume();
        } else {
          ASSERT_FALSE(follower.set_feed(random.uniform(0.2, 2)).has_value());
        }
      }
      if (i % 40 == 33) {
        follower.pause();
      }
    }
    ASSERT_TRUE(follower.finished());
  });
  EXPECT_GT(changes, 500);
  EXPECT_LT(waited, steps / 100);
}

TEST(SharedWire, what_is_no_number_above_zero_is_refused) {
  PathTiming timing;
  const auto line = test_paths::straight({1, -1}, {{1, 2, 20}, {1, 3, 20}}, 1);
  for (const double shared : {0.0, -1.0, std::nan("")}) {
    const auto error = timing.prepare(line.path, line.limits, 1, LawUse::kQuickest, shared);
    ASSERT_TRUE(error);
    EXPECT_EQ(error->code, ErrorCode::kMotionInput);
  }
}

TEST(SharedWire, one_leg_of_the_hexapod_is_six_times_as_quick_as_six) {
  const RobotModel& model = test::robot("hexapod");
  MotionPlanner planner(model);
  PlannedMotion motion = planner.make_motion();
  const PoseBT X_home = planner.space().home();
  const auto q = planner.space().inverse_near(planner.space().point(X_home), {});
  const RobotPlace home{*q, X_home};
  const auto time_of = [&](std::size_t legs) {
    MoveJ to{home.q};
    for (std::size_t j = 0; j < legs; ++j) to.q[j] += 2e-3;
    const Move move{.way = to};
    EXPECT_TRUE(planner.plan(home, {&move, 1}, 0, motion));
    EXPECT_EQ(motion.limits.largest(), (PathLimit{LimitKind::kWire, -1}));
    EXPECT_NEAR(largest_sum(motion.path, motion.law), shared_velocity(model), 1e-12);
    // What a straight move is given by itself is the same.
    const auto limits = straight_limits(model, {home.q.data(), kLegs}, {to.q.data(), kLegs});
    const motion::RestToRest rest({home.q.data(), kLegs}, {to.q.data(), kLegs}, limits);
    EXPECT_NEAR(rest.duration(), motion.law.duration(), 1e-6 * rest.duration());
    return motion.law.duration();
  };
  EXPECT_NEAR(time_of(6) / time_of(1), 6, 0.1);
  EXPECT_NEAR(time_of(6) / time_of(2), 3, 0.05);
}

}  // namespace
}  // namespace sinew::planning
