#include "sinew/devices/grbl/grbl_driver.h"

#include <gtest/gtest.h>

#include "sinew/core/error_code.h"
#include "sinew/devices/grbl/grbl_driver_facts.h"
#include "sinew/devices/grbl/grbl_test_cell.h"
#include "support/property.h"

namespace sinew {
namespace {

using namespace std::chrono_literals;
using test::grbl_robot;
using test::GrblCell;
using test::kGrblStep;
using Kind = DriverEvent::Kind;

TEST(GrblDriver, opens_behind_a_reset_and_knows_no_place_by_itself) {
  GrblCell cell(grbl_robot(), {}, false);
  cell.driver.open(cell.now);
  EXPECT_EQ(cell.driver.state(), DriverState::kOpening);
  EXPECT_TRUE(cell.run_until(DriverState::kReady, 2s));
  EXPECT_EQ(cell.count(Kind::kReady), 1U);
  EXPECT_EQ(cell.driver.positions()[2].quality, PositionQuality::kLost);
  EXPECT_FALSE(cell.driver.wants_move(cell.now));
  const auto refused = cell.driver.move({{0.1, 0, 0}, {0, 0, 0}, 1s, {}}, cell.now);
  EXPECT_EQ(refused.error().code, ErrorCode::kPositionUnknown);
  cell.declare();
  EXPECT_EQ(cell.driver.positions()[2].quality, PositionQuality::kCommanded);
}

TEST(GrblDriver, a_streamed_motion_arrives_in_its_time_and_each_piece_is_done_once) {
  GrblCell cell;
  auto motion = cell.motion_to({1, -0.5, 0.25}, 1.5);
  cell.run(motion);
  EXPECT_EQ(cell.driver.state(), DriverState::kReady);
  EXPECT_NEAR(to_seconds(cell.now - motion.begun), 1.5, 0.06);
  EXPECT_EQ(cell.count(Kind::kDone), 30U);
  EXPECT_EQ(cell.events.size(), 30U);
  EXPECT_NEAR(cell.q(0), 1, kGrblStep);
  EXPECT_NEAR(cell.q(1), -0.5, kGrblStep);
  EXPECT_LE(cell.fastest, 1.0);
}

/// Else a journal would have to reserve more and more of a motion until the next status.
TEST(GrblDriver, between_two_reports_a_joint_is_on_the_lines_that_the_board_has) {
  GrblCell cell;
  auto motion = cell.motion_to({1, -0.5, 0.25}, 1.5);
  const double piece = kPi / 2 / 1.5 * 0.05;  // rad, of a piece at the highest speed
  while (motion.next <= motion.segments) {
    cell.feed(motion);
    cell.step();
    const JointPosition& joint = cell.driver.positions()[0];
    ASSERT_GE(joint.lower, joint.q - piece - 2 * kGrblStep);
    ASSERT_GE(joint.lower, -2 * kGrblStep);
    ASSERT_LE(joint.upper, 1 + 2 * kGrblStep);
  }
  EXPECT_GT(cell.q(0), 0.5);
}

/// Each joint to and fro at its own pace: reports come before and behind the turns.
TEST(GrblDriver, where_a_path_turns_each_position_holds_the_truth) {
  test::for_random_cases(150, [](test::Random& random) {
    const auto joints = static_cast<std::size_t>(random.integer(1, 6));
    GrblCell cell(grbl_robot(joints));
    std::vector<double> rate, way;
    for (std::size_t i = 0; i < joints; ++i) {
      const double w = random.uniform(2, 10);  // rad/s
      const double most = std::min({from_deg(80) / w, from_deg(350) / (w * w), 0.6});
      rate.push_back(w);
      way.push_back(most * random.uniform(0.2, 0.95));
    }
    constexpr int kPieces = 80;
    for (int k = 1; k <= kPieces && !::testing::Test::HasFailure();) {
      cell.step();
      if (!cell.driver.wants_move(cell.now)) continue;
      JointMove piece{.q = {}, .qd = {}, .duration = 50ms};
      for (std::size_t i = 0; i < joints; ++i) {
        const double turn = rate[i] * 0.05 * k;
        piece.q.push_back(way[i] * (1 - std::cos(turn)));
        piece.qd.push_back(k == kPieces ? 0 : way[i] * rate[i] * std::sin(turn));
      }
      // The last one may end too fast for its joints.
      if (!cell.driver.move(piece, cell.now)) return;
      ++k;
    }
    cell.run_for(500ms);
  });
}

TEST(GrblDriver, stop_brakes_on_the_path_and_the_position_stays_known) {
  GrblCell cell;
  auto motion = cell.motion_to({1, -0.5, 0.25}, 1.5);
  cell.run(motion, 700ms);
  const std::size_t accepted = motion.next - 1;
  cell.driver.stop(cell.now);
  EXPECT_EQ(cell.driver.state(), DriverState::kStopping);
  EXPECT_TRUE(cell.run_until(DriverState::kReady, 2s));
  EXPECT_EQ(cell.count(Kind::kDone) + cell.count(Kind::kStopped), accepted);
  const double there = cell.q(0);
  EXPECT_GT(there, 0.3);
  EXPECT_LT(there, 0.8);
  EXPECT_NEAR(cell.q(1), -there / 2, 2 * kGrblStep);
  EXPECT_NEAR(cell.driver.positions()[0].q, there, kGrblStep);
  auto back = cell.motion_to({0, 0, 0}, 1.5);
  cell.run(back);
  EXPECT_NEAR(cell.q(0), 0, kGrblStep);
}

TEST(GrblDriver, a_stop_of_nothing_is_told_and_nothing_is_sent) {
  GrblCell cell;
  const auto before = cell.driver.health().requests;
  cell.driver.stop(cell.now);
  cell.run_for(5ms);
  EXPECT_EQ(cell.count(Kind::kStopped), 1U);
  EXPECT_EQ(cell.driver.state(), DriverState::kReady);
  EXPECT_LE(cell.driver.health().requests, before + 1);
}

TEST(GrblDriver, long_motions_keep_their_time_and_six_axes_fit_the_wire) {
  GrblCell cell(grbl_robot(6));
  for (const double seconds : {0.4, 1.0, 3.0, 6.0}) {
    const double way = std::min(1.2, 0.35 * seconds * from_deg(90));
    auto motion = cell.motion_to({way, -way, way / 2, -way / 3, way, way / 7}, seconds);
    cell.run(motion);
    EXPECT_NEAR(to_seconds(cell.now - motion.begun), seconds, 0.08) << seconds;
    EXPECT_NEAR(cell.q(5), way / 7, kGrblStep);
    auto back = cell.motion_to({0, 0, 0, 0, 0, 0}, 6);
    cell.run(back);
  }
  EXPECT_FALSE(cell.refused);
  EXPECT_LE(cell.fastest, 1.0);
  EXPECT_EQ(cell.machine.truth().bytes_lost, 0U);
}

TEST(GrblDriver, a_motion_that_comes_back_along_itself_does_not_run_dry) {
  GrblCell cell;
  // There and back within what is sent ahead, at 0.7 of the joint's acceleration.
  constexpr double kWay = 0.02;
  const auto feed = [&](double q, double qd) {
    for (int i = 0; i < 5000 && !cell.driver.wants_move(cell.now); ++i) cell.step();
    const auto taken = cell.driver.move({{q, 0, 0}, {qd, 0, 0}, 50ms, {}}, cell.now);
    ASSERT_TRUE(taken);
  };
  for (int turn = 0; turn < 20; ++turn) {
    for (int k = 1; k <= 8; ++k) {
      const double u = 2 * kPi * k / 8;
      feed(kWay * (1 - std::cos(u)), turn == 19 && k == 8 ? 0 : kWay * 2 * kPi / 0.4 * std::sin(u));
    }
  }
  EXPECT_TRUE(cell.run_until(DriverState::kReady, 3s));
  EXPECT_EQ(cell.count(Kind::kDone), 160U);
  for (const auto& event : cell.events) {
    EXPECT_NE(event.kind, Kind::kFailed) << describe(event.error);
  }
}

TEST(GrblDriver, what_is_too_slow_for_the_wire_and_pauses_take_their_time) {
  GrblCell cell;
  const auto feed = [&](double q, double qd) {
    for (int i = 0; i < 5000 && !cell.driver.wants_move(cell.now); ++i) cell.step();
    const auto taken = cell.driver.move({{q, 0, 0}, {qd, 0, 0}, 50ms, {}}, cell.now);
    ASSERT_TRUE(taken) << describe(taken.error());
  };
  // 0.01 deg/s: a digit every other piece.
  const double speed = from_deg(0.01);
  Instant begun = cell.now;
  for (int k = 1; k <= 80; ++k) feed(speed * 0.05 * k, k == 80 ? 0 : speed);
  ASSERT_TRUE(cell.run_until(DriverState::kReady, 10s))
      << describe(cell.driver.fault().value_or(Error{}));
  EXPECT_NEAR(to_seconds(cell.now - begun), 4, 0.6);  // a step takes 1.1 s
  // A pause before its end.
  begun = cell.now;
  const double there = cell.driver.positions()[0].q;
  feed(there + 0.01, 0.1);
  feed(there + 0.012, 0);
  for (int k = 0; k < 20; ++k) feed(there + 0.012, k == 19 ? 0 : 1e-9);
  ASSERT_TRUE(cell.run_until(DriverState::kReady, 10s));
  EXPECT_GT(to_seconds(cell.now - begun), 1);
  EXPECT_EQ(cell.count(Kind::kDone), 102U);
}

TEST(GrblDriver, refuses_what_its_joints_could_not_do_and_sends_nothing) {
  GrblCell cell;
  const auto code = [&](const JointVector& q, Duration duration, double speed = 0) {
    const auto result = cell.driver.move({q, {speed, 0, 0}, duration, {}}, cell.now);
    EXPECT_FALSE(result);
    return result ? ErrorCode::kBusy : result.error().code;
  };
  EXPECT_EQ(code({2.1, 0, 0}, 9s), ErrorCode::kJointLimit);
  EXPECT_EQ(code({0.1, 0, 0}, 20ms), ErrorCode::kSegmentTime);
  EXPECT_EQ(code({0.1, 0}, 1s), ErrorCode::kUnsendable);
  EXPECT_EQ(code({0.1, 0, 0}, 10us), ErrorCode::kSegmentTime);
  EXPECT_EQ(code({0.1, 0, 0}, 1s, std::nan("")), ErrorCode::kUnsendable);
  EXPECT_EQ(code({std::nan(""), 0, 0}, 1s), ErrorCode::kUnsendable);
  const auto elsewhere = cell.driver.move({{0.1, 0, 0}, {0, 0, 0}, 1s, {0.05, 0, 0}}, cell.now);
  EXPECT_EQ(elsewhere.error().code, ErrorCode::kMovedUnasked);
  cell.run_for(1s);
  EXPECT_FALSE(cell.machine.truth().moving);
  EXPECT_EQ(cell.events.size(), 0U);
}

TEST(GrblDriver, a_stream_that_is_not_continued_ends_at_rest_and_the_next_may_begin) {
  GrblCell cell;
  auto motion = cell.motion_to({1, -0.5, 0.25}, 1.5);
  for (int k = 0; k < 5; ++k) {
    ASSERT_TRUE(cell.driver.move(motion.piece(), cell.now));
    ++motion.next;
  }
  EXPECT_TRUE(cell.run_until(DriverState::kReady, 3s));
  ASSERT_EQ(cell.count(Kind::kFailed), 1U);
  EXPECT_EQ(cell.events.back().error.code, ErrorCode::kStreamEnded);
  EXPECT_EQ(cell.count(Kind::kDone), 5U);
  auto back = cell.motion_to({0, 0, 0}, 1.5);
  cell.run(back);
  EXPECT_NEAR(cell.q(0), 0, kGrblStep);
}

TEST(GrblDriver, homing_gives_places_from_the_file_and_without_switches_it_is_refused) {
  GrblCell none;
  EXPECT_EQ(none.driver.home(none.now, kAllJoints).error().code, ErrorCode::kNoEndStops);
  GrblCell cell(grbl_robot(3, true), {}, false);
  cell.honest = false;  // a switch closes within a tick of its place
  cell.driver.open(cell.now);
  ASSERT_TRUE(cell.run_until(DriverState::kReady, 3s));
  EXPECT_EQ(cell.driver.positions()[0].quality, PositionQuality::kLost);
  ASSERT_TRUE(cell.driver.home(cell.now, kAllJoints));
  EXPECT_EQ(cell.driver.state(), DriverState::kMoving);
  ASSERT_TRUE(cell.run_until(DriverState::kReady, 170s));
  EXPECT_EQ(cell.count(Kind::kDone), 1U);
  for (std::size_t i = 0; i < 3; ++i) {
    EXPECT_EQ(cell.driver.positions()[i].quality, PositionQuality::kCommanded);
    EXPECT_NEAR(cell.driver.positions()[i].q, cell.q(i), from_deg(0.05));
  }
  auto motion = cell.motion_to({0.5, 0, 0.25}, 3);
  cell.run(motion);
  EXPECT_NEAR(cell.q(0), 0.5, from_deg(0.05));
}

TEST(GrblDriver, a_stop_in_a_search_for_switches_ends_it_and_the_position_is_lost) {
  GrblCell cell(grbl_robot(3, true), {}, false);
  cell.driver.open(cell.now);
  ASSERT_TRUE(cell.run_until(DriverState::kReady, 3s));
  ASSERT_TRUE(cell.driver.home(cell.now, kAllJoints));
  cell.run_for(2s);
  cell.driver.stop(cell.now);
  ASSERT_TRUE(cell.run_until(DriverState::kReady, 3s));
  EXPECT_EQ(cell.count(Kind::kStopped), 1U);
  EXPECT_EQ(cell.driver.positions()[0].quality, PositionQuality::kLost);
  EXPECT_FALSE(cell.machine.truth().moving);
}

TEST(GrblDriver, a_nudge_moves_one_joint_also_where_nobody_knows_where_it_is) {
  GrblCell cell(grbl_robot(), {}, false);
  cell.open(false);
  EXPECT_EQ(cell.driver.nudge(1, 0.2, 1s, cell.now).error().code, ErrorCode::kNudgeRange);
  EXPECT_EQ(cell.driver.nudge(1, 0, 1s, cell.now).error().code, ErrorCode::kNudgeRange);
  const double before = cell.q(1);
  ASSERT_TRUE(cell.driver.nudge(1, -0.05, 1s, cell.now));
  ASSERT_TRUE(cell.run_until(DriverState::kReady, 3s));
  EXPECT_EQ(cell.count(Kind::kDone), 1U);
  EXPECT_NEAR(cell.q(1), before - 0.05, kGrblStep);
  EXPECT_EQ(cell.driver.positions()[1].quality, PositionQuality::kLost);
}

using Touch = sim::Disturbance;

/// To the second joint's input; the machine as it stands.
Touch touch_at(double q) {
  return {Touch::Kind::kProbe, 1, q};
}

TEST(GrblDriver, a_probe_says_where_its_input_closed_and_stands_behind_it) {
  test::for_random_cases(60, [](test::Random& random) {
    GrblCell cell(grbl_robot(static_cast<std::size_t>(random.integer(2, 6))));
    const double way = random.uniform(0.3, 1) * from_deg(5) * (random.chance(0.5) ? 1 : -1);
    const double place = way * random.uniform(0.05, 0.9);
    cell.machine.disturb(touch_at(place));
    const double rate = std::abs(way) / random.uniform(1, 4);  // rad/s
    ASSERT_TRUE(
        cell.driver.probe(1, way, from_seconds(std::abs(way) / rate), cell.now).has_value());
    ASSERT_FALSE(cell.driver.wants_move(cell.now));
    ASSERT_TRUE(cell.run_until(DriverState::kReady, 6s));
    ASSERT_EQ(cell.count(Kind::kDone), 1U);
    const auto touched = cell.driver.facts().get<GrblFacts>().touched;
    ASSERT_TRUE(touched && touched->what.q);
    EXPECT_EQ(touched->what.joint, 1);
    // A tick of the board's, and a step.
    EXPECT_NEAR(*touched->what.q, place, rate * 2e-3 + kGrblStep);
    const double braking = rate * rate / 2 / cell.robot.joints[1].acceleration_max;
    EXPECT_NEAR(cell.q(1), place, braking + rate * 2e-3 + kGrblStep);
    EXPECT_NEAR(cell.driver.positions()[1].q, cell.q(1), kGrblStep);
    // What is sent next means places again.
    cell.events.clear();
    auto motion = cell.motion_to(JointVector(std::vector<double>(cell.robot.joints.size(), -0.2)));
    cell.run(motion);
    ASSERT_FALSE(cell.refused || cell.driver.fault());
    EXPECT_NEAR(cell.q(1), -0.2, kGrblStep);
  });
}

TEST(GrblDriver, a_probe_that_touches_nothing_goes_its_way_and_says_so) {
  GrblCell cell;
  cell.machine.disturb(touch_at(0.5));
  ASSERT_TRUE(cell.driver.probe(1, 0.05, 1s, cell.now));
  ASSERT_TRUE(cell.run_until(DriverState::kReady, 3s));
  EXPECT_EQ(cell.count(Kind::kDone), 1U);
  EXPECT_FALSE(cell.driver.facts().get<GrblFacts>().touched);
  EXPECT_NEAR(cell.q(1), 0.05, kGrblStep);
}

TEST(GrblDriver, a_probe_whose_input_is_closed_is_refused_and_nothing_moves) {
  GrblCell cell;
  cell.machine.disturb(touch_at(0));
  cell.run_for(500ms);
  EXPECT_EQ(cell.driver.may_probe().error().code, ErrorCode::kProbeClosed);
  EXPECT_EQ(cell.driver.probe(1, 0.05, 1s, cell.now).error().code, ErrorCode::kProbeClosed);
  EXPECT_EQ(cell.driver.state(), DriverState::kReady);
  ASSERT_TRUE(cell.driver.nudge(1, -0.05, 1s, cell.now)) << "the way off it";
  ASSERT_TRUE(cell.run_until(DriverState::kReady, 3s));
  EXPECT_TRUE(cell.driver.may_probe());
}

/// It closes between the last report and the line: the board refuses it.
TEST(GrblDriver, a_probe_whose_input_has_just_closed_is_an_alarm_that_keeps_the_position) {
  GrblCell cell;
  cell.run_for(500ms);
  ASSERT_TRUE(cell.driver.probe(1, 0.05, 1s, cell.now));
  cell.machine.disturb(touch_at(0));
  ASSERT_TRUE(cell.run_until(DriverState::kFault, 3s));
  EXPECT_EQ(cell.driver.fault()->code, ErrorCode::kProbeClosed);
  EXPECT_EQ(cell.driver.positions()[1].quality, PositionQuality::kCommanded);
  EXPECT_EQ(cell.q(1), 0);
}

TEST(GrblDriver, a_probe_is_stopped_on_its_way_and_the_position_is_kept) {
  for (const Duration after : {1ms, 60ms, 500ms, 990ms}) {
    GrblCell cell;
    cell.machine.disturb(touch_at(0.5));
    ASSERT_TRUE(cell.driver.probe(1, 0.08, 1s, cell.now));
    cell.run_for(after);
    cell.driver.stop(cell.now);
    ASSERT_TRUE(cell.run_until(DriverState::kReady, 3s)) << to_seconds(after);
    EXPECT_EQ(cell.count(Kind::kStopped), 1U);
    EXPECT_LT(cell.q(1), 0.08);
    EXPECT_NEAR(cell.driver.positions()[1].q, cell.q(1), kGrblStep);
    auto motion = cell.motion_to({0.1, 0.1, 0.1});
    cell.run(motion);
    EXPECT_NEAR(cell.q(1), 0.1, kGrblStep) << "absolute places again";
  }
}

}  // namespace
}  // namespace sinew
