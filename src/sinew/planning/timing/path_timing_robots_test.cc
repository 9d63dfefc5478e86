#include <gtest/gtest.h>

#include "sinew/planning/paths/move_path_test_robot.h"
#include "sinew/planning/timing/path_check.h"
#include "sinew/planning/timing/path_follower.h"
#include "sinew/planning/timing/path_timing_test_paths.h"

namespace sinew::planning {
namespace {

using test::for_random_cases;
using test::Random;

class RobotTiming : public testing::TestWithParam<const char*> {
 protected:
  RobotTiming() : robot(GetParam()) {
    const double share = robot.model.device.capability.limits_share;
    for (const Joint& joint : robot.model.joints) {
      limits.push_back(
          {share * joint.velocity_max, share * joint.acceleration_max, share * joint.jerk_max});
    }
  }

  /// Lines of the tool and straight ways of the joints, with corners to be rounded.
  std::vector<Move> random_moves(Random& random, const RobotPlace& start) const {
    std::vector<Move> moves;
    RobotPlace at = start;
    for (int i = 0; i < 3; ++i) {
      at = robot.random_neighbour(random, at, 0.7);
      moves.push_back(random.chance(0.3) ? joints_to(at.q) : line_to(at.X_BT));
      moves.back().blend_radius = test_paths::ten_to(random, -2.3, -1);
      if (random.chance(0.3)) moves.back().tool_speed = test_paths::ten_to(random, -1.5, 0);
    }
    return moves;
  }

  /// The time of all moves, each stretch from rest to rest; none where a move is refused.
  std::optional<double> time_of(const RobotPlace& start, const std::vector<Move>& moves) {
    double time = 0;
    RobotPlace at = start;
    for (std::size_t k = 0; k < moves.size();) {
      const auto stretch = robot.builder.build(at, moves, k, robot.path);
      if (!stretch) return {};
      k += stretch->moves;
      at = stretch->end;
      if (robot.path.joints.empty()) continue;
      EXPECT_FALSE(timing.prepare(robot.path, limits).has_value());
      EXPECT_FALSE(timing.plan({}, 1, law).has_value());
      EXPECT_LE(check(robot.path, law, limits, 1, 6).worst(), 1 + 1e-9);
      const PathState jump = test_paths::largest_jump(law);
      const double v_max = largest_speed();
      EXPECT_LE(jump.s, 1e-9 * robot.path.joints.length());
      EXPECT_LE(jump.v, 1e-8 * v_max);
      EXPECT_EQ(law.end().s, robot.path.joints.length());
      EXPECT_EQ(law.end().v, 0);
      time += law.duration();
    }
    return time;
  }

  double largest_speed() const {
    double most = 0;
    for (const LawPhase& phase : law.phases()) most = std::max(most, phase.state.v);
    return most;
  }

  PathRobot robot;
  std::vector<motion::AxisLimits> limits;
  PathTiming timing;
  TimeLaw law{timing.phases_max()};
};

TEST_P(RobotTiming, lines_through_the_inverse_and_their_blends_keep_every_limit_and_save_time) {
  double ratios = 0, worst = 0;
  int cases = 0, slower = 0;
  for_random_cases(60, [&](Random& random) {
    const RobotPlace start = robot.random_place(random);
    std::vector<Move> moves = random_moves(random, start);
    const auto blended = time_of(start, moves);
    for (Move& move : moves) move.blend_radius = 0;
    const auto stopping = blended ? time_of(start, moves) : std::nullopt;
    if (!stopping || !(*stopping > 0)) return random.discard();
    const double ratio = *blended / *stopping;
    ratios += ratio, worst = std::max(worst, ratio), ++cases;
    if (ratio > 1) ++slower;
  });
  ASSERT_GT(cases, 5);
  std::cout << "  rounded corners take " << ratios / cases << " of the time of stops, at most "
            << worst << "; " << slower << " of " << cases << " longer\n";
  EXPECT_LT(ratios / cases, 0.98);
  // A blend may bend the joints' ways more than it saves.
  EXPECT_LT(worst, 1.35);
  EXPECT_LE(slower, cases / 3);
}

TEST_P(RobotTiming, another_feed_a_pause_or_a_stop_within_a_blend_keeps_the_joints_limits) {
  PathFollower follower;
  int changes = 0;
  for_random_cases(25, [&](Random& random) {
    const RobotPlace start = robot.random_place(random);
    const std::vector<Move> moves = random_moves(random, start);
    if (!robot.builder.build(start, moves, 0, robot.path) || robot.builder.blends().empty())
      return random.discard();
    ASSERT_FALSE(follower.start(robot.path, limits, random.uniform(0.3, 2)).has_value());
    const double dt = follower.time_left() / 2000;
    // Blends lie around the beginning of each section but the first.
    const double middle = robot.path.sections[1].begin;
    const double way = robot.builder.blends()[0].way;
    const double change_at = middle + way * random.uniform(-1, 1);
    bool changed = false;
    for (int i = 0; i < 400000 && !follower.finished(); ++i) {
      const JointMotion& now = follower.step(dt);
      for (std::size_t j = 0; j < limits.size(); ++j) {
        ASSERT_LE(std::abs(now.qd[j]), limits[j].velocity * (1 + 1e-9));
        ASSERT_LE(std::abs(now.qdd[j]), limits[j].acceleration * (1 + 1e-9));
        ASSERT_LE(std::abs(now.qddd[j]), limits[j].jerk * (1 + 1e-9));
      }
      if (!changed && follower.state().s >= change_at) {
        changed = true;
        ++changes;
        const PathState before = follower.state();
        const auto kind = random.integer(0, 2);
        if (kind == 0) {
          ASSERT_FALSE(follower.set_feed(random.uniform(0.1, 2)).has_value());
        } else if (kind == 1) {
          follower.pause();
        } else {
          follower.stop();
        }
        follower.step(0);
        ASSERT_NEAR(follower.state().v, before.v, 1e-9 * (1 + before.v));
      }
      if (changed && follower.stopped() && follower.at_rest()) return;
      if (changed && follower.paused() && follower.at_rest()) {
        follower.resume();
      }
    }
    ASSERT_TRUE(follower.finished());
  });
  EXPECT_GT(changes, 3);
}

INSTANTIATE_TEST_SUITE_P(Robots, RobotTiming, testing::ValuesIn(kPathRobots), path_robot_name);

}  // namespace
}  // namespace sinew::planning
