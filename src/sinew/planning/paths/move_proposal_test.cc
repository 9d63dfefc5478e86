// What is offered instead of refused moves: rows straight in joints as well as tool's ways.
#include "sinew/planning/paths/move_proposal.h"

#include <gtest/gtest.h>

#include <cmath>

#include "sinew/core/error_code.h"
#include "sinew/planning/motion_planner.h"
#include "support/property.h"
#include "support/robots.h"

namespace sinew::planning {
namespace {

using test::for_random_cases;
using test::Random;

struct Proposing {
  explicit Proposing(const char* id)
      : model(test::robot(id)), planner(model), collision(model), motion(planner.make_motion()) {}

  /// Somewhere inside the limits and clear of itself.
  RobotPlace random_place(Random& random) {
    for (;;) {
      JointArray q{};
      for (std::size_t j = 0; j < model.joints.size(); ++j) {
        q[j] = random.uniform(model.joints[j].lower, model.joints[j].upper);
      }
      const std::span<const double> joints(q.data(), model.joints.size());
      if (!collision.clear(joints, collision.margin() + 0.01)) continue;
      const auto place = planner.place_at(joints);
      if (place) return *place;
    }
  }
  std::expected<void, PathRefusal> plan(const RobotPlace& from, const Move& move) {
    return planner.plan(from, {&move, 1}, 0, motion);
  }
  bool works(const RobotPlace& from, const JointArray& q) {
    return plan(from, {.way = MoveJ{q}}).has_value();
  }

  const RobotModel& model;
  MotionPlanner planner;
  CollisionModel collision;
  PlannedMotion motion;
};

/// Everything that was offered can be planned; of the turned ones, where the tool then is.
void expect_works(Proposing& robot, const RobotPlace& from, const MoveProposal& offer) {
  std::vector<std::optional<JointArray>> rows{offer.move_j, offer.nearest_q, offer.back_inside};
  if (offer.near) rows.push_back(offer.near->q);
  if (offer.tilted) rows.push_back(offer.tilted->q);
  for (const auto& q : rows) EXPECT_TRUE(!q || robot.works(from, *q));
  if (offer.nearest && !offer.nearest_q) {
    EXPECT_TRUE(robot.plan(from, {.way = MoveL{{offer.nearest->X_BT}}}));
  }
}

TEST(MoveProposal, orientation_that_five_joints_cannot_have_gets_the_nearest_one_that_works) {
  for (const char* id : {"learm", "bigrobotarm"}) {
    SCOPED_TRACE(id);
    Proposing robot(id);
    int refused = 0;
    int helped = 0;
    for_random_cases(200, [&](Random& random) {
      const RobotPlace from = robot.random_place(random);
      PoseBT X = robot.random_place(random).X_BT;
      const Vec3 axis{random.uniform(-1, 1), random.uniform(-1, 1), random.uniform(-1, 1)};
      X.R = rotation_from_vector(random.uniform(0.2, 1.5) * normalized(axis)) * X.R;
      const Move line{.way = MoveL{{X, Asked::kPose}}};
      const auto planned = robot.plan(from, line);
      if (planned || !planned.error().nearest) return random.discard();
      ++refused;
      const MoveProposal offer = robot.planner.propose(planned.error(), {&line, 1});
      expect_works(robot, from, offer);
      if (offer.nearest || offer.tilted || offer.near) ++helped;
    });
    EXPECT_GT(refused, 100);
    // Where nothing is hit on the way, something to do instead is found.
    EXPECT_GT(helped, 0.97 * refused) << refused;
  }
}

TEST(MoveProposal, joint_rows_to_a_tool_target_get_another_pitch_branch_or_place) {
  for (const char* id : {"learm", "robot-arm-2", "maxarm"}) {
    SCOPED_TRACE(id);
    Proposing robot(id);
    int refused = 0;
    int helped = 0;
    for_random_cases(200, [&](Random& random) {
      const RobotPlace from = robot.random_place(random);
      PoseBT X = robot.random_place(random).X_BT;
      X.p = random.uniform(0.8, 1.6) * X.p;
      const Move move{.way = MoveTo{{X, Asked::kPoint}}};
      const auto planned = robot.plan(from, move);
      if (planned) return random.discard();
      ++refused;
      const MoveProposal offer = robot.planner.propose(planned.error(), {&move, 1});
      expect_works(robot, from, offer);
      if (offer.near) {
        const auto end = robot.planner.space().forward(
            {offer.near->q.data(), robot.model.joints.size()}, from.X_BT);
        EXPECT_NEAR(norm(end->p - X.p), offer.near->left, 1e-9);
      }
      if (offer.move_j || offer.tilted || offer.near) ++helped;
    });
    EXPECT_GT(refused, 50);
    EXPECT_GT(helped, 0.8 * refused) << refused;
  }
}

TEST(MoveProposal, joints_beyond_their_limits_are_offered_as_far_as_they_go) {
  Proposing robot("learm");
  const auto from = robot.planner.place_at(std::vector<double>(5, 0.1));
  ASSERT_TRUE(from);
  const Move beyond{.way = MoveJ{{0, 2, 0, 0, 0}}};
  const auto planned = robot.plan(*from, beyond);
  ASSERT_FALSE(planned);
  const MoveProposal offer = robot.planner.propose(planned.error(), {&beyond, 1});
  ASSERT_TRUE(offer.near);
  EXPECT_NEAR(offer.near->q[1], robot.model.joints[1].upper, 2e-5);
  EXPECT_LE(offer.near->q[1], robot.model.joints[1].upper);
  EXPECT_TRUE(robot.works(*from, offer.near->q));
}

TEST(MoveProposal, joints_that_would_hit_something_are_offered_up_to_there) {
  Proposing robot("robot-arm-2");
  const auto from = robot.planner.place_at(std::vector<double>(6, 0));
  ASSERT_TRUE(from);
  const Move folded{.way = MoveJ{{0, from_deg(-60), from_deg(-110), 0, 0, 0}}};
  const auto planned = robot.plan(*from, folded);
  ASSERT_FALSE(planned);
  ASSERT_EQ(planned.error().error.code, ErrorCode::kCollision);
  ASSERT_TRUE(planned.error().nearest_behind);
  EXPECT_LT(*planned.error().nearest_behind, -1e-3) << "deep in the end";
  const MoveProposal offer = robot.planner.propose(planned.error(), {&folded, 1});
  ASSERT_TRUE(offer.near);
  EXPECT_LT(offer.near->q[2], from_deg(-20));
  EXPECT_TRUE(robot.works(*from, offer.near->q));
}

TEST(MoveProposal, leg_beyond_its_limit_is_named_with_how_far) {
  Proposing robot("hexapod");
  JointArray q{};
  for (std::size_t j = 0; j < 6; ++j) q[j] = robot.model.joints[j].home;
  const auto from = robot.planner.place_at({q.data(), 6});
  ASSERT_TRUE(from);
  for (const double length : {0.4, 0.6, 3.0}) {
    q[0] = length;
    const auto planned = robot.plan(*from, {.way = MoveJ{q}});
    ASSERT_FALSE(planned);
    EXPECT_EQ(planned.error().error.code, ErrorCode::kLegLength);
    EXPECT_EQ(planned.error().error.index, 0);
    EXPECT_NEAR(planned.error().error.measured, length, 1e-9);
  }
}

}  // namespace
}  // namespace sinew::planning
