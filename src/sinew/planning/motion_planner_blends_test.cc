#include <gtest/gtest.h>

#include <cmath>
#include <iostream>

#include "sinew/planning/motion_planner.h"
#include "sinew/planning/paths/move_path_test_robot.h"
#include "sinew/planning/timing/path_check.h"
#include "sinew/planning/timing/path_timing_test_paths.h"

namespace sinew::planning {
namespace {

using test::for_random_cases;
using test::Random;

class Blends : public testing::TestWithParam<const char*> {
 protected:
  Blends() : robot(GetParam()), planner(robot.model), motion(planner.make_motion()) {}

  std::vector<Move> random_moves(Random& random, const RobotPlace& start) const {
    std::vector<Move> moves;
    RobotPlace at = start;
    const double stride = random.uniform(0.1, 0.8);
    for (int i = 0; i < 4; ++i) {
      at = robot.random_neighbour(random, at, stride);
      moves.push_back(random.chance(0.3) ? joints_to(at.q) : line_to(at.X_BT));
      moves.back().blend_radius = test_paths::ten_to(random, -3, -1);
      if (random.chance(0.3)) moves.back().tool_speed = test_paths::ten_to(random, -1.5, 0);
      if (random.chance(0.2)) moves.back().joint_share = random.uniform(0.1, 1);
    }
    return moves;
  }

  /// The time of all moves; none where one is refused.
  std::optional<double> time_of(const RobotPlace& start, const std::vector<Move>& moves) {
    double time = 0;
    RobotPlace at = start;
    stops.clear();
    for (std::size_t k = 0; k < moves.size();) {
      if (!planner.plan(at, moves, k, motion)) return {};
      EXPECT_GT(motion.stretch.moves, 0U);
      if (motion.stop) {
        EXPECT_EQ(motion.stop->move, k + motion.stretch.moves - 1);
        EXPECT_GT(motion.stop->lost, 0);
        stops.push_back(*motion.stop);
      }
      k += motion.stretch.moves;
      at = motion.stretch.end;
      time += motion.law.duration();
      if (motion.empty()) continue;
      EXPECT_LE(check(motion.path, motion.law, motion_limits(robot.model), 1, 4,
                      shared_velocity(robot.model))
                    .worst(),
                1 + 1e-9);
    }
    return time;
  }

  PathRobot robot;
  MotionPlanner planner;
  PlannedMotion motion;
  std::vector<CornerStop> stops;
};

TEST_P(Blends, are_never_slower_than_stops_and_the_corners_where_they_would_be_are_told) {
  int cases = 0;
  std::size_t stopped = 0;
  double ratios = 0, worst = 0, lost = 0;
  for_random_cases(400, [&](Random& random) {
    const RobotPlace start = robot.random_place(random);
    std::vector<Move> moves = random_moves(random, start);
    const auto blended = time_of(start, moves);
    const auto told = stops;
    for (Move& move : moves) move.blend_radius = 0;
    const auto stopping = blended ? time_of(start, moves) : std::nullopt;
    if (!stopping || !(*stopping > 0)) return random.discard();
    EXPECT_TRUE(stops.empty());
    const double ratio = *blended / *stopping;
    EXPECT_LE(ratio, 1 + 1e-6);
    for (const CornerStop& stop : told) lost = std::max(lost, stop.lost / *stopping);
    stopped += told.size();
    ratios += ratio, worst = std::max(worst, ratio), ++cases;
  });
  ASSERT_GT(cases, 3);
  std::cout << "  " << cases << " ways: " << ratios / cases << " of the time of stops, at most "
            << worst << "; " << stopped << " blends left out, which would have cost up to "
            << 100 * lost << " % of the time\n";
  EXPECT_LT(ratios / cases, 0.99);
}

INSTANTIATE_TEST_SUITE_P(Robots, Blends, testing::ValuesIn(kPathRobots), path_robot_name);

}  // namespace
}  // namespace sinew::planning
