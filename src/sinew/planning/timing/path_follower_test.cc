#include "sinew/planning/timing/path_follower.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "sinew/core/error_code.h"
#include "sinew/planning/timing/path_timing_test_paths.h"
#include "support/allocation_guard.h"

namespace sinew::planning {
namespace {

using test::for_random_cases;
using test::Random;
using test_paths::Case;

double worst_share(const Case& test, const JointMotion& motion) {
  double worst = 0;
  for (std::size_t j = 0; j < test.limits.size(); ++j) {
    worst = std::max({worst, std::abs(motion.qd[j]) / test.limits[j].velocity,
                      std::abs(motion.qdd[j]) / test.limits[j].acceleration,
                      std::abs(motion.qddd[j]) / test.limits[j].jerk});
  }
  return worst;
}

TEST(PathFollower, random_feeds_and_pauses_keep_all_limits_the_path_and_the_target) {
  PathFollower follower;
  std::uint64_t changes = 0;
  for_random_cases(150, [&](Random& random) {
    const Case test = test_paths::random_case(random);
    const double length = test.path.joints.length();
    ASSERT_FALSE(follower.start(test.path, test.limits, random.uniform(0.1, 2)).has_value());
    const double dt = test_paths::ten_to(random, -3, -2);
    PathState last;
    for (int i = 0; i < 100000 && !follower.finished(); ++i) {
      const JointMotion now = follower.step(dt);
      ASSERT_LE(worst_share(test, now), 1 + 1e-9);
      const PathState state = follower.state();
      ASSERT_GE(state.s, last.s - 1e-12);
      PathPoint at;
      test.path.joints.sample(state.s, at);
      ASSERT_EQ(at.q, now.q);
      last = state;
      const bool waits = follower.paused() || follower.feed() == 0;
      if (!random.chance(waits ? 0.05 : 0.02)) continue;
      ++changes;
      if (follower.paused()) {
        follower.resume();
      } else if (random.chance(0.3)) {
        follower.pause();
      } else {
        const double feed = random.chance(0.1) ? 0 : random.uniform(0.05, 2);
        ASSERT_FALSE(follower.set_feed(feed).has_value());
      }
      follower.step(0);
      ASSERT_NEAR(follower.state().s, state.s, 1e-12);
      ASSERT_NEAR(follower.state().v, state.v, 1e-9);
      ASSERT_NEAR(follower.state().a, state.a, 1e-6);
    }
    ASSERT_TRUE(follower.finished());
    EXPECT_EQ(follower.state().s, length);
    PathPoint end;
    test.path.joints.sample(length, end);
    EXPECT_EQ(follower.now().q, end.q);
  });
  EXPECT_GT(changes, 2000U);
}

TEST(PathFollower, stops_on_the_path_for_good_without_the_heap) {
  PathFollower follower;
  const Case line = test_paths::straight({1, -1}, {{1, 2, 20}, {1, 3, 20}}, 1);
  const test::AllocationCounter counter;
  ASSERT_FALSE(follower.start(line.path, line.limits).has_value());
  EXPECT_TRUE(!follower.finished() && follower.progress().path_share == 0);
  follower.step(0.7);
  EXPECT_FALSE(follower.at_rest());
  follower.stop();
  const double left = follower.time_left();
  EXPECT_LT(left, 1);
  follower.step(left);
  EXPECT_TRUE(follower.at_rest() && follower.stopped() && !follower.finished());
  const double s = follower.state().s;
  follower.resume();
  ASSERT_FALSE(follower.set_feed(2).has_value());
  follower.step(5);
  EXPECT_EQ(follower.state().s, s);
  EXPECT_EQ(counter.count(), 0U);
}

/// By bisection: a pause that ends before the path's end, or at it.
void pause_next_to_the_end(PathFollower& follower, const Case& test, double time_max) {
  double before = 0, behind = time_max;  // s
  for (int k = 0; k < 60; ++k) {
    const double middle = (before + behind) / 2;
    ASSERT_FALSE(follower.start(test.path, test.limits).has_value());
    follower.step(middle);
    follower.pause();
    follower.step(100);
    (follower.finished() ? behind : before) = middle;
    follower.resume();
    follower.step(100);
    ASSERT_TRUE(follower.finished()) << "paused at " << middle << " s";
    ASSERT_EQ(follower.state().s, test.path.joints.length());
  }
}

TEST(PathFollower, a_pause_that_ends_next_to_the_end_is_no_hang) {
  PathFollower follower;
  pause_next_to_the_end(follower, test_paths::straight({1, -1}, {{1, 2, 20}, {1, 3, 20}}, 1), 3);
  for_random_cases(40, [&](Random& random) {
    const Case test = test_paths::random_case(random);
    ASSERT_FALSE(follower.start(test.path, test.limits).has_value());
    pause_next_to_the_end(follower, test, follower.time_left());
  });
}

TEST(PathFollower, a_feed_of_zero_waits_and_a_feed_that_is_no_number_changes_nothing) {
  PathFollower follower;
  const Case line = test_paths::straight({1, -1}, {{1, 2, 20}, {1, 3, 20}}, 1);
  ASSERT_FALSE(follower.start(line.path, line.limits, 0).has_value());
  follower.step(1);
  EXPECT_TRUE(follower.at_rest() && follower.state().s == 0);
  EXPECT_TRUE(follower.set_feed(std::nan("")).has_value());
  ASSERT_FALSE(follower.set_feed(1).has_value());
  follower.step(follower.time_left());
  EXPECT_TRUE(follower.finished());
  EXPECT_EQ(follower.now().q[0], 1);
}

TEST(PathFollower, refuses_feeds_below_zero_above_two_and_no_numbers_and_goes_on_as_it_was) {
  PathFollower follower;
  PathFollower untouched;
  const Case line = test_paths::straight({1, -1}, {{1, 2, 20}, {1, 3, 20}}, 1);
  ASSERT_FALSE(untouched.start(line.path, line.limits).has_value());
  const double infinity = std::numeric_limits<double>::infinity();
  for (const double feed : {-1.0, -1e-12, 2 + 1e-9, 3.0, std::nan(""), infinity, -infinity}) {
    SCOPED_TRACE(feed);
    auto error = follower.start(line.path, line.limits, feed);
    ASSERT_TRUE(error.has_value());
    EXPECT_EQ(error->code, ErrorCode::kMoveInput);
    ASSERT_FALSE(follower.start(line.path, line.limits).has_value());
    follower.step(0.5);
    error = follower.set_feed(feed);
    ASSERT_TRUE(error.has_value());
    EXPECT_EQ(error->code, ErrorCode::kMoveInput);
    EXPECT_EQ(error->limit, feed < 0 ? 0 : PathFollower::kFeedMax);
    EXPECT_EQ(follower.feed(), 1);
    EXPECT_NEAR(follower.time_left() + 0.5, untouched.time_left(), 1e-12);
  }
}

}  // namespace
}  // namespace sinew::planning
