#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "sinew/planning/paths/move_path.h"
#include "sinew/planning/paths/move_path_test_robot.h"

namespace sinew::planning {
namespace {

using test::for_random_cases;
using test::Random;

class Blending : public testing::TestWithParam<const char*> {};
INSTANTIATE_TEST_SUITE_P(Robots, Blending, testing::ValuesIn(kPathRobots), path_robot_name);

/// A way of all kinds of moves between neighbouring places, and its corners.
struct Tour {
  std::vector<Move> moves;
  std::vector<RobotPlace> corners;  ///< where each move ends

  Tour(const PathRobot& robot, Random& random, const RobotPlace& from, double radius) {
    RobotPlace last = from;
    for (int i = 0; i < 4; ++i) {
      const RobotPlace next = robot.random_neighbour(random, last, 0.2);
      switch (random.integer(0, 3)) {
        case 0:
          moves.push_back(joints_to(next.q));
          break;
        case 1: {
          const RobotPlace via = robot.random_neighbour(random, last, 0.1);
          moves.push_back({.way = MoveC{via.X_BT.p, {next.X_BT}}});
          break;
        }
        case 2: {
          const RobotPlace via = robot.random_neighbour(random, last, 0.1);
          moves.push_back({.way = MoveSpline{{{via.X_BT}, {next.X_BT}}}});
          break;
        }
        default:
          moves.push_back(line_to(next.X_BT));
      }
      moves.back().blend_radius = radius;
      corners.push_back(next);
      last = next;
    }
  }
};

TEST_P(Blending, a_path_through_corners_has_no_jump_and_stays_within_their_radius) {
  PathRobot robot(GetParam());
  int blended = 0;
  for_random_cases(250, [&](Random& random) {
    const RobotPlace from = robot.random_place(random);
    const double radius = std::pow(10, random.uniform(-3.5, -1.3));
    const Tour tour(robot, random, from, radius);
    const auto stretch = robot.builder.build(from, tour.moves, 0, robot.path);
    if (!stretch) return random.discard();
    const JointPath& path = robot.path.joints;
    expect_smooth(path);
    ASSERT_EQ(robot.path.tool.size(), path.size());
    ASSERT_EQ(robot.path.sections.size(), stretch->moves);
    ASSERT_EQ(robot.builder.blends().size(), stretch->moves - 1);
    PathPoint at;
    path.sample(path.length(), at);
    for (std::size_t j = 0; j < robot.space.size(); ++j) {
      EXPECT_NEAR(at.q[j], stretch->end.q[j], 1e-12);
    }
    for (std::size_t k = 1; k < stretch->moves; ++k) {
      ++blended;
      const PathSection& section = robot.path.sections[k];
      const Blend& blend = robot.builder.blends()[k - 1];
      EXPECT_EQ(section.move, k);
      EXPECT_EQ(blend.move, k - 1);
      EXPECT_GT(section.begin, robot.path.sections[k - 1].begin);
      // From half a blend before the section's begin to half a blend behind it.
      const Vec3& corner = tour.corners[k - 1].X_BT.p;
      PoseBT X_near = tour.corners[k - 1].X_BT;
      for (int i = -100; i <= 100; ++i) {
        path.sample(section.begin + blend.way * i / 100, at);
        const auto X_BT = robot.space.forward(robot.joints(at.q), X_near);
        ASSERT_TRUE(X_BT);
        EXPECT_LE(norm(X_BT->p - corner), radius + 2 * kPathTolerance);
        for (std::size_t j = 0; j < robot.space.size(); ++j) {
          EXPECT_TRUE(within_limits(robot.model.joints[j], at.q[j]));
        }
      }
    }
  });
  EXPECT_GT(blended, 50);
}

TEST_P(Blending, a_radius_too_large_is_cut_to_half_of_the_shorter_neighbour) {
  PathRobot robot(GetParam());
  int blended = 0;
  for_random_cases(100, [&](Random& random) {
    const RobotPlace from = robot.random_place(random);
    const RobotPlace a = robot.random_neighbour(random, from, 0.1);
    const RobotPlace b = robot.random_neighbour(random, a, 0.1);
    std::vector<Move> moves{line_to(a.X_BT), line_to(b.X_BT)};
    moves[0].blend_radius = random.chance(0.5) ? 10 : std::numeric_limits<double>::infinity();
    MoveWay first(robot.space);
    MoveWay second(robot.space);
    if (first.make(moves[0], from) || second.make(moves[1], a)) return random.discard();
    const auto stretch = robot.builder.build(from, moves, 0, robot.path);
    if (!stretch || stretch->moves < 2) return random.discard();
    ++blended;
    EXPECT_LE(robot.builder.blends()[0].way, std::min(first.length(), second.length()) / 2 + 1e-12);
    EXPECT_GE(robot.builder.blends()[0].way,
              std::min(first.length(), second.length()) / 64 - 1e-12);
  });
  EXPECT_GT(blended, 20);
}

TEST_P(Blending, without_one_each_move_is_a_stretch_of_its_own_that_begins_where_the_last_ended) {
  PathRobot robot(GetParam());
  int ended = 0;
  for_random_cases(50, [&](Random& random) {
    RobotPlace at = robot.random_place(random);
    const Tour tour(robot, random, at, 0);
    for (std::size_t k = 0; k < tour.moves.size(); ++k) {
      const auto stretch = robot.builder.build(at, tour.moves, k, robot.path);
      if (!stretch) {
        EXPECT_EQ(stretch.error().place.move, k);
        return;
      }
      EXPECT_EQ(stretch->moves, 1U);
      PathPoint first;
      robot.path.joints.sample(0, first);
      EXPECT_EQ(first.q, at.q);
      EXPECT_EQ(robot.path.sections.front().move, k);
      at = stretch->end;
    }
    ++ended;
  });
  EXPECT_GT(ended, 2);
}

TEST_P(Blending, a_tolerance_of_the_joints_holds_as_well) {
  PathRobot robot(GetParam());
  int blended = 0;
  for_random_cases(60, [&](Random& random) {
    const RobotPlace from = robot.random_place(random);
    Tour tour(robot, random, from, 0);
    const double tolerance = robot.is_hexapod() ? 1e-3 : std::pow(10, random.uniform(-3, -1));
    for (Move& move : tour.moves) move.blend_joints = tolerance;
    PlannedPath alone(robot.space.size());
    std::vector<JointArray> corners;
    RobotPlace at = from;
    for (std::size_t k = 0; k + 1 < tour.moves.size(); ++k) {
      Move stopping = tour.moves[k];
      stopping.blend_joints = 0;
      const auto stretch = robot.builder.build(at, std::vector<Move>{stopping}, 0, alone);
      if (!stretch) return random.discard();
      at = stretch->end;
      corners.push_back(at.q);
    }
    const auto stretch = robot.builder.build(from, tour.moves, 0, robot.path);
    if (!stretch) return random.discard();
    for (std::size_t k = 1; k < stretch->moves; ++k) {
      ++blended;
      const Blend& blend = robot.builder.blends()[k - 1];
      for (int i = -50; i <= 50; ++i) {
        PathPoint place;
        robot.path.joints.sample(robot.path.sections[k].begin + blend.way * i / 50, place);
        for (std::size_t j = 0; j < robot.space.size(); ++j) {
          EXPECT_LE(std::abs(place.q[j] - corners[k - 1][j]), tolerance * 1.01);
        }
      }
    }
  });
  EXPECT_GT(blended, 20);
}

TEST(BlendingOfOneRobot, a_square_of_lines_is_rounded_and_its_tool_keeps_its_speed) {
  PathRobot robot("robot-arm-2");
  const RobotPlace from = robot.place({0, from_deg(-30), from_deg(30), 0, from_deg(60), 0}, {});
  const auto at = [&](double y, double z) {
    PoseBT X_BT = from.X_BT;
    X_BT.p = X_BT.p + Vec3{0, y, z};
    return X_BT;
  };
  std::vector<Move> moves{line_to(at(0.1, 0)), line_to(at(0.1, -0.1)), line_to(at(0, -0.1)),
                          line_to(at(0, 0))};
  for (Move& move : moves) move.blend_radius = 0.02;
  const auto stretch = robot.builder.build(from, moves, 0, robot.path);
  ASSERT_TRUE(stretch) << describe(stretch.error().error);
  EXPECT_EQ(stretch->moves, 4U);
  EXPECT_NEAR(robot.path.joints.length(), 0.4, 1e-9);
  for (const Blend& blend : robot.builder.blends()) EXPECT_NEAR(blend.way, 0.02, 1e-9);
  for (std::size_t k = 0; k < 4; ++k) {
    EXPECT_NEAR(robot.path.sections[k].begin, 0.1 * static_cast<double>(k), 1e-9);
  }
  // In the middle of a right-angled corner the even blend runs 3/16 of the radius off both lines.
  PathPoint middle;
  robot.path.joints.sample(0.1, middle);
  const Vec3 p = robot.space.forward(robot.joints(middle.q), {})->p - from.X_BT.p;
  EXPECT_NEAR(p.y, 0.1 - 0.02 * 3 / 16, 2e-4);
  EXPECT_NEAR(p.z, -0.02 * 3 / 16, 2e-4);
  for (const ToolRate& rate : robot.path.tool) EXPECT_LE(rate.speed, 1.02);
}

}  // namespace
}  // namespace sinew::planning
