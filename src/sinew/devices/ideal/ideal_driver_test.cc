#include "sinew/devices/ideal/ideal_driver.h"

#include <gtest/gtest.h>

#include "sinew/core/error_code.h"
#include "sinew/devices/ideal/ideal_test_cell.h"
#include "support/property.h"

namespace sinew {
namespace {

using namespace std::chrono_literals;
using test::IdealCell;
using Kind = DriverEvent::Kind;

TEST(IdealDriver, positions_are_measured_as_soon_as_it_answers) {
  IdealCell cell({}, false);
  EXPECT_EQ(cell.driver.positions()[0].quality, PositionQuality::kLost);
  cell.driver.open(cell.now);
  EXPECT_EQ(cell.driver.state(), DriverState::kOpening);
  EXPECT_TRUE(cell.run_until(DriverState::kReady, 100ms));
  EXPECT_EQ(cell.driver.positions()[2].quality, PositionQuality::kMeasured);
  EXPECT_EQ(cell.count(Kind::kReady), 1U);
}

TEST(IdealDriver, a_streamed_motion_arrives_without_a_gap_and_each_move_is_done_once) {
  IdealCell cell;
  auto motion = cell.motion_to({1, -0.5, 0.25});
  const Instant began = cell.now;
  cell.run(motion, 3s);
  EXPECT_EQ(cell.driver.state(), DriverState::kReady);
  EXPECT_NEAR(to_seconds(cell.now - began), 1.0, 0.015);
  EXPECT_EQ(cell.count(Kind::kDone), 50U);
  EXPECT_EQ(cell.events.size(), 50U);
  EXPECT_NEAR(cell.machine.truth().joints[0].q, 1, 1e-6);
  EXPECT_NEAR(cell.driver.positions()[1].q, -0.5, 1e-6);
}

TEST(IdealDriver, refuses_what_its_device_could_not_do_and_sends_nothing) {
  IdealCell cell;
  const auto code = [&](const JointVector& q, Duration duration, double speed = 0) {
    const auto result = cell.driver.move({q, {speed, 0, 0}, duration, {}}, cell.now);
    EXPECT_FALSE(result);
    return result ? ErrorCode::kBusy : result.error().code;
  };
  const auto before = cell.driver.health().requests;
  EXPECT_EQ(code({2.1, 0, 0}, 9s), ErrorCode::kJointLimit);
  EXPECT_EQ(code({0.1, 0, 0}, 20ms), ErrorCode::kSegmentTime);
  EXPECT_EQ(code({0.1, 0}, 1s), ErrorCode::kUnsendable);
  EXPECT_EQ(code({0.1, 0, 0}, 10us), ErrorCode::kSegmentTime);
  EXPECT_EQ(code({0.1, 0, 0}, 1s, std::nan("")), ErrorCode::kUnsendable);
  const auto elsewhere = cell.driver.move({{0.1, 0, 0}, {0, 0, 0}, 1s, {0.05, 0, 0}}, cell.now);
  EXPECT_EQ(elsewhere.error().code, ErrorCode::kMovedUnasked);
  EXPECT_EQ(cell.driver.tool(JawsTo{0.05}, cell.now).error().code, ErrorCode::kJawWidth);
  EXPECT_EQ(cell.driver.tool(Suction{}, cell.now).error().code, ErrorCode::kToolNotFitted);
  EXPECT_EQ(cell.driver.health().requests, before);
}

TEST(IdealDriver, stop_brakes_and_every_command_has_its_end) {
  IdealCell cell;
  auto motion = cell.motion_to({1, -0.5, 0.25});
  cell.run(motion, 500ms);
  const std::size_t accepted = motion.next - 1;
  cell.driver.stop(cell.now);
  EXPECT_EQ(cell.driver.state(), DriverState::kStopping);
  EXPECT_TRUE(cell.run_until(DriverState::kReady, 1s));
  EXPECT_EQ(cell.count(Kind::kDone) + cell.count(Kind::kStopped), accepted);
  EXPECT_FALSE(cell.machine.truth().moving);
  const double there = cell.machine.truth().joints[0].q;
  EXPECT_GT(there, 0.5);
  EXPECT_LT(there, 0.75);
  EXPECT_NEAR(cell.driver.positions()[0].q, there, 1e-6);
  auto back = cell.motion_to({0, 0, 0});
  cell.run(back, 3s);
  EXPECT_NEAR(cell.machine.truth().joints[0].q, 0, 1e-6);
}

TEST(IdealDriver, a_motion_that_is_not_continued_fails_and_the_next_may_begin) {
  IdealCell cell;
  auto motion = cell.motion_to({1, 0, 0});
  while (motion.next <= 20) {
    cell.feed(motion);
    if (motion.next > 20) break;
    cell.step();
  }
  cell.run_for(1s);
  EXPECT_EQ(cell.driver.state(), DriverState::kReady);
  ASSERT_GE(cell.count(Kind::kFailed), 1U);
  EXPECT_EQ(cell.events.back().error.code, ErrorCode::kStreamEnded);
  EXPECT_EQ(cell.driver.health().unexpected, 0U);
  auto on = cell.motion_to({1, 0, 0});
  cell.run(on, 3s);
  EXPECT_NEAR(cell.machine.truth().joints[0].q, 1, 1e-6);
}

TEST(IdealDriver, a_host_that_dies_stops_the_arm_and_the_next_one_goes_on) {
  IdealCell cell;
  auto motion = cell.motion_to({1, 0, 0});
  cell.run(motion, 500ms);
  cell.connected = false;
  cell.run_for(1s);
  EXPECT_FALSE(cell.machine.truth().moving);
  const double there = cell.machine.truth().joints[0].q;
  cell.connected = true;
  cell.driver = IdealDriver(cell.robot.joints, JawGripper{0.04, 0.1, 0.1}, 1'000'000);
  cell.refused.reset();
  cell.open();
  EXPECT_NEAR(cell.driver.positions()[0].q, there, 1e-6);
  auto on = cell.motion_to({1, 0, 0});
  cell.run(on, 3s);
  EXPECT_NEAR(cell.machine.truth().joints[0].q, 1, 1e-6);
}

TEST(IdealDriver, an_arm_that_still_moves_is_stopped_before_anything_else) {
  IdealCell cell;
  auto motion = cell.motion_to({1, 0, 0});
  cell.run(motion, 500ms);
  cell.driver.open(cell.now);
  EXPECT_TRUE(cell.run_until(DriverState::kReady, 1s));
  EXPECT_FALSE(cell.machine.truth().moving);
}

TEST(IdealDriver, unplugged_it_says_so_once_and_comes_back_by_itself) {
  IdealCell cell;
  auto motion = cell.motion_to({1, 0, 0});
  cell.run(motion, 500ms);
  const std::size_t accepted = motion.next - 1;
  cell.connected = false;
  cell.run_for(3s);
  EXPECT_EQ(cell.driver.state(), DriverState::kOpening);
  EXPECT_EQ(cell.driver.positions()[0].quality, PositionQuality::kLost);
  EXPECT_EQ(cell.count(Kind::kDone) + cell.count(Kind::kFailed), accepted);
  EXPECT_EQ(cell.events.back().error.code, ErrorCode::kDeviceSilent);
  cell.connected = true;
  EXPECT_TRUE(cell.run_until(DriverState::kReady, 2s));
  EXPECT_EQ(cell.driver.positions()[0].quality, PositionQuality::kMeasured);
}

TEST(IdealDriver, power_that_was_away_is_noticed) {
  IdealCell cell;
  auto motion = cell.motion_to({1, 0, 0});
  cell.run(motion, 3s);
  cell.events.clear();
  cell.machine.disturb({sim::Disturbance::Kind::kSupply, -1, 0});
  cell.run_for(20ms);
  cell.machine.disturb({sim::Disturbance::Kind::kSupply, -1, 12});
  cell.run_for(1s);
  EXPECT_EQ(cell.driver.state(), DriverState::kReady);
  ASSERT_FALSE(cell.events.empty());
  EXPECT_EQ(cell.events.front().kind, Kind::kNotice);
  EXPECT_EQ(cell.events.front().error.code, ErrorCode::kSupplyFlag);
  EXPECT_NEAR(cell.driver.positions()[0].q, 1, 1e-6);
}

TEST(IdealDriver, what_blocks_a_joint_is_a_fault_until_it_is_cleared) {
  IdealCell cell;
  cell.machine.disturb({sim::Disturbance::Kind::kBlock, 1, -0.2});
  auto motion = cell.motion_to({1, -0.5, 0});
  cell.run(motion, 3s);
  EXPECT_EQ(cell.driver.state(), DriverState::kFault);
  EXPECT_EQ(cell.driver.fault()->code, ErrorCode::kStalled);
  EXPECT_EQ(cell.driver.fault()->index, 1);
  EXPECT_FALSE(cell.driver.move({{0, 0, 0}, {0, 0, 0}, 1s, {}}, cell.now));
  cell.machine.disturb({sim::Disturbance::Kind::kUnblock, 1, 0});
  ASSERT_TRUE(cell.driver.clear_fault(cell.now));
  EXPECT_TRUE(cell.driver.clearing());
  cell.events.clear();
  EXPECT_TRUE(cell.run_until(DriverState::kReady, 1s));
  EXPECT_EQ(cell.count(Kind::kDone), 1U);
  cell.refused.reset();
  auto on = cell.motion_to({0, 0, 0});
  cell.run(on, 3s);
  EXPECT_NEAR(cell.machine.truth().joints[1].q, 0, 1e-6);
}

TEST(IdealDriver, jaws_close_and_tell_their_width) {
  IdealCell cell;
  ASSERT_TRUE(cell.driver.tool(JawsTo{0.01}, cell.now));
  EXPECT_TRUE(cell.run_until(DriverState::kReady, 3s));
  EXPECT_EQ(cell.count(Kind::kDone), 1U);
  EXPECT_NEAR(*cell.driver.health().jaws_width, 0.01, 1e-6);
  EXPECT_NEAR(cell.machine.truth().tool, 0.01, 1e-6);
}

/// One byte that way, the first from then on.
sim::LinkFaultSpec one_byte(sim::TimedByteFault::Kind kind, Duration at, sim::LinkDirection only,
                            Duration delay = {}) {
  sim::LinkFaultSpec faults;
  faults.timed.push_back({.kind = kind,
                          .chance = 1,
                          .at = at,
                          .once = true,
                          .until = {},
                          .only = only,
                          .delay_time = delay});
  return faults;
}

TEST(IdealDriver, answers_that_come_late_are_not_taken_for_those_of_the_next_line) {
  IdealCell cell(
      one_byte(sim::TimedByteFault::Kind::kDelay, 500ms, sim::LinkDirection::kToHost, 58ms));
  auto motion = cell.motion_to({1, -0.5, 0.25});
  cell.run(motion, 3s);
  EXPECT_EQ(cell.driver.state(), DriverState::kReady);
  EXPECT_EQ(cell.count(Kind::kDone), 50U);
  EXPECT_EQ(cell.events.size(), 50U);
}

/// An adapter with a buffer: every byte comes later, in both directions.
TEST(IdealDriver, a_motion_goes_through_adapters_that_are_late) {
  for (const Duration late : {1ms, 4ms, 8ms, 16ms}) {
    IdealCell cell({}, true, late);
    auto motion = cell.motion_to({1, -0.5, 0.25});
    const Instant began = cell.now;
    cell.run(motion, 3s);
    EXPECT_EQ(cell.driver.state(), DriverState::kReady) << to_seconds(late);
    EXPECT_EQ(cell.count(Kind::kDone), 50U);
    EXPECT_LT(to_seconds(cell.now - began), 1.1);
    EXPECT_NEAR(cell.machine.truth().joints[0].q, 1, 1e-6);
  }
}

TEST(IdealDriver, a_lost_move_is_said_again_before_the_arm_comes_to_its_end) {
  for (int i = 0; i < 40; ++i) {
    IdealCell cell(one_byte(sim::TimedByteFault::Kind::kDrop,
                            std::chrono::milliseconds(200 + 7 * i), sim::LinkDirection::kToDevice));
    auto motion = cell.motion_to({1, -0.5, 0.25});
    cell.run(motion, 3s);
    EXPECT_EQ(cell.driver.state(), DriverState::kReady) << i;
    EXPECT_EQ(cell.count(Kind::kDone), 50U) << i;
  }
}

TEST(IdealDriver, a_host_that_is_away_for_40_ms_is_no_trouble) {
  IdealCell cell;
  auto motion = cell.motion_to({1, -0.5, 0.25});
  for (int i = 0; i < 12; ++i) {
    cell.run(motion, 60ms);
    cell.be_late_by(40ms);
  }
  cell.run(motion, 3s);
  EXPECT_EQ(cell.driver.state(), DriverState::kReady);
  EXPECT_EQ(cell.count(Kind::kDone), 50U);
}

/// A simulated cell looks every 50 ms of a device whose time runs five times as fast.
TEST(IdealDriver, whoever_looks_every_50_ms_keeps_it_going) {
  IdealCell cell;
  cell.run_for(37ms);  // its next look at rest is far away
  auto motion = cell.motion_to({1, -0.5, 0.25});
  while (motion.next <= motion.segments) {
    cell.feed(motion);
    cell.run_for(50ms);
    ASSERT_EQ(cell.count(Kind::kFailed), 0U);
  }
  cell.run(motion, 3s);
  EXPECT_EQ(cell.driver.state(), DriverState::kReady);
  EXPECT_EQ(cell.count(Kind::kDone), 50U);
}

/// Two late answers and a lost stop: what answers to a line before the stop does not answer to it.
TEST(IdealDriver, only_what_answers_to_a_stop_ends_it) {
  IdealCell cell(
      one_byte(sim::TimedByteFault::Kind::kDelay, 105ms, sim::LinkDirection::kToHost, 70ms));
  cell.run_for(160ms);
  auto motion = cell.motion_to({0.6, 0, 0});
  cell.run(motion, 10ms);
  cell.link_down = true;  // the stop does not arrive
  cell.driver.stop(cell.now);
  cell.run_for(4ms);
  cell.link_down = false;
  EXPECT_EQ(cell.driver.state(), DriverState::kStopping);
  EXPECT_TRUE(cell.run_until(DriverState::kReady, 1s));
  EXPECT_FALSE(cell.machine.truth().moving);
  cell.refused.reset();
  auto back = cell.motion_to({-0.6, 0, 0});
  cell.run(back, 5s);
  EXPECT_NEAR(cell.machine.truth().joints[0].q, -0.6, 1e-6);
}

TEST(IdealDriver, a_joint_as_slow_as_a_fifth_of_a_degree_a_second_moves) {
  RobotModel slow = test::ideal_robot();
  for (Joint& joint : slow.joints) {
    joint.velocity_max = from_deg(0.2);
    joint.acceleration_max = from_deg(0.8);
  }
  IdealCell cell({}, true, {}, slow);
  auto motion = cell.motion_to({from_deg(0.2), 0, 0}, 1.6);
  cell.run(motion, 4s);
  EXPECT_FALSE(cell.refused);
  EXPECT_NEAR(cell.machine.truth().joints[0].q, from_deg(0.2), 1e-6);
}

TEST(IdealDriver, another_device_is_said_once_and_left_alone) {
  IdealCell cell({}, false);
  cell.driver = IdealDriver(std::span(cell.robot.joints).first(2), {}, 1'000'000);
  cell.honest = false;  // it claims nothing
  cell.driver.open(cell.now);
  cell.run_for(5s);
  EXPECT_EQ(cell.driver.state(), DriverState::kFault);
  EXPECT_EQ(cell.count(Kind::kFailed), 1U);
  EXPECT_EQ(cell.events.size(), 1U);
}

/// Comes to rest, a fault that may be there cleared: a host whose lines are lost falls silent.
bool ready_again(IdealCell& cell) {
  const Instant end = cell.now + 20s;
  while (cell.now < end && cell.driver.state() != DriverState::kReady) {
    if (cell.driver.state() == DriverState::kFault) {
      EXPECT_EQ(cell.driver.fault()->code, ErrorCode::kLinkSilent);
      EXPECT_TRUE(cell.driver.clear_fault(cell.now));
    }
    cell.step();
  }
  return cell.driver.state() == DriverState::kReady;
}

/// Whatever the line does: every claim of a position holds (each step is looked at), no joint moves
/// where it was not sent, every command has one end, and at last it works again.
TEST(IdealDriver, whatever_the_line_does_no_joint_moves_wrong_and_every_command_has_one_end) {
  std::uint64_t arrived = 0;
  test::for_random_cases(100, [&](test::Random& random) {
    sim::LinkFaultSpec faults;
    for (sim::ByteFaults& way : faults.bytes) {
      way.flip = random.chance(0.5) ? random.uniform(0, 2e-3) : 0;
      way.drop = random.chance(0.5) ? random.uniform(0, 2e-3) : 0;
      way.duplicate = random.chance(0.3) ? random.uniform(0, 2e-3) : 0;
      way.delay = random.chance(0.3) ? random.uniform(0, 5e-4) : 0;
      way.delay_time = from_seconds(random.uniform(0, 0.2));
    }
    faults.seed = random.bits();
    IdealCell cell(faults, false);
    cell.driver.open(cell.now);
    if (!cell.run_until(DriverState::kReady, 20s)) return random.discard();
    for (int i = 0; i < 4; ++i) {
      ASSERT_TRUE(ready_again(cell));
      cell.events.clear();
      cell.refused.reset();
      const double to = random.uniform(-1, 1);
      auto motion = cell.motion_to({to, -to / 2, to / 4}, 2);
      const JointVector from = motion.from;
      cell.run(motion, random.chance(0.3) ? from_seconds(random.uniform(0, 2)) : Duration(4s));
      const std::size_t accepted = motion.next - 1;
      const bool stopped = cell.driver.state() == DriverState::kMoving;
      if (stopped) cell.driver.stop(cell.now);
      while (cell.driver.state() == DriverState::kStopping) cell.step();
      const std::size_t done = cell.count(Kind::kDone);
      ASSERT_TRUE(ready_again(cell));
      std::size_t ends = cell.count(Kind::kDone) + cell.count(Kind::kFailed);
      ends += cell.count(Kind::kStopped);
      // clear_fault() has an end as well, and a stop of nothing, and a silence while it opens.
      EXPECT_GE(ends, accepted);
      EXPECT_LE(done, accepted);
      const auto truth = cell.machine.truth();
      for (std::size_t j = 0; j < 3; ++j) {
        EXPECT_GE(truth.joints[j].q, std::min(from[j], motion.to[j]) - 1e-5);
        EXPECT_LE(truth.joints[j].q, std::max(from[j], motion.to[j]) + 1e-5);
      }
      const bool there = std::abs(truth.joints[0].q - to) < 1e-5;
      arrived += there ? 1 : 0;
      const bool told = motion.next > motion.segments && done == motion.segments;
      EXPECT_TRUE(there || !told);
    }
  });
  EXPECT_GT(arrived, 50U);
}

}  // namespace
}  // namespace sinew
