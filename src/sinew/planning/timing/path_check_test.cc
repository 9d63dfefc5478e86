#include "sinew/planning/timing/path_check.h"

#include <gtest/gtest.h>

#include "sinew/planning/timing/path_timing_test_paths.h"

namespace sinew::planning {
namespace {

TEST(PathCheck, tells_the_share_of_each_limit_that_a_motion_takes) {
  // q = 2 s for 3 m; jerk 4 for 1 s, then none for 0.5 s: v 2, a 4 and v 4, a 4.
  auto test = test_paths::straight({6}, {{16, 10, 5}}, 3);
  test.path.sections[0].tool_speed = 5;
  test.path.sections[0].tool_acceleration = 2;
  test.path.sections[0].joint_share = 0.5;
  TimeLaw law(4);
  law.clear();
  law.append(4, 1);
  law.append(0, 0.5);
  const PathLoad load = check(test.path, law, test.limits, 0.5);
  EXPECT_NEAR(load.velocity[0], 2 * 4 / (16 * 0.25), 1e-12);
  EXPECT_NEAR(load.acceleration[0], 2 * 4 / 10.0, 1e-12);
  EXPECT_NEAR(load.jerk[0], 2 * 4 / 5.0, 1e-12);
  EXPECT_NEAR(load.tool_speed, 4 / 2.5, 1e-12);
  EXPECT_NEAR(load.tool_acceleration, 4 / 2.0, 1e-12);
  EXPECT_NEAR(load.worst(), 2, 1e-12);
}

TEST(PathCheck, counts_what_the_bends_of_a_path_cost) {
  // q = s + s^2/2 + s^3/6 at v = 1: qdd = q'' = 1 + s, qddd = q''' = 1.
  PlannedPath path(1, 1);
  PathPoint from;
  PathPoint to;
  from.dq[0] = from.ddq[0] = 1;
  to.q[0] = 1 + 0.5 + 1 / 6.0, to.dq[0] = 2.5, to.ddq[0] = 2;
  ASSERT_TRUE(path.joints.append_quintic(from, to, 1));
  path.tool.push_back({1, 3});
  path.sections.push_back({0, 0, 10, 6, 1});
  TimeLaw law(4);
  law.clear({0, 1, 0});
  law.append(0, 1);
  const motion::AxisLimits limits[] = {{10, 4, 2}};
  const PathLoad load = check(path, law, limits);
  EXPECT_NEAR(load.velocity[0], 0.25, 1e-9);
  EXPECT_NEAR(load.acceleration[0], 0.5, 1e-9);
  EXPECT_NEAR(load.jerk[0], 0.5, 1e-9);
  EXPECT_NEAR(load.tool_acceleration, 0.5, 1e-9);
}

}  // namespace
}  // namespace sinew::planning
