#include <gtest/gtest.h>

#include <numeric>

#include "sinew/control/path_motion.h"
#include "sinew/core/error_code.h"
#include "sinew/devices/axis_link/axis_link_settings.h"
#include "sinew/model/joint_lookup.h"
#include "sinew/program/formats/program_format.h"
#include "sinew/program/plans/row_planner.h"
#include "support/robots.h"

// `time=`: the whole motion takes so long, on every robot, or the shortest time that works is told.

namespace sinew::program {
namespace {

struct TimedCase {
  const char* robot;
  const char* row;
};

class TimedRow : public testing::TestWithParam<TimedCase> {};
INSTANTIATE_TEST_SUITE_P(
    Robots, TimedRow,
    testing::Values(TimedCase{"learm", "joint base=30deg shoulder=20deg"},
                    TimedCase{"learm", "line dz=-20mm"},
                    TimedCase{"bigrobotarm", "joint base=20deg elbow=60deg"},
                    TimedCase{"maxarm", "joint base=150deg"}, TimedCase{"maxarm", "line dz=-30mm"},
                    TimedCase{"maxarm", "arc via=20mm,-170mm,190mm x=40mm z=170mm"},
                    TimedCase{"hexapod", "joint leg1=d"}, TimedCase{"hexapod", "line dz=0.05mm"},
                    TimedCase{"robot-arm-2/link", "spline 250mm,0mm,600mm 260mm,40mm,580mm"}),
    [](const auto& test) { return "case_" + std::to_string(test.index); });

RobotModel timed_robot(const std::string& name) {
  if (name != "robot-arm-2/link") return test::robot(name);
  RobotModel robot = test::robot("robot-arm-2");
  robot.device.capability.motion = MotionKind::kStream;
  robot.device.capability.takes_speed = true;
  robot.device.capability.segment = std::chrono::milliseconds(20);
  robot.device.settings = AxisLinkDevice{};
  return robot;
}

JointVector timed_start(const RobotModel& robot) {
  if (robot.id == "robot-arm-2") return {0, from_deg(20), from_deg(-30), 0, from_deg(30), 0};
  if (robot.id == "learm") return {0, from_deg(10), from_deg(75), from_deg(20), 0};
  return home_joints(robot);
}

double pieces_time(const RowMotion& motion) {
  double sum = 0;
  for (const JointMove& piece : motion.pieces) sum += to_seconds(piece.duration);
  return sum;
}

TEST_P(TimedRow, takes_the_time_that_it_says_and_no_shorter_one_than_works) {
  const RobotModel robot = timed_robot(GetParam().robot);
  std::string row = GetParam().row;
  if (row.ends_with("=d")) row = "joint leg1=268.40mm leg4=268.33mm";
  const JointVector from = timed_start(robot);
  RowPlanner planner(robot);
  const auto plan = [&](const std::string& text) {
    const auto program = parse(text, "p", robot);
    EXPECT_TRUE(program) << (program ? "" : program.error()[0].message);
    return planner.plan(from, {}, program->steps);
  };
  const auto quickest = plan(row);
  ASSERT_TRUE(quickest) << describe(quickest.error().error);
  const auto refused = plan(row + " time=1ms");
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().error.code, ErrorCode::kSegmentTime);
  const double shortest = refused.error().error.limit;
  // A law that can be paused takes an eighth longer; told with three digits, rounded up.
  EXPECT_GT(shortest, 0.97 * pieces_time(*quickest));
  const double report = quickest->duration - quickest->arrival;
  EXPECT_LT(shortest, 1.25 * quickest->duration + std::abs(report) + 0.02);

