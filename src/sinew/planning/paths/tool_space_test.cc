#include "sinew/planning/paths/tool_space.h"

#include <gtest/gtest.h>

#include <cmath>

#include "sinew/core/error_code.h"
#include "sinew/planning/paths/move_path_test_robot.h"
#include "support/allocation_guard.h"

namespace sinew::planning {
namespace {

using test::for_random_cases;
using test::Random;

class ToolSpaceOf : public testing::TestWithParam<const char*> {};
INSTANTIATE_TEST_SUITE_P(Robots, ToolSpaceOf, testing::ValuesIn(kPathRobots), path_robot_name);

TEST(ToolSpace, knows_what_each_robot_s_tool_can_be_asked_for) {
  const auto task = [](const char* id) { return PathRobot(id).space.task(); };
  EXPECT_EQ(task("robot-arm-2"), TaskSpace::kPose);
  EXPECT_EQ(task("puma560"), TaskSpace::kPose);
  EXPECT_EQ(task("hexapod"), TaskSpace::kPose);
  EXPECT_EQ(task("learm"), TaskSpace::kPitchRoll);
  EXPECT_EQ(task("bigrobotarm"), TaskSpace::kApproach);
  EXPECT_EQ(task("maxarm"), TaskSpace::kPoint);
}

TEST_P(ToolSpaceOf, inverse_gives_the_joints_back_that_made_the_point) {
  PathRobot robot(GetParam());
  for_random_cases(1000, [&](Random& random) {
    const RobotPlace place = robot.random_place(random);
    const TaskPoint point = robot.space.point(place.X_BT);
    JointArray near = place.q;
    for (std::size_t j = 0; j < robot.space.size(); ++j) near[j] += random.uniform(-1e-3, 1e-3);
    const auto q = robot.space.inverse_near(point, near);
    ASSERT_TRUE(q) << describe(q.error());
    // Near a singularity other joints are nearer: then they hold the tool there too.
    const auto X_BT = robot.space.forward(robot.joints(*q), place.X_BT);
    ASSERT_TRUE(X_BT);
    const ToolOffset off = robot.space.offset(*X_BT, point);
    EXPECT_LE(off.distance, 2e-9);
    EXPECT_LE(off.angle, 2e-9);
    const auto exact = robot.space.inverse_near(point, place.q);
    ASSERT_TRUE(exact);
    for (std::size_t j = 0; j < robot.space.size(); ++j) {
      EXPECT_NEAR((*exact)[j], place.q[j], 1e-6);
    }
  });
}

TEST_P(ToolSpaceOf, inverse_goes_on_beyond_a_limit_instead_of_turning_over) {
  PathRobot robot(GetParam());
  if (robot.space.serial() == nullptr) return;
  for_random_cases(300, [&](Random& random) {
    JointArray q = robot.random_place(random).q;
    const auto j = static_cast<std::size_t>(random.integer(0, 1)) * (robot.space.size() - 1);
    q[j] = robot.model.joints[j].upper + 0.05;
    const PoseBT X_BT = *robot.space.forward(robot.joints(q), {});
    const auto found = robot.space.inverse_near(robot.space.point(X_BT), q);
    ASSERT_TRUE(found) << describe(found.error());
    // A rolling forearm's roll is not asked for, so only what is can come back.
    EXPECT_NEAR((*found)[j], q[j], 1e-6);
  });
}

TEST_P(ToolSpaceOf, a_pose_that_its_joints_made_can_be_asked_for) {
  PathRobot robot(GetParam());
  for_random_cases(500, [&](Random& random) {
    const RobotPlace place = robot.random_place(random);
    const auto point = robot.space.asked(place.X_BT, robot.joints(place.q));
    ASSERT_TRUE(point) << describe(point.error().error);
    EXPECT_LE(norm(robot.space.pose(*point, place.X_BT.R).p - place.X_BT.p), 1e-15);
    const PoseBT X_BT = robot.space.pose(*point, place.X_BT.R);
    EXPECT_LE(angle_between(X_BT.R, place.X_BT.R), 1e-7);
  });
}

TEST(ToolSpace, a_palletizer_s_tool_cannot_be_turned_and_says_how_it_stands) {
  PathRobot robot("maxarm");
  for_random_cases(200, [&](Random& random) {
    const RobotPlace place = robot.random_place(random);
    PoseBT X_BT = place.X_BT;
    const double off = random.uniform(0.01, 3);
    X_BT.R = rotation_z(off) * X_BT.R;
    const auto point = robot.space.asked(X_BT, robot.joints(place.q));
    ASSERT_FALSE(point);
    EXPECT_EQ(point.error().error.code, ErrorCode::kOrientationNotReachable);
    EXPECT_NEAR(point.error().error.measured, off, 1e-6);
    EXPECT_LE(angle_between(point.error().X_BT.R, place.X_BT.R), 1e-7);
  });
}

TEST(ToolSpace, a_roll_that_a_rolling_forearm_cannot_have_is_refused_with_the_one_that_it_can) {
  PathRobot robot("bigrobotarm");
  int refused = 0;
  for_random_cases(300, [&](Random& random) {
    const RobotPlace place = robot.random_place(random);
    PoseBT X_BT = place.X_BT;
    X_BT.R = X_BT.R * rotation_z(random.uniform(0.05, 0.2));
    const auto point = robot.space.asked(X_BT, robot.joints(place.q));
    if (point) return random.discard();  // with its wrist straight it can
    ++refused;
    EXPECT_EQ(point.error().error.code, ErrorCode::kRollNotFree);
    EXPECT_LE(norm(point.error().X_BT.R.z - X_BT.R.z), 1e-9);
    EXPECT_NEAR(angle_between(point.error().X_BT.R, X_BT.R), point.error().error.measured, 1e-9);
    // What it names can be asked for.
    EXPECT_TRUE(robot.space.asked(point.error().X_BT, robot.joints(place.q)));
  });
  EXPECT_GT(refused, 200);
}

TEST_P(ToolSpaceOf, branches_are_inside_the_limits_and_hold_the_tool) {
  PathRobot robot(GetParam());
  for_random_cases(300, [&](Random& random) {
    const RobotPlace place = robot.random_place(random);
    const TaskPoint point = robot.space.point(place.X_BT);
    const auto branches = robot.space.branches(point, place.q);
    ASSERT_FALSE(branches.empty());
    for (const JointArray& q : branches) {
      for (std::size_t j = 0; j < robot.space.size(); ++j) {
        EXPECT_TRUE(within_limits(robot.model.joints[j], q[j]));
      }
      const auto X_BT = robot.space.forward(robot.joints(q), place.X_BT);
      ASSERT_TRUE(X_BT);
      EXPECT_LE(robot.space.offset(*X_BT, point).distance, 2e-9);
    }
  });
}

TEST_P(ToolSpaceOf, nothing_allocates) {
  PathRobot robot(GetParam());
  Random random(1);
  const RobotPlace place = robot.random_place(random);
  const test::AllocationCounter allocations;
  const TaskPoint point = robot.space.point(place.X_BT);
  EXPECT_TRUE(robot.space.inverse_near(point, place.q));
  EXPECT_TRUE(robot.space.forward(robot.joints(place.q), place.X_BT));
  EXPECT_GE(robot.space.branches(point, place.q).size(), 1U);
  EXPECT_GE(robot.space.singularity(robot.joints(place.q), place.X_BT).measured, 0);
  EXPECT_EQ(allocations.count(), 0U);
}

TEST(ToolSpace, names_the_singularity_that_is_near) {
  PathRobot robot("robot-arm-2");
  const auto near = [&](const JointArray& q) {
    return robot.space.singularity(robot.joints(q), *robot.space.forward(robot.joints(q), {}));
  };
  const Error wrist = near({0, from_deg(-30), from_deg(30), 0, from_deg(2), 0});
  EXPECT_EQ(wrist.code, ErrorCode::kWristSingular);
  EXPECT_NEAR(wrist.measured, std::sin(from_deg(2)), 1e-9);
  // The forearm is bent by atan(45 / 265) where its joint stands at 90 degrees less that.
  const double straight = kPi / 2 - std::atan2(45, 265);
  const Error elbow = near({0, -1, straight + 0.03, 0, 1, 0});
  EXPECT_EQ(elbow.code, ErrorCode::kElbowSingular);
  EXPECT_NEAR(elbow.measured, std::sin(0.03), 1e-6);
}

}  // namespace
}  // namespace sinew::planning
