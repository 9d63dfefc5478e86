#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <string>

#include "sinew/core/error_code.h"
#include "sinew/core/units.h"
#include "sinew/devices/bigrobotarm/bigrobotarm_settings.h"
#include "sinew/devices/lsc/lsc_settings.h"
#include "sinew/planning/paths/chords.h"
#include "sinew/program/plans/program_plan.h"
#include "support/property.h"
#include "support/robots.h"

/// A program whose target (or way) its wire cannot say is refused before anything moves.
namespace sinew::program {
namespace {

using kinematics::PoseBT;

JointVector degrees(std::initializer_list<double> values) {
  JointVector q;
  for (const double value : values) q.push_back(from_deg(value));
  return q;
}

std::expected<Plan, Refusal> plan(const RobotModel& robot, const std::string& text,
                                  const JointVector& start) {
  return make_plan(*parse(text, "p", robot), robot, start);
}

TEST(UnsayableRows, byte_wire_refuses_a_joint_row_into_its_gap_and_names_what_can_be_sent) {
  RobotModel robot = test::robot("bigrobotarm");
  const std::string text = "joint J1=20deg\njoint J1=48deg\n";
  const auto refused = plan(robot, text, degrees({0, 0, 0, 0, 0}));
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().line, 2);
  EXPECT_EQ(refused.error().error.code, ErrorCode::kUnsendable);
  ASSERT_TRUE(refused.error().way && refused.error().way->unsayable);
  const Unsayable& what = *refused.error().way->unsayable;
  EXPECT_EQ(what.joint, 0U);
  EXPECT_NEAR(to_deg(what.q), 48, 1e-9);
  ASSERT_TRUE(what.nearest);
  char instead[80];
  std::snprintf(instead, sizeof instead, "joint J1=%.3fdeg", to_deg((*what.nearest)[0]));
  EXPECT_TRUE(plan(robot, instead, degrees({20, 0, 0, 0, 0}))) << instead;
  EXPECT_TRUE(plan(robot, "joint J1=60deg\n", degrees({20, 0, 0, 0, 0})))
      << "what lies on the way of one move need not be said";
  robot.device.settings.get<BigRobotArmDevice>().wire = BigRobotArmWire::kText;
  EXPECT_TRUE(plan(robot, text, degrees({0, 0, 0, 0, 0})));
}

TEST(UnsayableRows, maxarm_and_servo_boards_refuse_pulses_that_they_do_not_send) {
  const RobotModel maxarm = test::robot("maxarm");
  JointVector home;
  for (const Joint& joint : maxarm.joints) home.push_back(joint.home);
  const auto zero = plan(maxarm, "joint J1=110deg\njoint J1=0deg\n", home);
  ASSERT_FALSE(zero);
  EXPECT_EQ(zero.error().line, 2);
  EXPECT_EQ(zero.error().error.code, ErrorCode::kPulseRange);

  RobotModel learm = test::robot("learm");
  auto& servo = learm.device.settings.get<LscDevice>().servos[0];
  servo.lower = static_cast<std::int32_t>(servo.centre + servo.trim) - 100;
  servo.upper = static_cast<std::int32_t>(servo.centre + servo.trim) + 100;
  const double beyond = to_deg(150 / std::abs(servo.units_per_rad));
  char text[80];
  std::snprintf(text, sizeof text, "joint J1=%.3fdeg\njoint J1=%.3fdeg\n", beyond / 2, beyond);
  const auto wide = plan(learm, text, degrees({0, 10, 75, 20, 0}));
  ASSERT_FALSE(wide);
  EXPECT_EQ(wide.error().line, 2);
  EXPECT_EQ(wide.error().error.code, ErrorCode::kPulseRange);
  // The slow first move of an arm that does not know where it stands, too.
  std::snprintf(text, sizeof text, "joint J1=%.3fdeg J2=10deg J3=75deg J4=20deg J5=0deg", beyond);
  const auto blind = make_plan(*parse(text, "p", learm), learm, std::nullopt);
  ASSERT_FALSE(blind);
  EXPECT_EQ(blind.error().error.code, ErrorCode::kPulseRange);
}

TEST(UnsayableRows, move_of_the_maxarm_is_as_long_as_its_wire_can_say_or_refused) {
  const RobotModel robot = test::robot("maxarm");
  JointVector home;
  for (const Joint& joint : robot.joints) home.push_back(joint.home);
  const auto slow = plan(robot, "joint J1=121deg\njoint J1=20deg speed=1%\n", home);
  ASSERT_FALSE(slow);
  EXPECT_EQ(slow.error().line, 2);
  EXPECT_EQ(slow.error().error.code, ErrorCode::kSegmentTime);
  EXPECT_EQ(slow.error().error.limit, 30);
  EXPECT_TRUE(plan(robot, "joint J1=20deg speed=2%\n", home));
  RowPlanner planner(robot);
  const auto little = planner.plan(home, {}, parse("joint J1=120.001deg", "p", robot)->steps);
  ASSERT_TRUE(little);
  ASSERT_EQ(little->pieces.size(), 1U);
  EXPECT_EQ(little->pieces[0].duration, std::chrono::milliseconds(20));
}

/// A line of the BigRobotArm with its tool upright, from one turn of the base to another.
struct Sweep {
  explicit Sweep(double from, double to, double shoulder_to = 20)
      : robot(test::robot("bigrobotarm")), planner(robot), start(degrees({from, 20, 100, 0, 60})) {
    const JointVector end = degrees({to, shoulder_to, 100, 0, 80 - shoulder_to});
    const PoseBT X = tool(end);
    const Vec3 turn = fixed_xyz(X.R);
    char text[200];
    std::snprintf(text, sizeof text,
                  "line x=%.6fmm y=%.6fmm z=%.6fmm rx=%.9fdeg ry=%.9fdeg rz=%.9fdeg", to_mm(X.p.x),
                  to_mm(X.p.y), to_mm(X.p.z), to_deg(turn.x), to_deg(turn.y), to_deg(turn.z));
    rows = *parse(text, "p", robot);
  }
  PoseBT tool(const JointVector& q) {
    return *planner.space().forward({q.data(), q.size()}, planner.space().home());
  }
  /// m that the tool is from the line that the row asks for, at most, over all pieces.
  double farthest_off(const RowMotion& motion) {
    const Vec3 a = tool(start).p;
    const Vec3 way = tool(motion.q_end).p - a;
    double off = 0;
    JointVector last = start;
    for (const JointMove& piece : motion.pieces) {
      for (int k = 0; k <= 50; ++k) {
        JointVector q = last;
        for (std::size_t j = 0; j < q.size(); ++j) q[j] += k / 50.0 * (piece.q[j] - last[j]);
        const Vec3 p = tool(q).p - a;
        off = std::max(off, norm(p - dot(p, way) / dot(way, way) * way));
      }
      last = piece.q;
    }
    return off;
  }
  /// Ends of chords that nobody had looked at with the wire in mind.
  int unsayable_chords(const JointVector& q_end) {
    const auto& path = planner.motion().path;
    const auto places = planning::chords(planner.space(), path, RowPlanner::kWayTolerance,
                                         RowPlanner::kChordMax, tool(start));
    int count = 0;
    planning::PathPoint at;
    for (const double s : places) {
      path.joints.sample(s, at);
      const bool last = s == places.back();
      const std::span q = last ? std::span<const double>(q_end.data(), q_end.size())
                               : std::span<const double>(at.q.data(), q_end.size());
      count += WireTarget(robot).refusal(q) ? 1 : 0;
    }
    return count;
  }