  for (const double factor : {1.0, 1.3, 4.0, 17.0}) {
    const double time = factor * shortest;
    SCOPED_TRACE(time);
    const auto motion = plan(row + " time=" + std::to_string(time) + "s");
    ASSERT_TRUE(motion) << describe(motion.error().error);
    for (std::size_t j = 0; j < from.size(); ++j) {
      EXPECT_NEAR(motion->q_end[j], quickest->q_end[j], 1e-12);
    }
    const bool streams = robot.device.capability.motion == MotionKind::kStream;
    const auto delay = robot.device.settings->motion_delay();
    const double stops =
        streams ? 0 : static_cast<double>(motion->pieces.size() - 1) * to_seconds(delay.report);
    EXPECT_NEAR(pieces_time(*motion) + stops, time, 1e-3 * time);
    if (!streams) continue;
    // What a running cell follows, and may pause, takes as long.
    control::PathMotion path(planner.robot());
    ASSERT_FALSE(path.start(planner.motion().path, 1, motion->time));
    EXPECT_NEAR(path.duration(), time, 1e-3 * time);
    ASSERT_FALSE(path.start(planner.motion().path, 0.5, motion->time));
    EXPECT_GT(path.duration(), 1.2 * time) << "half the feed, and the whole acceleration";
  }
}

TEST(MotionTime, is_refused_beside_speeds_and_where_it_is_none) {
  const RobotModel& robot = test::robot("learm");
  const auto complaint = [&](const std::string& row) {
    const auto program = parse(row, "p", robot);
    return program ? std::string() : program.error()[0].message;
  };
  const std::string alone =
      "time= is of the whole motion, from stop to stop: without speed=, accel=, blend=";
  EXPECT_EQ(complaint("joint base=5deg time=2s speed=50%"), alone);
  EXPECT_EQ(complaint("line dz=5mm speed=20mm/s time=2s"), alone);
  EXPECT_EQ(complaint("move dz=5mm accel=20mm/s2 time=2s"), alone);
  EXPECT_EQ(complaint("line dz=5mm blend=2mm time=2s"), alone);
  EXPECT_EQ(complaint("joint base=5deg time=0s"), "time is above 0 and at most 24 h");
  EXPECT_EQ(complaint("home time=25h"), "'25h' ends in 'h', which is none of s, ms, min");
  EXPECT_EQ(complaint("joint base=5deg time=2s time=3s"), "'time' is named twice");
  EXPECT_EQ(complaint("home 2s"), "write how long it takes, as in time=2s");
  EXPECT_EQ(complaint("home time=4s"), "");
  EXPECT_EQ(parse("home time=4s", "p", test::robot("robot-arm-2")).error()[0].message,
            "this robot's home looks for its end stops, as long as it takes");
}

TEST(MotionTime, stands_at_the_end_of_its_row) {
  const auto text =
      program::format("line  time=2s x=200mm\nhome   time=3s\nnozzle 45deg time=1s\n", "p");
  ASSERT_TRUE(text);
  EXPECT_EQ(*text, "line x=200mm time=2s\nhome time=3s\nnozzle 45deg time=1s\n");
}

TEST(MotionTime, row_with_a_time_begins_and_ends_at_rest) {
  const RobotModel& robot = test::robot("learm");
  const auto program =
      parse("line dz=-20mm blend=5mm\nline dy=20mm time=3s\nline dz=20mm\n", "p", robot);
  ASSERT_TRUE(program);
  RowPlanner planner(robot);
  const auto first = planner.plan(timed_start(robot), {}, program->steps);
  ASSERT_TRUE(first);
  EXPECT_EQ(first->rows, 1u);
}

TEST(MotionTime, a_cells_motion_keeps_the_limits_that_its_rows_ask_for) {
  const RobotModel& robot = test::robot("learm");
  const auto duration = [&](const std::string& text) {
    const auto program = parse(text, "p", robot);
    RowPlanner planner(robot);
    EXPECT_TRUE(planner.plan(timed_start(robot), {}, program->steps));
    control::PathMotion path(planner.robot());
    EXPECT_FALSE(path.start(planner.motion().path));
    return path.duration();
  };
  EXPECT_GT(duration("velocity all=20%\njoint base=60deg"), 2 * duration("joint base=60deg"));
}

}  // namespace
}  // namespace sinew::program
