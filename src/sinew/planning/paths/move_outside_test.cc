// Motions that begin where the robot may not be: outside of its joints' limits, in an overlap.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>

#include "sinew/core/error_code.h"
#include "sinew/planning/motion_planner.h"
#include "support/property.h"
#include "support/robots.h"

namespace sinew::planning {
namespace {

using test::for_random_cases;
using test::Random;

JointArray from_degrees(std::initializer_list<double> degrees) {
  JointArray q{};
  std::size_t j = 0;
  for (const double angle : degrees) q[j++] = from_deg(angle);
  return q;
}

struct Outside {
  explicit Outside(const char* id)
      : model(test::robot(id)), planner(model), motion(planner.make_motion()) {}

  std::expected<void, PathRefusal> plan(const JointArray& from, std::vector<Move> moves) {
    const auto start = planner.place_at({from.data(), model.joints.size()});
    if (!start) return std::unexpected(PathRefusal{start.error(), {}, std::nullopt, {}});
    return planner.plan(*start, moves, 0, motion);
  }
  JointArray at(double share) const {
    PathPoint point;
    motion.path.joints.sample(share * motion.path.joints.length(), point);
    return point.q;
  }

  const RobotModel& model;
  MotionPlanner planner;
  PlannedMotion motion;
};

TEST(MoveOutside, joint_comes_in_from_however_far_and_goes_no_farther_out) {
  for (const double beyond_deg : {1e-7, 1e-3, 0.5, 3.0}) {
    SCOPED_TRACE(beyond_deg);
    Outside robot("learm");
    const JointArray from = from_degrees({90 + beyond_deg, 0, 0, 0, 0});
    const auto planned = robot.plan(from, {{.way = MoveJ{from_degrees({80, 0, 0, 0, 0})}}});
    ASSERT_TRUE(planned) << describe(planned.error().error);
    for (int k = 1; k <= 100; ++k) EXPECT_LE(robot.at(k / 100.0)[0], robot.at((k - 1) / 100.0)[0]);
    EXPECT_NEAR(robot.at(1)[0], from_deg(80), 1e-12);
    // Another joint alone: this one stays where it is.
    EXPECT_TRUE(robot.plan(from, {{.way = MoveJ{from_degrees({90 + beyond_deg, 5, 0, 0, 0})}}}));
    const auto out =
        robot.plan(from, {{.way = MoveJ{from_degrees({91 + beyond_deg, 0, 0, 0, 0})}}});
    ASSERT_FALSE(out);
    EXPECT_EQ(out.error().error.code, ErrorCode::kJointLimit);
    EXPECT_EQ(out.error().error.index, 0);
    EXPECT_NEAR(out.error().error.limit, from_deg(90), 1e-12);
    EXPECT_NEAR(out.error().error.measured, from_deg(91 + beyond_deg), 1e-9);
    // From inside, the limit is where it always was.
    EXPECT_FALSE(robot.plan(from_degrees({80, 0, 0, 0, 0}),
                            {{.way = MoveJ{from_degrees({90 + beyond_deg, 0, 0, 0, 0})}}}));
  }
}

TEST(MoveOutside, joint_that_is_back_inside_does_not_come_out_again) {
  Outside robot("learm");
  const JointArray from = from_degrees({92, 0, 0, 0, 0});
  const Move in{.way = MoveJ{from_degrees({89, 5, 0, 0, 0})}, .blend_joints = from_deg(1)};
  const Move further{.way = MoveJ{from_degrees({80, 0, 0, 0, 0})}};
  ASSERT_TRUE(robot.plan(from, {in, further}));
  EXPECT_EQ(robot.motion.stretch.moves, 2U);
  const Move out{.way = MoveJ{from_degrees({91, 0, 0, 0, 0})}};
  const auto refused = robot.plan(from, {in, out});
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().error.code, ErrorCode::kJointLimit);
  // Nor does one turn back that is still outside.
  const Move less{.way = MoveJ{from_degrees({91, 5, 0, 0, 0})}, .blend_joints = from_deg(1)};
  const auto turned = robot.plan(from, {less, {.way = MoveJ{from_degrees({91.5, 0, 0, 0, 0})}}});
  ASSERT_FALSE(turned);
  EXPECT_EQ(turned.error().place.move, 1U);
}

TEST(MoveOutside, tool_s_ways_do_not_begin_there_and_what_does_is_proposed) {
  int offered = 0;
  Outside robot("robot-arm-2");
  for_random_cases(100, [&](Random& random) {
    const JointArray from = from_degrees(
        {170.5, random.uniform(0, 30), random.uniform(-60, -30), 0, random.uniform(20, 60), 0});
    const auto start = robot.planner.place_at({from.data(), 6});
    ASSERT_TRUE(start);
    PoseBT X = start->X_BT;
    const double side = random.uniform(-0.04, 0.04);
    X.p = X.p + side * normalized(Vec3{-X.p.y, X.p.x, 0});
    const std::vector<Move> line{{.way = MoveL{{X, Asked::kPose}}}};
    const auto planned = robot.plan(from, line);
    ASSERT_FALSE(planned);
    EXPECT_EQ(planned.error().error.code, ErrorCode::kJointLimit);
    EXPECT_EQ(planned.error().error.index, 0);
    EXPECT_NEAR(planned.error().error.measured, from[0], 1e-12);
    EXPECT_EQ(planned.error().place.at, 0);
    const MoveProposal proposal = robot.planner.propose(planned.error(), line);
    ASSERT_TRUE(proposal.back_inside);
    const auto back = robot.plan(from, {{.way = MoveJ{*proposal.back_inside}}});
    ASSERT_TRUE(back) << describe(back.error().error);
    for (std::size_t j = 0; j < 6; ++j) {
      EXPECT_TRUE(within_limits(robot.model.joints[j], (*proposal.back_inside)[j]));
    }
    // To the same place by joints, where they reach it.
    if (!proposal.move_j) return;
    ++offered;
    EXPECT_TRUE(robot.plan(from, {{.way = MoveTo{{X, Asked::kPose}}}}));
  });
  EXPECT_GT(offered, 10);
}

TEST(MoveOutside, joint_that_is_nowhere_near_is_refused) {
  Outside robot("learm");
  const auto refused =
      robot.plan(from_degrees({1e6, 0, 0, 0, 0}), {{.way = MoveJ{from_degrees({0, 0, 0, 0, 0})}}});
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().error.code, ErrorCode::kJointLimit);
}