  RobotModel robot;
  RowPlanner planner;
  JointVector start;
  Program rows;
};

TEST(UnsayableRows, line_through_the_gap_is_cut_where_it_can_be_said_and_stays_on_its_way) {
  int shifted = 0;
  test::for_random_cases(40, [&](test::Random& random) {
    Sweep sweep(random.uniform(15, 40), random.uniform(52, 70));
    const auto motion = sweep.planner.plan(sweep.start, {}, sweep.rows.steps);
    ASSERT_TRUE(motion) << describe(motion.error().error);
    ASSERT_GT(motion->pieces.size(), 2U);
    for (const JointMove& piece : motion->pieces) {
      EXPECT_FALSE(WireTarget(sweep.robot).refusal({piece.q.data(), piece.q.size()}));
    }
    EXPECT_EQ(motion->pieces.back().q, motion->q_end);
    EXPECT_LT(sweep.farthest_off(*motion), RowPlanner::kWayTolerance * 1.05);
    shifted += sweep.unsayable_chords(motion->q_end) > 0 ? 1 : 0;
  });
  EXPECT_GE(shifted, 5) << "lines that needed it";
}

TEST(UnsayableRows, line_that_stays_in_the_gap_for_long_is_refused_and_not_left) {
  Sweep sweep(45.5, 50.5, 50);
  const auto motion = sweep.planner.plan(sweep.start, {}, sweep.rows.steps);
  ASSERT_FALSE(motion);
  EXPECT_EQ(motion.error().error.code, ErrorCode::kUnsendable) << describe(motion.error().error);
  ASSERT_TRUE(motion.error().way && motion.error().way->unsayable);
  const double share = motion.error().way->refusal.place.share;
  EXPECT_GT(share, 0);
  EXPECT_LT(share, 1);
  EXPECT_FALSE(motion.error().way->unsayable->nearest);
  EXPECT_TRUE(motion.error().way->proposal.move_j) << "one move from end to end can be said";
}

}  // namespace
}  // namespace sinew::program
