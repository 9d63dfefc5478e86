#include "sinew/planning/timing/trajectory.h"

#include <gtest/gtest.h>

#include "sinew/planning/timing/path_timing_test_paths.h"

namespace sinew::planning {
namespace {

using test::for_random_cases;
using test::Random;

TEST(Trajectory, derivatives_are_those_of_the_joints_with_respect_to_time) {
  PathTiming timing;
  TimeLaw law(timing.phases_max());
  for_random_cases(200, [&](Random& random) {
    const auto test = test_paths::random_case(random);
    ASSERT_FALSE(timing.prepare(test.path, test.limits).has_value());
    ASSERT_FALSE(timing.plan({}, 1, law).has_value());
    const Trajectory trajectory(test.path, law);
    const double step = 1e-5 * trajectory.duration();
    const double t = trajectory.duration() * random.uniform(0.05, 0.95);
    JointMotion below, at, above;
    trajectory.sample(t - step, below);
    trajectory.sample(t, at);
    trajectory.sample(t + step, above);
    for (std::size_t j = 0; j < test.limits.size(); ++j) {
      const auto& limit = test.limits[j];
      const double slack = 1e-6 + step * limit.jerk;
      EXPECT_NEAR((above.q[j] - below.q[j]) / (2 * step), at.qd[j], slack * step + 1e-8);
      EXPECT_NEAR((above.qd[j] - below.qd[j]) / (2 * step), at.qdd[j], slack);
    }
  });
}

TEST(Trajectory, tells_the_move_and_how_far_it_is) {
  auto test = test_paths::straight({1}, {{1, 1, 1}}, 2);
  test.path.sections[0].move = 3;
  test.path.sections.push_back({0.5, 3, 1, 1, 1});
  test.path.sections.push_back({1.0, 4, 1, 1, 1});
  const auto before = Trajectory::progress_at(test.path, 0.25);
  EXPECT_EQ(before.move, 3U);
  EXPECT_DOUBLE_EQ(before.move_share, 0.25);
  EXPECT_DOUBLE_EQ(before.path_share, 0.125);
  EXPECT_DOUBLE_EQ(Trajectory::progress_at(test.path, 0.75).move_share, 0.75);
  EXPECT_EQ(Trajectory::progress_at(test.path, 1.0).move, 4U);
  EXPECT_DOUBLE_EQ(Trajectory::progress_at(test.path, 1.5).move_share, 0.5);
  EXPECT_DOUBLE_EQ(Trajectory::progress_at(test.path, 9).path_share, 1);
}

}  // namespace
}  // namespace sinew::planning
