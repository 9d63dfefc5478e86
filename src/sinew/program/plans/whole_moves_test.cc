#include "sinew/program/plans/whole_moves.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <string>

#include "sinew/core/units.h"
#include "sinew/model/joint_lookup.h"
#include "sinew/planning/collision/collision.h"
#include "support/robots.h"

namespace sinew::program {
namespace {

struct Way {
  RobotModel model;
  JointVector q_start;
  RowMotion motion;
  double along_way = 0;  ///< s, as its smooth law takes it

  explicit Way(const char* id) : model(test::robot(id)), q_start(home_joints(model)) {}

  void plan(const std::string& text) {
    const auto rows = parse(text, "", model);
    ASSERT_TRUE(rows);
    RowPlanner planner(model);
    auto planned = planner.plan(q_start, {}, rows->steps);
    ASSERT_TRUE(planned) << describe(planned.error().error);
    motion = std::move(*planned);
    along_way = planner.motion().law.duration();
  }
  /// Straight down.
  void plan_line(double way_mm) {
    const planning::ToolSpace space(model);
    const auto X_BT = space.forward({q_start.data(), q_start.size()}, space.home());
    plan("line z=" + std::to_string(to_mm(X_BT->p.z) - way_mm) + "mm");
  }
};

void expect_stops(const Way& way) {
  const WholeMoves moves(way.q_start, way.motion, 1, way.model);
  ASSERT_GT(way.motion.pieces.size(), 1U);
  EXPECT_NEAR(moves.duration(), way.motion.duration, 1e-12);
  EXPECT_GT(moves.duration(), way.along_way) << "stops take their time";
  constexpr double kStep = 1e-3;
  std::size_t stops = 0;
  bool stood = true;
  planning::JointMotion now, before;
  moves.sample(0, before);
  for (double t = kStep; t < moves.duration() + kStep; t += kStep) {
    moves.sample(t, now);
    const bool stands = std::ranges::all_of(now.qd, [](double qd) { return qd == 0; });
    stops += stands && !stood ? 1 : 0;
    stood = stands;
    for (std::size_t j = 0; j < way.model.joints.size(); ++j) {
      const Joint& joint = way.model.joints[j];
      EXPECT_LE(std::abs(now.qd[j]), joint.velocity_max * (1 + 1e-9)) << t;
      EXPECT_NEAR(now.q[j] - before.q[j], (now.qd[j] + before.qd[j]) / 2 * kStep,
                  kStep * kStep * joint.acceleration_max)
          << t;
    }
    before = now;
  }
  EXPECT_EQ(stops, way.motion.pieces.size());
  for (std::size_t j = 0; j < way.model.joints.size(); ++j) {
    EXPECT_NEAR(now.q[j], way.motion.q_end[j], 1e-12);
  }
}

TEST(WholeMoves, go_from_stop_to_stop_as_the_plan_has_them) {
  Way maxarm("maxarm");
  maxarm.plan_line(60);
  expect_stops(maxarm);
  Way bigrobotarm("bigrobotarm");
  bigrobotarm.q_start[1] = from_deg(20);
  bigrobotarm.q_start[2] = from_deg(50);
  bigrobotarm.q_start[4] = from_deg(40);
  bigrobotarm.plan_line(60);
  expect_stops(bigrobotarm);
}

TEST(WholeMoves, boards_start_one_after_the_other_and_go_at_their_own_pace) {
  Way way("robot-arm-2");
  way.plan("joint J1=40deg J2=10deg");
  ASSERT_EQ(way.model.device.capability.motion, MotionKind::kPointToPoint);
  const WholeMoves moves(way.q_start, way.motion, 1, way.model);
  planning::JointMotion now;
  std::array<double, 2> start{-1, -1}, end{-1, -1};
  for (double t = 0; t < moves.duration(); t += 1e-3) {
    moves.sample(t, now);
    for (std::size_t j = 0; j < 2; ++j) {
      if (now.qd[j] == 0) continue;
      if (start[j] < 0) start[j] = t;
      end[j] = t;
    }
  }
  EXPECT_GT(start[0], 0);
  EXPECT_GT(start[1], start[0] + 0.05) << "the second one hears of it a frame later";
  EXPECT_GT(end[0], end[1]) << "the longer way takes longer";
  EXPECT_NEAR(std::max(end[0], end[1]), way.motion.arrival, 5e-3);
}

/// Its joints' straight way is clear; boards that each go at their own pace would come nearer to
/// the table than the margin.
TEST(WholeMoves, register_boards_hit_nothing_on_the_way_that_they_really_go) {
  Way way("robot-arm-2");
  const std::array<double, 6> from_deg_{0, 16, -11, 0, -73, 0};
  for (std::size_t j = 0; j < 6; ++j) way.q_start[j] = from_deg(from_deg_[j]);
  way.plan("joint J1=-1deg J2=-74deg J3=-23deg J4=0deg J5=84deg J6=0deg");
  EXPECT_GT(way.motion.pieces.size(), 1U);
  const planning::CollisionModel collision(way.model);
  const WholeMoves moves(way.q_start, way.motion, 1, way.model);
  double nearest = 1;
  for (double t = 0; t < moves.duration(); t += 0.02) {
    planning::JointMotion at;
    moves.sample(t, at);
    nearest = std::min(nearest, collision.distance({at.q.data(), 6}).distance);
  }
  EXPECT_GT(nearest, collision.margin() - 1e-3);
  // In one move it does not stay clear.
  RowMotion one = way.motion;
  one.pieces.erase(one.pieces.begin(), one.pieces.end() - 1);
  const WholeMoves at_once(way.q_start, one, 1, way.model);
  nearest = 1;
  for (double t = 0; t < at_once.duration(); t += 0.02) {
    planning::JointMotion at;
    at_once.sample(t, at);
    nearest = std::min(nearest, collision.distance({at.q.data(), 6}).distance);
  }
  EXPECT_LT(nearest, collision.margin() - 5e-3);
}

}  // namespace
}  // namespace sinew::program