TEST(MoveOutside, overlap_may_only_come_apart) {
  Outside robot("robot-arm-2");
  const CollisionModel collision(robot.model);
  const JointArray folded = from_degrees({0, -60, -55, 0, 0, 0});
  const double depth = collision.distance({folded.data(), 6}).distance;
  ASSERT_LT(depth, -1e-3);
  const auto planned = robot.plan(folded, {{.way = MoveJ{from_degrees({0, -60, 0, 0, 0, 0})}}});
  ASSERT_TRUE(planned) << describe(planned.error().error);
  double last = depth;
  for (int k = 1; k <= 500; ++k) {
    const JointArray q = robot.at(k / 500.0);
    const double now = collision.distance({q.data(), 6}).distance;
    const double least = std::min(last, collision.margin());
    EXPECT_GE(now, least - 2 * CollisionModel::kResolution - 1e-9) << k;
    last = std::max(last, now);
  }
  // Where something would go deeper it is refused, with how deep that is.
  const JointArray deep = from_degrees({0, -60, -100, 0, 0, 0});
  for (const double elbow_deg : {-110.0, 0.0}) {
    const auto deeper =
        robot.plan(deep, {{.way = MoveJ{from_degrees({0, -60, elbow_deg, 0, 0, 0})}}});
    ASSERT_FALSE(deeper);
    EXPECT_EQ(deeper.error().error.code, ErrorCode::kCollision);
    EXPECT_LT(deeper.error().error.measured, -1e-3);
    EXPECT_GE(deeper.error().error.measured, -0.1);
  }
  // Out and in again is refused on the way in.
  const Move out{.way = MoveJ{from_degrees({0, -60, 0, 0, 0, 0})}, .blend_joints = from_deg(1)};
  const auto again =
      robot.plan(folded, {out, {.way = MoveJ{from_degrees({20, -60, -100, 0, 0, 0})}}});
  ASSERT_FALSE(again);
  EXPECT_EQ(again.error().error.code, ErrorCode::kCollision);
  EXPECT_EQ(again.error().place.move, 1U);
}

}  // namespace
}  // namespace sinew::planning
