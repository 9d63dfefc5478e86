#include "sinew/planning/motion_planner.h"

#include <gtest/gtest.h>

#include <cmath>

#include "sinew/core/error_code.h"
#include "sinew/planning/timing/path_check.h"
#include "support/property.h"
#include "support/robots.h"

namespace sinew::planning {
namespace {

using test::for_random_cases;
using test::Random;

JointArray array_of(std::initializer_list<double> degrees) {
  JointArray q{};
  std::size_t j = 0;
  for (const double angle : degrees) q[j++] = from_deg(angle);
  return q;
}

struct Arm {
  Arm() : model(test::robot("robot-arm-2")), planner(model), motion(planner.make_motion()) {}

  RobotPlace at(const JointArray& q) {
    const auto place = planner.place_at({q.data(), 6});
    EXPECT_TRUE(place);
    return *place;
  }

  const RobotModel& model;
  MotionPlanner planner;
  PlannedMotion motion;
};

TEST(MotionPlanner, random_joint_moves_hit_nothing_and_keep_all_limits_or_are_refused) {
  Arm arm;
  const CollisionModel collision(arm.model);
  const auto limits = motion_limits(arm.model);
  int made = 0;
  int refused = 0;
  for_random_cases(100, [&](Random& random) {
    const RobotPlace from = arm.at(array_of({0, 20, -30, 0, 30, 0}));
    MoveJ to;
    for (std::size_t j = 0; j < 6; ++j) {
      to.q[j] = random.uniform(arm.model.joints[j].lower, arm.model.joints[j].upper);
    }
    const Move move{.way = to};
    const auto planned = arm.planner.plan(from, {&move, 1}, 0, arm.motion);
    if (!planned) {
      ++refused;
      EXPECT_EQ(planned.error().error.code, ErrorCode::kCollision);
      // What is refused does come too near there.
      const double share = planned.error().place.share;
      JointArray q{};
      for (std::size_t j = 0; j < 6; ++j) q[j] = from.q[j] + share * (to.q[j] - from.q[j]);
      EXPECT_LT(collision.distance({q.data(), 6}).distance,
                arm.model.collision.margin + 2 * CollisionModel::kResolution);
      return;
    }
    ++made;
    const Trajectory trajectory = arm.motion.trajectory();
    JointMotion at;
    for (int k = 0; k <= 200; ++k) {
      trajectory.sample(trajectory.duration() * k / 200, at);
      EXPECT_TRUE(collision.clear({at.q.data(), 6}, arm.model.collision.margin - 1e-9));
    }
    EXPECT_LE(check(arm.motion.path, arm.motion.law, limits).worst(), 1 + 1e-6);
  });
  EXPECT_GT(made, 10);
  EXPECT_GT(refused, 10);
}

TEST(MotionPlanner, start_that_is_too_near_may_leave_and_not_come_nearer) {
  Arm arm;
  // The forearm folded back a little farther than the margin allows.
  const RobotPlace folded = arm.at(array_of({0, 0, -60, 0, 30, 0}));
  const CollisionModel collision(arm.model);
  const double here = collision.distance({folded.q.data(), 6}).distance;
  ASSERT_LT(here, arm.model.collision.margin);
  ASSERT_GT(here, 0);
  const Move out{.way = MoveJ{array_of({0, 0, -20, 0, 30, 0})}};
  EXPECT_TRUE(arm.planner.plan(folded, {&out, 1}, 0, arm.motion));
  EXPECT_LT(arm.motion.clearance_min, here);
  const Move in{.way = MoveJ{array_of({0, 0, -63, 0, 30, 0})}};
  const auto refused = arm.planner.plan(folded, {&in, 1}, 0, arm.motion);
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().error.code, ErrorCode::kCollision);
  EXPECT_EQ(refused.error().error.limit, arm.model.collision.margin);
}

TEST(MotionPlanner, move_to_a_tool_pose_goes_straight_in_joints_to_the_nearest_branch) {
  Arm arm;
  for_random_cases(200, [&](Random& random) {
    JointArray q{};
    for (std::size_t j = 0; j < 6; ++j) {
      const double half = from_deg(j == 1 || j == 2 ? 25 : 40);
      q[j] = random.uniform(-half, half);
    }
    const RobotPlace target = arm.at(q);
    const RobotPlace from = arm.at(array_of({0, 10, -20, 0, 25, 0}));
    const Move move{.way = MoveTo{{target.X_BT, Asked::kPose}}};
    const auto planned = arm.planner.plan(from, {&move, 1}, 0, arm.motion);
    if (!planned) return random.discard();
    const RobotPlace& end = arm.motion.stretch.end;
    EXPECT_LT(norm(end.X_BT.p - target.X_BT.p), 1e-7);
    EXPECT_LT(angle_between(end.X_BT.R, target.X_BT.R), 1e-7);
    const auto farthest = [&](const JointArray& to) {
      double largest = 0;
      for (std::size_t j = 0; j < 6; ++j) largest = std::max(largest, std::abs(to[j] - from.q[j]));
      return largest;
    };
    EXPECT_LE(farthest(end.q), farthest(q) + 1e-6) << "another branch is nearer";
    EXPECT_EQ(arm.motion.path.joints.size(), 1U);
  });
}

TEST(MotionPlanner, what_it_proposes_instead_hits_nothing) {
  Arm arm;
  int proposed = 0;
  for_random_cases(60, [&](Random& random) {
    const RobotPlace from = arm.at(array_of({0, 20, -30, 0, 30, 0}));
    // All around: many a line to there would go through the arm itself.
    const Vec3 p{random.uniform(-0.6, 0.6), random.uniform(-0.6, 0.6), random.uniform(0.1, 0.8)};
    const Move line{.way = MoveL{{{from.X_BT.R, p}, Asked::kPoint}}};
    const auto planned = arm.planner.plan(from, {&line, 1}, 0, arm.motion);
    if (planned) return random.discard();
    const MoveProposal proposal = arm.planner.propose(planned.error(), {&line, 1});
    if (!proposal.move_j) return random.discard();
    ++proposed;
    const Move move{.way = MoveJ{*proposal.move_j}};
    EXPECT_TRUE(arm.planner.plan(from, {&move, 1}, 0, arm.motion));
    EXPECT_LT(norm(arm.motion.stretch.end.X_BT.p - p), 1e-6);
  });
  EXPECT_GT(proposed, 0);
}

}  // namespace
}  // namespace sinew::planning
