#include "sinew/planning/paths/move_path.h"

#include <gtest/gtest.h>

#include <cmath>

#include "sinew/core/error_code.h"
#include "sinew/planning/paths/move_path_test_robot.h"
#include "support/allocation_guard.h"

namespace sinew::planning {
namespace {

using test::for_random_cases;
using test::Random;

class MovePath : public testing::TestWithParam<const char*> {};
INSTANTIATE_TEST_SUITE_P(Robots, MovePath, testing::ValuesIn(kPathRobots), path_robot_name);

/// What is nowhere in the code under test: the orientation of a line at `share` of it, from the
/// exponential map (six joints, platform), from angles, or from the plane of two directions.
double turn_off_line(const PathRobot& robot, const RobotPlace& from, const RobotPlace& to,
                     double share, const PoseBT& X_BT) {
  switch (robot.space.task()) {
    case TaskSpace::kPose: {
      const Vec3 w = rotation_vector(from.X_BT.R.transposed() * to.X_BT.R);
      return angle_between(X_BT.R, from.X_BT.R * rotation_from_vector(share * w));
    }
    case TaskSpace::kPitchRoll: {
      const auto a = robot.space.point(from.X_BT).attitude;
      const auto b = robot.space.point(to.X_BT).attitude;
      const double pitch = a[0] + share * std::remainder(b[0] - a[0], 2 * kPi);
      const double roll = a[1] + share * std::remainder(b[1] - a[1], 2 * kPi);
      const Rotation R =
          rotation_z(std::atan2(X_BT.p.y, X_BT.p.x)) * rotation_y(pitch) * rotation_z(roll);
      return angle_between(X_BT.R, R);
    }
    case TaskSpace::kApproach: {
      const auto angle = [](const Vec3& u, const Vec3& v) {
        return std::atan2(norm(cross(u, v)), dot(u, v));
      };
      const double whole = angle(from.X_BT.R.z, to.X_BT.R.z);
      return std::max(std::abs(angle(from.X_BT.R.z, X_BT.R.z) - share * whole),
                      std::abs(angle(X_BT.R.z, to.X_BT.R.z) - (1 - share) * whole));
    }
    case TaskSpace::kPoint:
      break;
  }
  return 0;
}

/// Visits the path at twenty places between each two knots, with the tool there.
template <class Visit>
void visit_densely(PathRobot& robot, const RobotPlace& from, Visit&& visit) {
  const JointPath& path = robot.path.joints;
  PoseBT X_near = from.X_BT;
  for (std::size_t i = 0; i < path.size(); ++i) {
    const double h = path.begin(i + 1) - path.begin(i);
    for (int k = 0; k <= 20; ++k) {
      PathPoint at;
      path.sample_piece(i, h * k / 20, at);
      const auto X_BT = robot.space.forward(robot.joints(at.q), X_near);
      ASSERT_TRUE(X_BT);
      X_near = *X_BT;
      visit(path.begin(i) + h * k / 20, at, X_near);
    }
  }
}

TEST_P(MovePath, a_line_is_straight_and_turns_evenly_between_its_knots_too) {
  PathRobot robot(GetParam());
  int planned = 0;
  for_random_cases(300, [&](Random& random) {
    const RobotPlace from = robot.random_place(random);
    const RobotPlace to = robot.random_neighbour(random, from, random.chance(0.5) ? 0.3 : 1);
    const std::vector<Move> moves{line_to(to.X_BT)};
    const auto stretch = robot.builder.build(from, moves, 0, robot.path);
    if (!stretch) return random.discard();
    ++planned;
    const double length = robot.path.joints.length();
    visit_densely(robot, from, [&](double s, const PathPoint&, const PoseBT& X_BT) {
      const double share = s / length;
      const Vec3 p = from.X_BT.p + share * (to.X_BT.p - from.X_BT.p);
      EXPECT_LE(norm(X_BT.p - p), kPathTolerance);
      EXPECT_LE(turn_off_line(robot, from, to, share, X_BT), kPathTurnTolerance);
    });
    expect_smooth(robot.path.joints);
    EXPECT_NEAR(
        length,
        std::max(norm(to.X_BT.p - from.X_BT.p),
                 kTurnRadius * turn_between(robot.space.task(), robot.space.point(from.X_BT),
                                            robot.space.point(to.X_BT))),
        1e-12);
  });
  EXPECT_GT(planned, 90) << "most lines between neighbours can be made";
}

TEST_P(MovePath, a_line_begins_exactly_where_the_robot_is_and_ends_at_its_target) {
  PathRobot robot(GetParam());
  for_random_cases(300, [&](Random& random) {
    const RobotPlace from = robot.random_place(random);
    const RobotPlace to = robot.random_neighbour(random, from, 0.3);
    const std::vector<Move> moves{line_to(to.X_BT)};
    const auto stretch = robot.builder.build(from, moves, 0, robot.path);
    if (!stretch) return random.discard();
    PathPoint at;
    robot.path.joints.sample(0, at);
    EXPECT_EQ(at.q, from.q);
    robot.path.joints.sample(robot.path.joints.length(), at);
    const auto X_BT = robot.space.forward(robot.joints(at.q), to.X_BT);
    ASSERT_TRUE(X_BT);
    const ToolOffset off = robot.space.offset(*X_BT, robot.space.point(to.X_BT));
    EXPECT_LE(off.distance, 1e-9);
    EXPECT_LE(off.angle, 1e-9);
    for (std::size_t j = 0; j < robot.space.size(); ++j) {
      EXPECT_NEAR(at.q[j], stretch->end.q[j], 1e-12);
      EXPECT_TRUE(within_limits(robot.model.joints[j], at.q[j]));
    }
  });
}

TEST_P(MovePath, a_joint_move_is_straight_in_joints_and_counts_the_way_of_the_tool) {
  PathRobot robot(GetParam());
  for_random_cases(300, [&](Random& random) {
    const RobotPlace from = robot.random_place(random);
    const RobotPlace to = robot.random_neighbour(random, from, 2);
    const std::vector<Move> moves{joints_to(to.q)};
    const auto stretch = robot.builder.build(from, moves, 0, robot.path);
    ASSERT_TRUE(stretch) << describe(stretch.error().error);
    ASSERT_EQ(robot.path.joints.size(), 1U);
    EXPECT_EQ(stretch->end.q, to.q);
    const double length = robot.path.joints.length();
    double way = 0;
    Vec3 last = from.X_BT.p;
    for (int k = 0; k <= 200; ++k) {
      PathPoint at;
      robot.path.joints.sample(length * k / 200, at);
      for (std::size_t j = 0; j < robot.space.size(); ++j) {
        EXPECT_NEAR(at.q[j], from.q[j] + (to.q[j] - from.q[j]) * k / 200, 1e-14);
      }
      const auto X_BT = robot.space.forward(robot.joints(at.q), from.X_BT);
      ASSERT_TRUE(X_BT);
      way += norm(X_BT->p - last);
      last = X_BT->p;
    }
    EXPECT_GE(length, 0.99 * way);
  });
}

TEST_P(MovePath, no_tool_is_faster_than_its_piece_says) {
  PathRobot robot(GetParam());
  for_random_cases(100, [&](Random& random) {
    const RobotPlace from = robot.random_place(random);
    const RobotPlace to = robot.random_neighbour(random, from, 0.5);
    const std::vector<Move> moves{random.chance(0.5) ? line_to(to.X_BT) : joints_to(to.q)};
    if (!robot.builder.build(from, moves, 0, robot.path)) return random.discard();
    const JointPath& path = robot.path.joints;
    ASSERT_EQ(robot.path.tool.size(), path.size());
    const Vec3* last = nullptr;
    Vec3 p_last;
    double s_last = 0;
    visit_densely(robot, from, [&](double s, const PathPoint&, const PoseBT& X_BT) {
      const std::size_t piece = path.piece_at((s + s_last) / 2);
      if (last != nullptr && s > s_last) {
        EXPECT_LE(norm(X_BT.p - p_last) / (s - s_last),
                  1.002 * robot.path.tool[piece].speed + 1e-6);
      }
      p_last = X_BT.p;
      s_last = s;
      last = &p_last;
    });
  });
}

TEST_P(MovePath, an_arc_is_round_goes_through_its_via_point_and_turns_evenly) {
  PathRobot robot(GetParam());
  int planned = 0;
  for_random_cases(300, [&](Random& random) {
    const RobotPlace from = robot.random_place(random);
    const RobotPlace via = robot.random_neighbour(random, from, 0.2);
    const RobotPlace to = robot.random_neighbour(random, from, 0.3);
    const std::vector<Move> moves{{.way = MoveC{via.X_BT.p, {to.X_BT}}}};
    if (!robot.builder.build(from, moves, 0, robot.path)) return random.discard();
    ++planned;
    // Centre from the perpendicular bisectors, as a linear system would give it.
    const Vec3 a = via.X_BT.p - from.X_BT.p;
    const Vec3 b = to.X_BT.p - from.X_BT.p;
    const Vec3 n = cross(a, b);
    const Vec3 centre =
        from.X_BT.p + (1 / (2 * dot(n, n))) * (dot(a, a) * cross(b, n) - dot(b, b) * cross(a, n));
    const double radius = norm(from.X_BT.p - centre);
    const double length = robot.path.joints.length();
    double nearest = 1;
    double last = 0;
    double swept = 0;
    Vec3 p_last = from.X_BT.p;
    visit_densely(robot, from, [&](double s, const PathPoint&, const PoseBT& X_BT) {
      EXPECT_NEAR(norm(X_BT.p - centre), radius, kPathTolerance);
      EXPECT_NEAR(dot(X_BT.p - centre, normalized(n)), 0, kPathTolerance);
      EXPECT_LE(turn_off_line(robot, from, to, s / length, X_BT), kPathTurnTolerance);
      const Vec3 u = p_last - centre;
      const Vec3 v = X_BT.p - centre;
      swept += std::atan2(dot(cross(u, v), normalized(n)), dot(u, v));
      EXPECT_GE(swept, last - 2 * kPathTolerance / radius);
      last = swept;
      p_last = X_BT.p;
      nearest = std::min(nearest, norm(X_BT.p - via.X_BT.p));
    });
    EXPECT_LT(swept, 2 * kPi);
    const double step = length / static_cast<double>(20 * robot.path.joints.size());
    EXPECT_LE(nearest, 2 * kPathTolerance + 20 * step);
    expect_smooth(robot.path.joints);
  });
  EXPECT_GT(planned, 30);
}

TEST_P(MovePath, a_spline_goes_through_its_points_in_order_without_a_kink) {
  PathRobot robot(GetParam());
  int planned = 0;
  for_random_cases(200, [&](Random& random) {
    const RobotPlace from = robot.random_place(random);
    MoveSpline spline;
    RobotPlace last = from;
    for (int i = 0; i < 4; ++i) {
      last = robot.random_neighbour(random, last, 0.15);
      spline.through.push_back({last.X_BT});
      if (random.chance(0.2)) spline.through.push_back({last.X_BT});
    }
    const std::vector<Move> moves{{.way = spline}};
    const auto stretch = robot.builder.build(from, moves, 0, robot.path);
    if (!stretch) return random.discard();
    ++planned;
    std::size_t next = 0;
    std::vector<double> nearest(spline.through.size(), 1);
    visit_densely(robot, from, [&](double, const PathPoint&, const PoseBT& X_BT) {
      for (std::size_t i = 0; i < nearest.size(); ++i) {
        nearest[i] = std::min(nearest[i], norm(X_BT.p - spline.through[i].X_BT.p));
      }
      next += next < nearest.size() && nearest[next] < 1e-3 ? 1 : 0;
    });
    // Half a step of the looks, at which the path runs past its point.
    for (const double distance : nearest) EXPECT_LE(distance, 0.4e-3);
    expect_smooth(robot.path.joints);
    const auto X_end = robot.space.forward(robot.joints(stretch->end.q), last.X_BT);
    ASSERT_TRUE(X_end);
    EXPECT_LE(norm(X_end->p - last.X_BT.p), 1e-9);
  });
  EXPECT_GT(planned, 30);
}

TEST_P(MovePath, a_move_to_where_the_robot_is_takes_no_way) {
  PathRobot robot(GetParam());
  Random random(3);
  for (int i = 0; i < 20; ++i) {
    const RobotPlace from = robot.random_place(random);
    const PoseBT X_BT = robot.space.pose(robot.space.point(from.X_BT), from.X_BT.R);
    if (angle_between(X_BT.R, from.X_BT.R) > kTaskTolerance) continue;  // a palletizer turned over
    for (const Move& move : {line_to(from.X_BT), joints_to(from.q),
                             Move{.way = MoveSpline{{{from.X_BT}, {from.X_BT}}}}}) {
      const auto stretch = robot.builder.build(from, std::vector<Move>{move}, 0, robot.path);
      ASSERT_TRUE(stretch) << describe(stretch.error().error);
      EXPECT_EQ(stretch->moves, 1U);
      EXPECT_TRUE(robot.path.joints.empty());
      EXPECT_EQ(stretch->end.q, from.q);
    }
  }
}

TEST_P(MovePath, the_tiniest_lines_are_made_as_well) {
  PathRobot robot(GetParam());
  for_random_cases(100, [&](Random& random) {
    const RobotPlace from = robot.random_place(random);
    PoseBT X_BT = from.X_BT;
    X_BT.p = X_BT.p + std::pow(10, random.uniform(-9, -4)) *
                          normalized(Vec3{random.uniform(-1, 1), random.uniform(-1, 1), 1});
    const Move move{.way = MoveL{{X_BT, Asked::kPoint}}};
    const auto stretch = robot.builder.build(from, std::vector<Move>{move}, 0, robot.path);
    if (!stretch) return random.discard();
    const auto X_end = robot.space.forward(robot.joints(stretch->end.q), X_BT);
    ASSERT_TRUE(X_end);
    EXPECT_LE(norm(X_end->p - X_BT.p), kNoWay);
  });
}

TEST_P(MovePath, what_is_no_number_is_refused) {
  PathRobot robot(GetParam());
  Random random(5);
  const RobotPlace from = robot.random_place(random);
  constexpr double kNone = std::numeric_limits<double>::quiet_NaN();
  std::vector<Move> moves;
  Move good{.way = MoveL{{from.X_BT, Asked::kPoint}}};
  moves.assign(6, good);
  std::get<MoveL>(moves[0].way).to.X_BT.p.y = kNone;
  moves[1].way = MoveJ{{kNone}};
  moves[2].tool_speed = kNone;
  moves[3].blend_radius = -1;
  moves[4].joint_share = 1.5;
  moves[5].way = MoveL{{{{{2, 0, 0}, {0, 1, 0}, {0, 0, 1}}, from.X_BT.p}}};
  moves.push_back({.way = MoveC{{kNone, 0, 0}, {from.X_BT, Asked::kPoint}}});
  moves.push_back({.way = MoveSpline{}});
  for (std::size_t i = 0; i < moves.size(); ++i) {
    const auto stretch = robot.builder.build(from, moves, i, robot.path);
    ASSERT_FALSE(stretch) << i;
    EXPECT_EQ(stretch.error().error.code, ErrorCode::kMoveInput) << i;
    EXPECT_EQ(stretch.error().place.move, i);
  }
  JointArray q = from.q;
  q[0] = kNone;
  EXPECT_EQ(robot.builder.place_at(robot.joints(q), from.X_BT).error().code, ErrorCode::kMoveInput);
}

TEST_P(MovePath, building_does_not_allocate) {
  PathRobot robot(GetParam());
  Random random(11);
  int planned = 0;
  for (int i = 0; i < 100; ++i) {
    const RobotPlace from = robot.random_place(random);
    const RobotPlace a = robot.random_neighbour(random, from, 0.2);
    const RobotPlace b = robot.random_neighbour(random, a, 0.2);
    std::vector<Move> moves{line_to(a.X_BT),
                            {.way = MoveC{a.X_BT.p, {b.X_BT, Asked::kPoint}}},
                            joints_to(from.q),
                            {.way = MoveSpline{{{a.X_BT}, {b.X_BT}}}}};
    for (Move& move : moves) move.blend_radius = 0.01;
    const test::AllocationCounter allocations;
    for (std::size_t first = 0; first < moves.size(); ++first) {
      planned += robot.builder.build(from, moves, first, robot.path) ? 1 : 0;
    }
    EXPECT_EQ(allocations.count(), 0U);
  }
  EXPECT_GT(planned, 20);
}

TEST(MovePathOfOneRobot, a_via_point_on_the_line_makes_no_arc) {
  PathRobot robot("robot-arm-2");
  Random random(1);
  const RobotPlace from = robot.random_place(random);
  PoseBT X_BT = from.X_BT;
  X_BT.p = X_BT.p + Vec3{0.1, 0, 0};
  for (const double along : {0.0, 0.05, 0.1, 0.2, -0.1}) {
    const Vec3 p_via = from.X_BT.p + Vec3{along, 0, 0};
    const std::vector<Move> moves{{.way = MoveC{p_via, {X_BT}}}};
    const auto stretch = robot.builder.build(from, moves, 0, robot.path);
    ASSERT_FALSE(stretch);
    EXPECT_EQ(stretch.error().error.code, ErrorCode::kArcCollinear) << along;
  }
}

}  // namespace
}  // namespace sinew::planning
