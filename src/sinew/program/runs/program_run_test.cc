#include "sinew/program/runs/program_run.h"

#include <gtest/gtest.h>

#include <cmath>

#include "sinew/core/error_code.h"
#include "sinew/core/units.h"
#include "sinew/devices/lsc/lsc_settings.h"
#include "sinew/model/joint_lookup.h"
#include "sinew/program/runs/plain_cell_test_support.h"
#include "support/robots.h"

namespace sinew::program {
namespace {

using Cell = PlainCell;

TEST(ProgramRun, streamed_motion_is_cut_into_even_segments_that_join_without_a_jump) {
  Cell cell("learm", "joint base=30deg elbow=-20deg\n");
  cell.go();
  ASSERT_EQ(cell.run.phase(), Phase::kDone);
  ASSERT_EQ(cell.run.records().size(), 1U);
  const auto& moves = cell.driver.taken_;
  ASSERT_GT(moves.size(), 3U);
  double last = 0;
  for (const JointMove& move : moves) {
    EXPECT_EQ(move.duration, moves[0].duration);
    EXPECT_LE(move.duration, cell.robot.device.capability.segment);
    const double dt = to_seconds(move.duration);
    EXPECT_LE(std::abs(move.q[0] - last), cell.robot.joints[0].velocity_max * dt * 1.001);
    last = move.q[0];
  }
  EXPECT_EQ(moves.back().q[0], from_deg(30));
  EXPECT_EQ(moves.back().q[2], from_deg(-20));
  EXPECT_EQ(moves.back().q[1], 0);
  EXPECT_EQ(moves.back().qd[0], 0);
  const double took = to_seconds(cell.run.records()[0].done - cell.run.records()[0].asked);
  const double report = to_seconds(cell.robot.device.settings->motion_delay().report);
  EXPECT_NEAR(took, cell.run.records()[0].duration - report, 0.01) << "this driver says so at once";
}

TEST(ProgramRun, point_to_point_device_gets_the_whole_move_at_once) {
  Cell cell("bigrobotarm", "joint J2=30deg\njoint J2=0deg speed=50%\n");
  cell.go();
  ASSERT_EQ(cell.run.phase(), Phase::kDone);
  ASSERT_EQ(cell.driver.taken_.size(), 2U);
  EXPECT_GT(cell.driver.taken_[1].duration, cell.driver.taken_[0].duration);
  EXPECT_EQ(cell.driver.taken_[1].qd, at(cell.robot, 0));
}

TEST(ProgramRun, loops_waits_and_tools_come_in_their_order) {
  Cell cell("learm", "loop 3\n loop 2\n  jaws 10mm\n end\n wait 0.5s\nend\n");
  cell.go();
  ASSERT_EQ(cell.run.phase(), Phase::kDone);
  EXPECT_EQ(cell.driver.tools_, 6);
  EXPECT_EQ(cell.run.records().size(), 9U);
  EXPECT_EQ(cell.run.records()[1].order->round, 2);
  EXPECT_EQ(cell.run.records()[1].order->rounds, 2);
  EXPECT_GE(cell.now - Instant{}, 1500ms);
  // Where the jaws are nobody knows the first time; then they stand there.
  const auto jaws = [&](std::optional<double> before) {
    return to_seconds(cell.robot.device.settings->tool_time(cell.robot, JawsTo{10e-3}, before));
  };
  EXPECT_NEAR(cell.run.plan().duration, 1.5 + jaws(std::nullopt) + 5 * jaws(10e-3), 1e-9);
  EXPECT_GT(jaws(std::nullopt), jaws(10e-3));
}

TEST(ProgramRun, home_goes_on_to_the_robots_home_from_where_homing_really_left_the_joints) {
  Cell cell("robot-arm-2", "home\njoint J1=10deg\n");
  cell.driver.lose();
  cell.driver.homed_ = 0.25;  // not what the robot's file calls home
  cell.go();
  ASSERT_EQ(cell.run.phase(), Phase::kDone);
  ASSERT_EQ(cell.driver.taken_.size(), 2U);
  EXPECT_EQ(cell.driver.taken_[0].q_start[0], 0.25);
  for (const double q : cell.driver.taken_[0].q) EXPECT_EQ(q, 0);
  EXPECT_EQ(cell.driver.taken_[1].q[0], from_deg(10));
  EXPECT_EQ(cell.driver.taken_[1].q[1], 0);
  EXPECT_EQ(cell.run.records().size(), 2U) << "the way home belongs to its row";
}

TEST(ProgramRun, home_goes_slowly_home_where_only_the_device_knows_where_the_search_ended) {
  Cell cell("robot-arm-2", "home\njoint J1=10deg\n");
  cell.driver.lose();
  cell.driver.homed_ = 0.25;
  cell.driver.homed_from_ = 0;
  cell.go();
  ASSERT_EQ(cell.run.phase(), Phase::kDone);
  ASSERT_EQ(cell.driver.taken_.size(), 2U);
  for (const double q : cell.driver.taken_[0].q) EXPECT_EQ(q, 0);
  EXPECT_GE(cell.driver.taken_[0].duration, from_seconds(first_move_duration(cell.robot)));
  EXPECT_EQ(cell.driver.taken_[1].q[0], from_deg(10));
  EXPECT_EQ(cell.run.records().size(), 2U) << "the way home belongs to its row";
}

TEST(ProgramRun, stop_on_the_way_home_ends_it) {
  Cell cell("robot-arm-2", "home\njoint J1=10deg\n");
  cell.driver.lose();
  cell.driver.homed_ = 0.25;
  cell.go(500ms);
  ASSERT_EQ(cell.driver.taken_.size(), 1U);
  cell.run.stop(cell.now);
  cell.go();
  EXPECT_EQ(cell.run.phase(), Phase::kStopped);
  EXPECT_EQ(cell.driver.taken_.size(), 1U);
}

TEST(ProgramRun, homing_that_leaves_no_position_moves_nothing_that_needs_one) {
  for (const char* row : {"joint J1=10deg\n", "move z=600mm\n"}) {
    Cell cell("robot-arm-2", std::string("home\n") + row);
    cell.driver.lose();
    cell.driver.homes_nowhere_ = true;
    cell.go();
    ASSERT_EQ(cell.run.phase(), Phase::kFailed) << row;
    EXPECT_EQ(cell.run.failure()->error.code, ErrorCode::kPositionUnknown);
    EXPECT_EQ(cell.run.failure()->line, 2);
    EXPECT_TRUE(cell.driver.taken_.empty());
  }
}

TEST(ProgramRun, from_nowhere_all_joints_must_be_named_and_move_slowly_in_one_piece) {
  Cell some("learm", "joint base=30deg\n");
  some.driver.lose();
  some.go();
  ASSERT_EQ(some.run.phase(), Phase::kFailed);
  EXPECT_EQ(some.run.failure()->error.code, ErrorCode::kPositionUnknown);
  EXPECT_TRUE(some.driver.taken_.empty());
  Cell all("learm", "joint J1=30deg J2=0deg J3=0deg J4=0deg J5=0deg\njoint J1=0deg\n");
  all.driver.lose();
  all.go();
  ASSERT_EQ(all.run.phase(), Phase::kDone);
  EXPECT_GE(all.driver.taken_[0].duration, 2s);
  EXPECT_GT(all.driver.taken_.size(), 2U) << "the second move is streamed";
}

TEST(ProgramRun, arm_that_hangs_beyond_a_limit_comes_back_in_as_any_motion_does) {
  RobotModel robot = test::robot("learm");
  auto& board = robot.device.settings.get<LscDevice>();
  board.profile = LscProfile::kBus;
  for (LscServo& servo : board.servos) {
    servo.centre = 500;
    servo.units_per_rad = std::copysign(750 / kPi, servo.units_per_rad);
    servo.lower = 125;
    servo.upper = 875;
  }
  Cell cell(robot, "joint J1=0deg J2=20deg J3=0deg J4=0deg J5=0deg\njoint J1=30deg\n");
  cell.driver.positions_[1].q = from_deg(99);
  cell.go();
  ASSERT_EQ(cell.run.phase(), Phase::kDone);
  const auto& taken = cell.driver.taken_;
  double before = from_deg(99);
  for (const JointMove& piece : taken) {
    EXPECT_LE(piece.duration, cell.robot.device.capability.segment);
    EXPECT_LE(piece.q[1], before);
    before = piece.q[1];
  }
  EXPECT_EQ(taken.back().q[0], from_deg(30));
}

/// Its way in leads through its stand, by the model; but there it lies.
TEST(ProgramRun, limp_arm_whose_way_in_would_hit_something_comes_back_slowly_in_one_piece) {
  Cell cell("learm", "joint J1=30deg J2=5deg J3=10deg J4=20deg J5=0deg\njoint J1=0deg\n");
  const double degrees[] = {12, 100.3, 100.3, -10, -10};
  for (std::size_t j = 0; j < 5; ++j) cell.driver.positions_[j].q = from_deg(degrees[j]);
  cell.go();
  ASSERT_EQ(cell.run.phase(), Phase::kDone);
  EXPECT_GE(cell.driver.taken_[0].duration, 2s);
  EXPECT_EQ(cell.driver.taken_[0].q[1], from_deg(5));
  // Inside its limits a contact is a refusal, and outside every other refusal is one.
  const auto rows = parse("joint J1=30deg J2=5deg J3=10deg J4=20deg J5=0deg", "", cell.robot);
  ASSERT_TRUE(rows);
  JointVector outside = home_joints(cell.robot);
  const Refusal contact{1, {ErrorCode::kCollision}, std::nullopt};
  EXPECT_FALSE(slow_way_back(rows->steps[0], outside, contact, cell.robot));
  outside[1] = from_deg(100);
  EXPECT_TRUE(slow_way_back(rows->steps[0], outside, contact, cell.robot));
  const Refusal other{1, {ErrorCode::kJointLimit}, std::nullopt};
  EXPECT_FALSE(slow_way_back(rows->steps[0], outside, other, cell.robot));
}

TEST(ProgramRun, arm_that_hangs_beyond_a_limit_refuses_a_line_with_a_row_that_would_work) {
  Cell cell("learm", "line z=10mm\n");
  cell.driver.positions_[1].q = from_deg(99);
  cell.go();
  ASSERT_EQ(cell.run.phase(), Phase::kFailed);
  EXPECT_EQ(cell.run.failure()->error.code, ErrorCode::kJointLimit);
  EXPECT_NEAR(cell.run.failure()->error.measured, from_deg(99), 1e-12);
  ASSERT_TRUE(cell.run.failure()->way);
  ASSERT_TRUE(cell.run.failure()->way->proposal.back_inside);
  EXPECT_LT((*cell.run.failure()->way->proposal.back_inside)[1], from_deg(90));
  EXPECT_TRUE(cell.driver.taken_.empty());
}

TEST(ProgramRun, limit_is_refused_with_its_line_before_anything_moves) {
  Cell cell("learm", "joint base=10deg\njoint base=91deg\n");
  cell.go();
  ASSERT_EQ(cell.run.phase(), Phase::kFailed);
  EXPECT_EQ(cell.run.failure()->line, 2);
  EXPECT_EQ(cell.run.failure()->error.code, ErrorCode::kJointLimit);
  EXPECT_TRUE(cell.driver.taken_.empty());
}

TEST(ProgramRun, stop_ends_a_stream_a_wait_and_an_opening) {
  Cell moving("learm", "joint base=80deg\n");
  moving.go(300ms);
  const std::size_t sent = moving.driver.taken_.size();
  moving.run.stop(moving.now);
  moving.step();
  EXPECT_EQ(moving.driver.moves_.size(), 0U) << "in the same cycle";
  moving.step();
  EXPECT_EQ(moving.run.phase(), Phase::kStopped);
  EXPECT_EQ(moving.driver.taken_.size(), sent);
  Cell waiting("learm", "wait 60s\n");
  waiting.go(300ms);
  waiting.run.stop(waiting.now);
  EXPECT_EQ(waiting.run.phase(), Phase::kStopped);
  Cell opening("learm", "joint base=80deg\n");
  opening.driver.in_doubt_ = true;
  opening.start();
  ASSERT_EQ(opening.run.phase(), Phase::kOpening);
  opening.run.stop(opening.now);
  opening.step();
  EXPECT_EQ(opening.run.phase(), Phase::kStopped);
  EXPECT_TRUE(opening.driver.taken_.empty());
}

TEST(ProgramRun, failure_of_the_driver_ends_the_run_with_its_line_and_stops_what_is_queued) {
  Cell cell("learm", "wait 0.1s\njoint base=80deg\n");
  cell.go(500ms);
  cell.driver.tell(Kind::kFailed, {ErrorCode::kDeviceSilent});
  cell.step();
  ASSERT_EQ(cell.run.phase(), Phase::kFailed);
  EXPECT_EQ(cell.run.failure()->line, 2);
  EXPECT_TRUE(cell.driver.moves_.empty());
}

TEST(ProgramRun, silent_device_fails_the_opening_after_its_limit) {
  Cell cell("learm", "wait 0.1s\n");
  cell.driver.in_doubt_ = true;
  cell.go(5s);
  EXPECT_EQ(cell.run.phase(), Phase::kOpening);
  cell.go();
  EXPECT_EQ(cell.now, Instant{} + 5s + 2ms);
  ASSERT_EQ(cell.run.phase(), Phase::kFailed);
  EXPECT_EQ(cell.run.failure()->error.code, ErrorCode::kDeviceSilent);
}

TEST(ProgramRun, driver_that_gave_up_while_opening_is_not_waited_for) {
  Cell cell("learm", "wait 0.1s\n");
  cell.driver.in_doubt_ = true;
  cell.start();
  const Error silent{ErrorCode::kDeviceSilent, -1, 1, 1};
  cell.driver.tell(Kind::kFailed, silent);
  cell.step();
  ASSERT_EQ(cell.run.phase(), Phase::kOpening) << "it asks again";
  cell.driver.gave_up_ = silent;
  cell.driver.tell(Kind::kFailed, silent);
  cell.step();
  ASSERT_EQ(cell.run.phase(), Phase::kFailed);
  EXPECT_EQ(cell.run.failure()->error, silent);
}

TEST(ProgramRun, notices_are_kept_with_their_time_and_line_and_all_are_counted) {
  Cell cell("learm", "wait 1s\njoint base=1deg\nwait 1s\n");
  cell.start();
  const Error moved{ErrorCode::kMovedUnasked, 1, 2.0, 1.0};
  cell.now += 300ms;
  cell.driver.tell(Kind::kNotice, moved);
  cell.step();
  ASSERT_EQ(cell.run.notices().size(), 1U);
  EXPECT_EQ(cell.run.notices()[0].at, cell.now);
  EXPECT_EQ(cell.run.notices()[0].line, 1);
  EXPECT_EQ(cell.run.notices()[0].error, moved);
  EXPECT_EQ(cell.run.phase(), Phase::kRunning) << "nothing is broken by it";
  for (int i = 0; i < 500; ++i) {
    cell.driver.tell(Kind::kNotice, moved);
    cell.step();
  }
  EXPECT_EQ(cell.run.notices().size(), Run::kNoticesMax);
  EXPECT_EQ(cell.run.notices_told(), 501U);
  cell.run.stop(cell.now);
  cell.driver.tell(Kind::kNotice, moved);
  cell.step();
  EXPECT_EQ(cell.run.notices_told(), 502U) << "also what a stop shows";
}

TEST(ProgramRun, each_motion_says_where_it_was_planned_from) {
  Cell streamed("learm", "joint base=30deg\njoint base=0deg\n");
  streamed.go();
  const auto& moves = streamed.driver.taken_;
  std::vector<double> starts;
  for (const JointMove& move : moves) {
    if (!move.q_start.empty()) starts.push_back(move.q_start[0]);
  }
  EXPECT_EQ(starts, (std::vector<double>{0, from_deg(30)})) << "a segment behind another has none";
  Cell whole("bigrobotarm", "joint J2=30deg\njoint J2=0deg\n");
  whole.go();
  ASSERT_EQ(whole.driver.taken_.size(), 2U);
  EXPECT_EQ(whole.driver.taken_[1].q_start[1], from_deg(30));
}

TEST(ProgramRun, an_order_waits_for_a_driver_that_is_in_doubt_as_long_as_for_one_that_opens) {
  for (const bool recovers : {true, false}) {
    Cell cell("bigrobotarm", "wait 1s\njoint J2=30deg\n");
    cell.go(500ms);
    cell.driver.in_doubt_ = true;
    const Error silent{ErrorCode::kDeviceSilent, -1, 0.45, 0.45};
    cell.driver.tell(Kind::kNotice, silent);
    const auto run_to = [&](Duration end) {
      for (; cell.now < Instant{} + end && !cell.run.finished(); cell.now += 1ms) {
        cell.driver.poll(cell.now);
        cell.step();
      }
    };
    run_to(1s + 5s - 510ms);
    ASSERT_EQ(cell.run.phase(), Phase::kRunning);
    EXPECT_TRUE(cell.driver.taken_.empty());
    cell.driver.in_doubt_ = !recovers;
    run_to(1h);
    ASSERT_EQ(cell.run.phase(), recovers ? Phase::kDone : Phase::kFailed);
    if (recovers) continue;
    EXPECT_EQ(cell.run.failure()->line, 2);
    EXPECT_EQ(cell.run.failure()->error, silent);
  }
}

TEST(ProgramRun, homing_is_in_the_plan_and_in_the_progress_with_its_bound) {
  Cell cell("robot-arm-2", "wait 10s\nhome\nloop 2\nhome\nend\n");
  Homing homing;
  for (int i = 1; i <= 6; ++i) homing.times.push_back(10 * i);
  cell.run.expect_homing(homing);
  cell.start();
  const Plan& plan = cell.run.plan();
  EXPECT_EQ(plan.duration, 10);
  EXPECT_EQ(plan.homing_max, 3 * 210);
  EXPECT_EQ(std::get<HomeOrder>(plan.orders[1].what).duration_max, 210);
  EXPECT_EQ(cell.run.progress(cell.now), 0);
  EXPECT_NEAR(cell.run.progress(cell.now + 10s), 10.0 / 640, 1e-12);
  cell.driver.homes_by_itself_ = false;
  cell.now += 10s;
  cell.step();
  EXPECT_NEAR(cell.run.progress(cell.now + 105s), 115.0 / 640, 1e-12);
  EXPECT_NEAR(cell.run.progress(cell.now + 1h), 220.0 / 640, 1e-12) << "no more than its bound";
  cell.driver.homes_by_itself_ = true;
  cell.driver.tell(Kind::kDone);
  cell.go();
  ASSERT_EQ(cell.run.phase(), Phase::kDone);
  EXPECT_EQ(cell.run.records()[1].duration, 210);
  EXPECT_EQ(cell.run.progress(cell.now), 1);
}

TEST(ProgramPlan, tools_and_homing_are_checked_with_everything_else) {
  const struct {
    const char* robot;
    const char* text;
    std::optional<ErrorCode> refusal;
  } kCases[] = {
      {"learm", "jaws 60mm", std::nullopt},
      {"learm", "jaws 60.1mm", ErrorCode::kJawWidth},
      {"learm", "jaws -1mm", ErrorCode::kJawWidth},
      {"learm", "gripper 10deg", ErrorCode::kToolNotFitted},
      {"learm", "home", std::nullopt},
      {"bigrobotarm", "home", std::nullopt},
      {"maxarm", "home", std::nullopt},
      {"hexapod", "home", std::nullopt},
      {"bigrobotarm", "gripper 180deg", std::nullopt},
      {"bigrobotarm", "gripper on", std::nullopt},
      {"learm", "gripper on", ErrorCode::kToolNotFitted},
      {"bigrobotarm", "gripper 181deg", ErrorCode::kToolAngle},
      {"bigrobotarm", "jaws 1mm", ErrorCode::kToolNotFitted},
      {"maxarm", "suction on", std::nullopt},
      {"maxarm", "nozzle 180deg time=1s", std::nullopt},
      {"maxarm", "nozzle 181deg time=1s", ErrorCode::kToolAngle},
      {"maxarm", "nozzle -1deg time=1s", ErrorCode::kToolAngle},
      {"hexapod", "suction off", ErrorCode::kToolNotFitted},
      {"robot-arm-2", "home", std::nullopt},
  };
  for (const auto& c : kCases) {
    const RobotModel& robot = test::robot(c.robot);
    const auto plan = make_plan(*parse(c.text, "p", robot), robot, at(robot, 0));
    ASSERT_EQ(plan.has_value(), !c.refusal) << c.robot << " " << c.text;
    if (!plan) {
      EXPECT_EQ(plan.error().error.code, *c.refusal) << c.robot << " " << c.text;
    }
  }
}

TEST(ProgramPlan, speed_counts_only_where_the_device_can_be_asked_for_it) {
  for (const auto& [name, heard] : {std::pair{"learm", true}, {"robot-arm-2", false}}) {
    const RobotModel& robot = test::robot(name);
    const auto full = make_plan(*parse("joint J2=20deg", "p", robot), robot, at(robot, 0));
    const auto half =
        make_plan(*parse("joint J2=20deg speed=10%", "p", robot), robot, at(robot, 0));
    ASSERT_TRUE(full && half);
    EXPECT_EQ(half->duration > full->duration, heard) << name;
    EXPECT_EQ(half->duration == full->duration, !heard) << name;
  }
}

TEST(ProgramPlan, endless_programs_are_refused) {
  const RobotModel& robot = test::robot("learm");
  for (const char* text :
       {"loop 10000\nloop 10000\njaws 1mm\nend\nend", "loop 10000\nloop 10000\nend\nend"}) {
    const auto plan = make_plan(*parse(text, "p", robot), robot, at(robot, 0));
    ASSERT_FALSE(plan) << text;
    EXPECT_EQ(plan.error().error.code, ErrorCode::kProgramTooLong);
  }
}

TEST(ProgramRun, if_takes_the_branch_that_what_is_measured_says) {
  constexpr const char* kHighText =
      "joint base=30deg\nif base>20deg\n jaws 10mm\nelse\n wait 5s\n wait 6s\nend\njaws 20mm\n";
  Cell high("learm", kHighText);
  high.go();
  ASSERT_EQ(high.run.phase(), Phase::kDone);
  EXPECT_EQ(high.driver.tools_, 2);
  ASSERT_EQ(high.run.records().size(), 4U);
  EXPECT_EQ(high.run.records()[1].holds, true);
  EXPECT_LT(high.now - Instant{}, 10s) << "nothing waited";
  EXPECT_NEAR(high.run.progress(high.now), 1, 1e-9) << "what is not taken counts as done";
  std::string low = kHighText;
  Cell other("learm", low.replace(low.find("30deg"), 5, "10deg"));
  other.go();
  ASSERT_EQ(other.run.phase(), Phase::kDone);
  EXPECT_EQ(other.driver.tools_, 1);
  EXPECT_EQ(other.run.records()[1].holds, false);
  EXPECT_GE(other.now - Instant{}, 11s);
  EXPECT_NEAR(other.run.progress(other.now), 1, 1e-9);
}

TEST(ProgramRun, rows_behind_an_if_are_planned_from_where_its_branch_has_ended) {
  Cell cell("learm",
            "if base>20deg\n joint base=5deg\nelse\n joint base=-15deg\nend\n"
            "joint d.base=10deg\n");
  cell.go();
  ASSERT_EQ(cell.run.phase(), Phase::kDone);
  EXPECT_EQ(std::get<MoveOrder>(cell.run.plan().orders.back().what).starts, 2U);
  EXPECT_NEAR(cell.driver.taken_.back().q[0], from_deg(-5), 1e-12);
  ASSERT_EQ(cell.run.records().size(), 3U);
  EXPECT_NEAR((*cell.run.records()[2].q_start)[0], from_deg(-15), 1e-12);
}

TEST(ProgramRun, condition_on_the_tool_is_where_the_measured_joints_have_it) {
  Cell cell("learm", "if z>10m\n jaws 10mm\nelse\n if z>-10m\n  jaws 5mm\n  jaws 6mm\n end\nend\n");
  cell.go();
  ASSERT_EQ(cell.run.phase(), Phase::kDone);
  EXPECT_EQ(cell.driver.tools_, 2);
}

TEST(ProgramRun, supply_counts_where_somebody_tells_it) {
  Cell silent("learm", "if supply>7V\n jaws 10mm\nend\n");
  silent.go();
  ASSERT_EQ(silent.run.phase(), Phase::kFailed);
  EXPECT_EQ(silent.run.failure()->error.code, ErrorCode::kNotMeasured);
  EXPECT_EQ(silent.run.failure()->line, 1);
  Cell low("learm", "wait until supply>7V for 3s\njaws 10mm\n");
  double volts = 6;
  low.run.measure_by([&] { return DriverHealth{.supply_volts = volts}; });
  low.go(2s);
  EXPECT_FALSE(low.run.finished());
  volts = 8;
  low.go(2100ms);
  ASSERT_EQ(low.run.phase(), Phase::kDone);
  EXPECT_EQ(low.driver.tools_, 1);
}

TEST(ProgramRun, what_the_jaws_hold_decides) {
  const char* rows = "jaws 0mm\nif jaws>5mm\n jaws 60mm\n jaws 0mm\nend\n";
  for (const double held : {0.02, 0.001}) {
    Cell cell("learm", rows);
    cell.run.measure_by([&] { return DriverHealth{.jaws_width = held}; });
    cell.go();
    ASSERT_EQ(cell.run.phase(), Phase::kDone);
    EXPECT_EQ(cell.driver.tools_, held > 0.005 ? 3 : 1);
  }
  Cell silent("learm", rows);
  silent.run.measure_by([] { return DriverHealth{.supply_volts = 7.4}; });
  silent.go();
  ASSERT_EQ(silent.run.phase(), Phase::kFailed) << "what is not measured never counts as no";
  EXPECT_EQ(silent.run.failure()->error.code, ErrorCode::kNotMeasured);
}

TEST(ProgramRun, wait_until_ends_the_run_where_its_condition_does_not_come) {
  Cell cell("learm", "wait until base>20deg for 3s\njaws 10mm\n");
  cell.go();
  ASSERT_EQ(cell.run.phase(), Phase::kFailed);
  EXPECT_EQ(cell.run.failure()->error.code, ErrorCode::kNotInTime);
  EXPECT_EQ(cell.run.failure()->error.limit, 3);
  EXPECT_EQ(cell.driver.tools_, 0);
  Cell paused("learm", "wait until supply>7V for 3s\njaws 10mm\n");
  paused.run.measure_by([&] { return DriverHealth{.supply_volts = 6.0}; });
  paused.go(1s);
  paused.run.pause();
  paused.go(60s);
  EXPECT_FALSE(paused.run.finished()) << "nobody has to hurry while it is paused";
  paused.run.resume();
  paused.go(62s);
  EXPECT_FALSE(paused.run.finished());
  paused.go(64s);
  EXPECT_EQ(paused.run.phase(), Phase::kFailed);
}

TEST(ProgramRun, progress_and_elapsed_time_stand_while_it_is_held) {
  Cell cell("learm", "joint base=80deg\nwait 1s\njoint base=0deg\n");
  cell.run.make_changeable();
  const auto holds = [&](Instant until) {
    cell.run.pause();
    cell.go(until - Instant{});
    const double progress = cell.run.progress(cell.now);
    const double elapsed = cell.run.elapsed(cell.now);
    cell.go(until - Instant{} + 60s);
    EXPECT_FALSE(cell.run.finished());
    EXPECT_DOUBLE_EQ(cell.run.progress(cell.now), progress);
    EXPECT_DOUBLE_EQ(cell.run.elapsed(cell.now), elapsed);
    cell.run.resume();
  };
  cell.go(400ms);
  EXPECT_EQ(cell.run.records().size(), 0U);
  holds(Instant{} + 1s);
  cell.go();
  ASSERT_EQ(cell.run.phase(), Phase::kDone);
  EXPECT_LT(cell.run.elapsed(cell.now), cell.run.plan().duration + 3);
}

TEST(ProgramRun, wait_settled_lasts_until_no_joint_moves_any_more) {
  Cell cell("learm", "wait settled for 20s\njaws 10mm\n");
  for (JointPosition& position : cell.driver.positions_) {
    position.quality = PositionQuality::kMeasured;
  }
  cell.run.start(cell.now);
  for (int i = 0; i < 1000; ++i) {  // it swings for a second
    cell.driver.positions_[1].q = from_deg(i % 100 < 50 ? 0.5 : -0.5);
    cell.driver.positions_[1].lower = cell.driver.positions_[1].upper = cell.driver.positions_[1].q;
    cell.driver.poll(cell.now);
    cell.step();
    cell.now += 1ms;
    ASSERT_EQ(cell.driver.tools_, 0);
  }
  cell.go(1140ms);
  EXPECT_FALSE(cell.run.finished()) << "a fifth of a second of rest is wanted";
  cell.go(1400ms);
  EXPECT_EQ(cell.run.phase(), Phase::kDone);
}

TEST(ProgramRun, step_back_returns_to_where_the_last_order_began_and_does_it_anew) {
  Cell cell("learm", "joint base=30deg\njoint base=10deg\njoint base=-10deg\n");
  cell.run.single_step(true);
  cell.go(30s);
  cell.run.resume();
  cell.go(60s);
  ASSERT_TRUE(cell.run.paused());
  ASSERT_EQ(cell.run.records().size(), 2U);
  const std::size_t before = cell.driver.taken_.size();
  ASSERT_TRUE(cell.run.step_back(cell.now));
  EXPECT_FALSE(cell.run.step_back(cell.now)) << "one at a time";
  cell.go(90s);
  ASSERT_GT(cell.driver.taken_.size(), before);
  EXPECT_NEAR(cell.driver.taken_.back().q[0], from_deg(30), 1e-12);
  EXPECT_EQ(cell.run.records().size(), 1U);
  EXPECT_TRUE(cell.run.paused());
  ASSERT_TRUE(cell.run.step_back(cell.now));
  cell.go(120s);
  EXPECT_NEAR(cell.driver.taken_.back().q[0], 0, 1e-12);
  const auto begun = cell.run.step_back(cell.now);
  ASSERT_FALSE(begun);
  EXPECT_EQ(begun.error().error.code, ErrorCode::kAtBeginning);
  cell.run.single_step(false);
  cell.run.resume();
  cell.go();
  ASSERT_EQ(cell.run.phase(), Phase::kDone);
  EXPECT_EQ(cell.run.records().size(), 3U);
  EXPECT_NEAR(cell.driver.taken_.back().q[0], from_deg(-10), 1e-12);
}

TEST(ProgramRun, pause_and_resume_while_jaws_move_take_nothing_from_the_next_pause) {
  Cell cell("learm", "jaws 40mm\njaws 5mm\njoint base=80deg\n");
  cell.run.make_changeable();
  while (cell.driver.tools_ == 0) cell.go(cell.now - Instant{} + 1ms);
  cell.run.pause();
  cell.run.resume();
  while (cell.driver.taken_.empty()) cell.go(cell.now - Instant{} + 1ms);
  cell.go(cell.now - Instant{} + 300ms);
  cell.run.pause();
  cell.go(cell.now - Instant{} + 30s);
  EXPECT_TRUE(cell.run.paused());
  EXPECT_FALSE(cell.run.finished());
  cell.run.resume();
  cell.go();
  EXPECT_EQ(cell.run.phase(), Phase::kDone);
}

TEST(ProgramRun, step_back_can_be_paused) {
  Cell cell("learm", "joint base=10deg\njoint base=80deg\njoint base=70deg\n");
  cell.run.make_changeable();
  cell.run.single_step(true);
  cell.go(30s);
  cell.run.resume();
  cell.go(60s);
  ASSERT_EQ(cell.run.records().size(), 2U);
  ASSERT_TRUE(cell.run.step_back(cell.now));
  cell.go(cell.now - Instant{} + 100ms);
  ASSERT_TRUE(cell.run.steps_back());
  EXPECT_FALSE(cell.run.stands_held());
  cell.run.pause();
  cell.go(cell.now - Instant{} + 30s);
  EXPECT_TRUE(cell.run.stands_held());
  EXPECT_TRUE(cell.run.steps_back()) << "it is on its way back yet";
  cell.run.single_step(false);
  cell.run.resume();
  cell.go(cell.now - Instant{} + 30s);
  EXPECT_FALSE(cell.run.steps_back());
  EXPECT_TRUE(cell.run.paused()) << "where a step back ends";
  cell.run.resume();
  cell.go();
  EXPECT_EQ(cell.run.phase(), Phase::kDone);
  EXPECT_NEAR(cell.driver.taken_.back().q[0], from_deg(70), 1e-12);
}

TEST(ProgramRun, step_back_undoes_no_tool_and_goes_back_through_waits) {
  Cell cell("learm", "joint base=30deg\nwait 1s\njaws 10mm\nwait 1s\n");
  cell.run.single_step(true);
  EXPECT_FALSE(cell.run.step_back(cell.now)) << "it has not begun";
  for (int order = 0; order < 3; ++order) {
    cell.go(cell.now - Instant{} + 30s);
    if (order < 2) cell.run.resume();
  }
  ASSERT_EQ(cell.run.records().size(), 3U);
  const auto back = cell.run.step_back(cell.now);
  ASSERT_FALSE(back);
  EXPECT_EQ(back.error().error.code, ErrorCode::kNotUndone);
  EXPECT_EQ(back.error().line, 3);
  Cell waits("learm", "joint base=30deg\nwait 1s\njaws 10mm\n");
  waits.run.single_step(true);
  waits.go(30s);
  waits.run.resume();
  waits.go(60s);
  ASSERT_EQ(waits.run.records().size(), 2U);
  ASSERT_TRUE(waits.run.step_back(waits.now));
  EXPECT_EQ(waits.run.records().size(), 1U) << "nothing had to move";
  ASSERT_TRUE(waits.run.step_back(waits.now));
  waits.go(90s);
  EXPECT_NEAR(waits.driver.taken_.back().q[0], 0, 1e-12);
}

TEST(ProgramRun, feed_makes_every_motion_of_a_streaming_device_longer_and_none_another_way) {
  Cell whole("learm", "joint base=30deg elbow=-20deg\n");
  whole.run.make_changeable();
  whole.go();
  Cell slow("learm", "joint base=30deg elbow=-20deg\n");
  slow.run.make_changeable();
  slow.run.feed(0.25);
  slow.go();
  ASSERT_EQ(whole.run.phase(), Phase::kDone);
  ASSERT_EQ(slow.run.phase(), Phase::kDone);
  const auto took = [](const Cell& cell) {
    const Record& record = cell.run.records()[0];
    return to_seconds(record.done - record.asked);
  };
  EXPECT_GT(took(slow), 1.3 * took(whole)) << "limits of speed at a quarter, the others whole";
  EXPECT_LT(took(slow), 4.1 * took(whole));
  EXPECT_EQ(slow.driver.taken_.back().q[0], whole.driver.taken_.back().q[0]);
  for (const JointMove& move : slow.driver.taken_) {
    EXPECT_NEAR(move.q[2], -move.q[0] * 2 / 3, 1e-9) << "straight in joint space";
  }
  const double predicted = slow.run.records()[0].duration;
  EXPECT_NEAR(took(slow), predicted, 0.05 * predicted + 0.1);
}

}  // namespace
}  // namespace sinew::program
