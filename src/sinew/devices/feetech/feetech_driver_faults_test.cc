#include <gtest/gtest.h>

#include "sinew/core/error_code.h"
#include "sinew/devices/feetech/feetech_driver.h"
#include "sinew/devices/feetech/feetech_test_cell.h"
#include "support/property.h"

namespace sinew {
namespace {

using namespace std::chrono_literals;
using namespace feetech;
using test::feetech_robot;
using test::FeetechCell;
using test::kFeetechSag;
using Disturb = sim::Disturbance::Kind;
using Kind = DriverEvent::Kind;

/// What an opening fails with.
std::optional<Error> opening_of(FeetechCell& cell) {
  cell.driver.open(cell.now);
  cell.run_for(3s);
  return cell.failure();
}

TEST(FeetechFaults, a_servo_that_is_set_up_otherwise_than_the_file_is_refused_by_name) {
  struct Case {
    const char* what;
    ErrorCode code;
    int index;
    void (*set_up)(FeetechCell&);
  };
  const Case cases[] = {
      {"a wheel", ErrorCode::kServoMode, 1,
       [](FeetechCell& c) { c.servo(1).write(Register::kMode, {1}); }},
      {"narrow", ErrorCode::kServoRange, 2,
       [](FeetechCell& c) { c.servo(2).set_word(Register::kHighest, 2700); }},
      {"narrow at its lower end", ErrorCode::kServoRange, 0,
       [](FeetechCell& c) { c.servo(0).set_word(Register::kLowest, 1300); }},
      {"too many volts", ErrorCode::kSupplyHigh, -1,
       [](FeetechCell& c) { c.machine.disturb({Disturb::kSupply, -1, 12}); }},
      {"too few volts", ErrorCode::kSupplyLow, -1,
       [](FeetechCell& c) { c.machine.disturb({Disturb::kSupply, -1, 3.8}); }},
      {"one is not there", ErrorCode::kServoSilent, 2,
       [](FeetechCell& c) { c.machine.disturb({Disturb::kLead, 2, 0}); }},
      {"too hot", ErrorCode::kOverheated, 1, [](FeetechCell& c) { c.machine.warm(1, 75); }},
  };
  for (const Case& one : cases) {
    SCOPED_TRACE(one.what);
    FeetechCell cell(feetech_robot(), {.opened = false});
    one.set_up(cell);
    const auto error = opening_of(cell);
    ASSERT_TRUE(error);
    EXPECT_EQ(error->code, one.code);
    EXPECT_EQ(error->index, one.index);
    EXPECT_EQ(cell.driver.state(), DriverState::kFault);
    EXPECT_EQ(cell.driver.move({{0, 0, 0}, {0, 0, 0}, 1s, {}}, cell.now).error().code, one.code);
    EXPECT_EQ(cell.count(Kind::kFailed), 1U);
  }
}

TEST(FeetechFaults, limits_say_where_the_servo_ends_in_the_joints_own_angle) {
  FeetechCell cell(feetech_robot(), {.opened = false});
  cell.servo(1).set_word(Register::kHighest, 2700);  // counts against the joint
  const auto error = opening_of(cell);
  ASSERT_TRUE(error);
  EXPECT_NEAR(error->measured, -(2700 - 2048) * 2 * kPi / 4096, 1e-9);
  EXPECT_EQ(error->limit, -1.5);
}

TEST(FeetechFaults, a_fault_of_the_opening_ends_when_its_cause_is_gone) {
  FeetechCell cell(feetech_robot(), {.opened = false});
  cell.machine.disturb({Disturb::kLead, 2, 0});
  ASSERT_TRUE(opening_of(cell));
  cell.events.clear();
  ASSERT_TRUE(cell.driver.clear_fault(cell.now));
  cell.run_for(2s);
  EXPECT_EQ(cell.driver.state(), DriverState::kFault) << "it is still not there";
  cell.machine.disturb({Disturb::kLead, 2, 1});
  cell.events.clear();
  ASSERT_TRUE(cell.driver.clear_fault(cell.now));
  EXPECT_TRUE(cell.driver.clearing());
  cell.run_for(2s);
  EXPECT_EQ(cell.driver.state(), DriverState::kReady);
  EXPECT_EQ(cell.count(Kind::kDone), 1U);
}

TEST(FeetechFaults, bus_without_servos_is_silence_and_is_tried_again) {
  FeetechCell cell(feetech_robot(), {.opened = false});
  cell.machine.disturb({Disturb::kSupply, -1, 0});
  const auto error = opening_of(cell);
  ASSERT_TRUE(error);
  EXPECT_EQ(error->code, ErrorCode::kDeviceSilent);
  EXPECT_EQ(cell.count(Kind::kFailed), 1U) << "told once";
  EXPECT_EQ(cell.driver.state(), DriverState::kOpening);
  cell.machine.disturb({Disturb::kSupply, -1, 7.4});
  EXPECT_TRUE(cell.run_until(DriverState::kReady, 5s));
  EXPECT_TRUE(cell.driver.free()) << "motors are off behind a loss of power";
}

TEST(FeetechFaults, a_plug_that_comes_out_stops_the_motion_and_names_the_joint) {
  FeetechCell cell;
  auto motion = cell.motion_to({1, 0.5, 0.5}, 1.2);
  cell.run(motion, 500ms);
  cell.machine.disturb({Disturb::kLead, 1, 0});
  cell.honest = false;  // the joint falls
  cell.run(motion);
  cell.run_for(1s);
  ASSERT_TRUE(cell.failure());
  EXPECT_EQ(cell.failure()->code, ErrorCode::kServoSilent);
  EXPECT_EQ(cell.failure()->index, 1);
  EXPECT_EQ(cell.driver.state(), DriverState::kFault);
  EXPECT_EQ(cell.driver.positions()[1].quality, PositionQuality::kLost);
  EXPECT_EQ(cell.driver.positions()[0].quality, PositionQuality::kMeasured);
  EXPECT_LT(cell.q(0), 0.9) << "the others have braked";
  cell.machine.disturb({Disturb::kLead, 1, 1});
  ASSERT_TRUE(cell.driver.clear_fault(cell.now));
  cell.run_for(3s);
  EXPECT_EQ(cell.driver.state(), DriverState::kReady);
}

TEST(FeetechFaults, the_last_plug_that_stays_answers_one_by_one) {
  FeetechCell cell;
  cell.machine.disturb({Disturb::kLead, 0, 0});
  cell.run_for(2s);
  ASSERT_TRUE(cell.failure());
  EXPECT_EQ(cell.failure()->index, 0) << "those behind it wait for its reply, and are asked alone";
}

TEST(FeetechFaults, a_loss_of_power_in_motion_is_no_success_and_the_arm_is_free_behind_it) {
  FeetechCell cell;
  auto motion = cell.motion_to({1, 0.5, 0.5}, 1.2);
  cell.run(motion, 500ms);
  cell.honest = false;
  cell.machine.disturb({Disturb::kSupply, -1, 0});
  cell.run(motion, 300ms);
  cell.machine.disturb({Disturb::kSupply, -1, 7.4});
  cell.run_for(4s);
  ASSERT_TRUE(cell.failure());
  if (cell.driver.state() == DriverState::kFault) {
    const ErrorCode code = cell.driver.fault()->code;
    EXPECT_TRUE(code == ErrorCode::kSupplyFlag || code == ErrorCode::kServoSilent);
  } else {
    EXPECT_TRUE(cell.driver.free());
  }
  EXPECT_NEAR(cell.driver.positions()[1].q, cell.q(1), 0.01) << "the sensors need no search";
}

TEST(FeetechFaults, a_short_dip_that_switches_motors_off_is_seen) {
  FeetechCell cell;
  auto motion = cell.motion_to({1, 0.5, 0.5}, 1.2);
  cell.run(motion, 500ms);
  cell.honest = false;
  cell.machine.disturb({Disturb::kSupply, -1, 2});
  cell.run(motion, 5ms);
  cell.machine.disturb({Disturb::kSupply, -1, 7.4});
  cell.run(motion);
  cell.run_for(1s);
  ASSERT_TRUE(cell.failure());
  EXPECT_EQ(cell.failure()->code, ErrorCode::kSupplyFlag);
  ASSERT_TRUE(cell.driver.clear_fault(cell.now));
  cell.run_for(2s);
  EXPECT_EQ(cell.driver.state(), DriverState::kReady);
}

TEST(FeetechFaults, what_is_in_the_way_stops_the_arm_and_is_not_pushed_on) {
  FeetechCell cell;
  auto motion = cell.motion_to({1.4, 0, 0}, 1.2);
  cell.machine.disturb({Disturb::kBlock, 0, 0.5});
  cell.run(motion);
  cell.run_for(1s);
  ASSERT_TRUE(cell.failure());
  EXPECT_EQ(cell.failure()->code, ErrorCode::kFollowingError);
  EXPECT_EQ(cell.failure()->index, 0);
  EXPECT_EQ(cell.driver.state(), DriverState::kFault);
  cell.run_for(5s);
  EXPECT_EQ(cell.servo(0).trouble(), 0) << "it would have overloaded";
  cell.machine.disturb({Disturb::kUnblock, 0, 0});
  ASSERT_TRUE(cell.driver.clear_fault(cell.now));
  cell.run_for(1s);
  EXPECT_EQ(cell.driver.state(), DriverState::kReady);
}

TEST(FeetechFaults, a_small_thing_in_the_way_is_a_missed_target) {
  FeetechCell cell;
  auto motion = cell.motion_to({1, 0, 0}, 1.2);
  cell.machine.disturb({Disturb::kBlock, 0, 0.8});
  cell.run(motion);
  ASSERT_TRUE(cell.failure());
  EXPECT_EQ(cell.failure()->code, ErrorCode::kMissedTarget);
  EXPECT_NEAR(cell.failure()->measured, 0.8, 0.01);
  EXPECT_NEAR(cell.failure()->limit, 1, 1e-9);
}

TEST(FeetechFaults, an_overload_is_a_fault_and_ends_with_the_load) {
  FeetechCell cell;
  auto motion = cell.motion_to({0, 0.5, 0}, 1.2);
  cell.run(motion);
  cell.machine.disturb({Disturb::kLoad, 1, -3});
  cell.honest = false;
  cell.run_for(5s);
  ASSERT_TRUE(cell.failure());
  EXPECT_EQ(cell.failure()->code, ErrorCode::kOverloaded);
  EXPECT_EQ(cell.failure()->index, 1);
  EXPECT_EQ(cell.driver.state(), DriverState::kFault);
  cell.machine.disturb({Disturb::kLoad, 1, 0});
  ASSERT_TRUE(cell.driver.clear_fault(cell.now));
  cell.run_for(3s);
  EXPECT_EQ(cell.driver.state(), DriverState::kReady);
  EXPECT_EQ(cell.servo(1).trouble(), 0);
}

/// Its servo is told where it is, and does not push.
void expect_relieved(FeetechCell& cell, std::size_t joint) {
  cell.run_for(100ms);
  const auto goal = cell.servo(joint).read(Register::kGoal, 2).value();
  const auto units = cell.servo(joint).read(Register::kPosition, 2).value();
  const auto word = [](const Data& data) {
    return word_at({data.data(), data.size()}, 0, std::endian::little);
  };
  EXPECT_NEAR(word(goal), word(units), 3) << joint;
  cell.run_for(5s);
  EXPECT_EQ(cell.servo(joint).trouble(), 0) << joint << " would have overloaded";
}

TEST(FeetechFaults, nothing_pushes_on_behind_a_missed_target_large_or_small) {
  for (const double block : {0.8, 0.95}) {
    SCOPED_TRACE(block);
    FeetechCell cell;
    auto motion = cell.motion_to({1, 0, 0}, 1.2);
    cell.machine.disturb({Disturb::kBlock, 0, block});
    cell.run(motion);
    ASSERT_TRUE(cell.failure());
    EXPECT_EQ(cell.failure()->code, ErrorCode::kMissedTarget);
    EXPECT_EQ(cell.failure()->index, 0);
    expect_relieved(cell, 0);
  }
}

TEST(FeetechFaults, two_joints_that_are_blocked_are_both_relieved) {
  FeetechCell cell;
  auto motion = cell.motion_to({1.4, 0, 1.4}, 1.2);
  cell.machine.disturb({Disturb::kBlock, 0, 0.5});
  cell.machine.disturb({Disturb::kBlock, 2, 0.5});
  cell.run(motion);
  cell.run_for(1s);
  EXPECT_EQ(cell.driver.state(), DriverState::kFault);
  expect_relieved(cell, 0);
  expect_relieved(cell, 2);
}

TEST(FeetechFaults, a_stop_against_something_does_not_move_once_that_is_gone) {
  FeetechCell cell;
  auto motion = cell.motion_to({1.2, 0, 0}, 1.2);
  cell.machine.disturb({Disturb::kBlock, 0, 0.5});
  while (cell.driver.state() != DriverState::kFault) {
    cell.feed(motion);
    cell.step();
    const auto goal = cell.servo(0).read(Register::kGoal, 2).value();
    const std::span bytes(goal.data(), goal.size());
    const double told = (word_at(bytes, 0, std::endian::little) - 2048) * 2 * kPi / 4096;
    if (told > cell.q(0) + 0.2) break;
  }
  cell.driver.stop(cell.now);
  ASSERT_TRUE(cell.run_until(DriverState::kReady, 3s));
  cell.run_for(100ms);
  const double there = cell.q(0);
  cell.machine.disturb({Disturb::kUnblock, 0, 0});
  cell.run_for(2s);
  EXPECT_NEAR(cell.q(0), there, 0.02);
}

TEST(FeetechFaults, servos_that_are_asked_one_by_one_are_switched_at_any_moment) {
  for (int k = 0; k < 60; ++k) {
    FeetechCell cell(feetech_robot(FeetechSeries::kScs));
    cell.run_for(std::chrono::microseconds(1700 * k));
    for (const DeviceService what : {DeviceService::kFree, DeviceService::kHold}) {
      cell.events.clear();
      ASSERT_TRUE(cell.driver.service(what, cell.now));
      ASSERT_TRUE(cell.run_until(DriverState::kReady, 4s)) << k;
      EXPECT_EQ(cell.count(Kind::kDone), 1U) << k;
    }
  }
}

TEST(FeetechFaults, a_servo_that_goes_away_while_motors_are_told_ends_the_opening) {
  for (int k = 0; k < 40; ++k) {
    FeetechCell cell(feetech_robot(), {.opened = false});
    cell.driver.open(cell.now);
    cell.run_for(std::chrono::milliseconds(2 * k));
    cell.honest = false;
    cell.machine.disturb({Disturb::kLead, 1, 0});
    cell.run_for(4s);
    EXPECT_EQ(cell.driver.state(), DriverState::kFault) << k;
    ASSERT_TRUE(cell.driver.fault());
    EXPECT_EQ(cell.driver.fault()->code, ErrorCode::kServoSilent) << k;
  }
}

TEST(FeetechFaults, a_servo_beyond_its_turn_is_not_told_to_come_back) {
  FeetechCell cell(feetech_robot(), {.opened = false});
  for (const std::uint8_t limit : {Register::kLowest, Register::kHighest}) {
    cell.servo(0).set_word(limit, 0);
  }
  cell.servo(0).set_word(Register::kOffset, sign_and_magnitude(2047, kOffsetSign));
  cell.servo(0).hold();
  cell.honest = false;  // it counts from elsewhere now
  cell.run_for(10ms);
  const double before = cell.q(0);
  const auto error = opening_of(cell);
  ASSERT_TRUE(error);
  EXPECT_EQ(error->code, ErrorCode::kServoTurns);
  EXPECT_NEAR(cell.q(0), before, kFeetechSag);
}

TEST(FeetechFaults, a_servo_that_is_too_hot_and_lets_go_is_not_said_to_have_lost_its_supply) {
  FeetechCell cell;
  cell.honest = false;
  cell.machine.warm(1, 75);
  cell.run_for(2s);
  ASSERT_TRUE(cell.failure());
  EXPECT_EQ(cell.failure()->code, ErrorCode::kOverheated);
  EXPECT_EQ(cell.failure()->index, 1);
}

TEST(FeetechFaults,
     jaws_that_another_program_has_left_overloaded_do_not_keep_the_arm_from_opening) {
  FeetechCell cell(feetech_robot(), {.opened = false});
  cell.machine.disturb({Disturb::kBlock, 3, 0.025});
  cell.servo(3).write(Register::kGoal, {0xEE, 0x07});
  cell.run_for(4s);
  ASSERT_EQ(cell.servo(3).trouble(), Trouble::kOverload);
  cell.driver.open(cell.now);
  EXPECT_TRUE(cell.run_until(DriverState::kReady, 3s));
}

TEST(FeetechFaults, a_short_loss_of_power_behind_a_stopped_switching_is_seen) {
  FeetechCell cell;
  cell.honest = false;
  auto motion = cell.motion_to({0.3, 0.2, 0.2}, 1);
  cell.run(motion);
  ASSERT_TRUE(cell.driver.service(DeviceService::kFree, cell.now));
  ASSERT_TRUE(cell.run_until(DriverState::kReady, 1s));
  ASSERT_TRUE(cell.driver.service(DeviceService::kHold, cell.now));
  cell.run_for(2ms);
  cell.driver.stop(cell.now);
  ASSERT_TRUE(cell.run_until(DriverState::kReady, 1s));
  cell.run_for(500ms);
  cell.events.clear();
  const bool on = !cell.driver.free();
  cell.servo(1).power_cycle(cell.now);
  cell.run_for(1s);
  EXPECT_TRUE(cell.driver.free() || on);
  if (!on) return;
  ASSERT_TRUE(cell.failure());
  EXPECT_EQ(cell.failure()->code, ErrorCode::kSupplyFlag);
}

TEST(FeetechFaults, a_host_that_comes_late_makes_no_joint_faster) {
  for (const Duration late : {100ms, 300ms}) {
    FeetechCell cell;
    auto motion = cell.motion_to({1.2, 0.5, 0.4}, 1.2);
    motion.segments = 12;  // of 100 ms
    cell.run(motion, 400ms);
    cell.be_late_by(late);
    cell.run(motion);
    EXPECT_FALSE(cell.failure()) << to_seconds(late);
    EXPECT_LE(cell.fastest, 1.1) << to_seconds(late);
    EXPECT_NEAR(cell.q(0), 1.2, kFeetechSag);
  }
}

TEST(FeetechFaults, a_host_that_wakes_a_little_late_each_time_keeps_the_pace) {
  FeetechCell cell;
  auto motion = cell.motion_to({1, 0.3, 0.3}, 2);
  const Instant limit = cell.now + 10s;
  while (motion.next <= motion.segments || cell.driver.state() == DriverState::kMoving) {
    ASSERT_LT(cell.now, limit);
    cell.feed(motion);
    cell.be_late_by(7ms);
    cell.step();
    ASSERT_FALSE(cell.refused || cell.failure());
  }
  EXPECT_LT(to_seconds(cell.now - motion.begun), 2.5);
  EXPECT_LE(cell.fastest, 1.05);
}

TEST(FeetechFaults, corrections_do_not_add_up_against_something_near_the_target) {
  FeetechCell cell;
  cell.machine.disturb({Disturb::kBlock, 0, 0.4895});
  for (int k = 0; k < 12; ++k) {
    auto motion = cell.motion_to({0.5, 0, 0}, 1);
    motion.from[0] = k == 0 ? motion.from[0] : 0.5;
    cell.refused.reset();
    cell.run(motion);
    cell.run_for(300ms);
  }
  const auto goal = cell.servo(0).read(Register::kGoal, 2).value();
  const double told = word_at({goal.data(), goal.size()}, 0, std::endian::little);
  EXPECT_LT(told - 2048, 0.53 * 4096 / (2 * kPi));
  EXPECT_EQ(cell.driver.state(), DriverState::kReady);
}

TEST(FeetechFaults, stops_do_not_let_a_loaded_arm_sink_step_by_step) {
  FeetechCell cell;
  auto first = cell.motion_to({0, 0.4, 0.2}, 1);
  cell.run(first);
  cell.honest = false;  // a push is seen at the next question
  cell.machine.disturb({Disturb::kLoad, 1, 0.9});
  cell.run_for(1s);
  const double begun = cell.q(1);
  for (int k = 0; k < 8; ++k) {
    auto motion = cell.motion_to({k % 2 == 0 ? 0.4 : 0.0, cell.driver.positions()[1].q, 0.2}, 1);
    cell.run(motion, 500ms);
    cell.driver.stop(cell.now);
    ASSERT_TRUE(cell.run_until(DriverState::kReady, 2s));
  }
  EXPECT_FALSE(cell.refused);
  EXPECT_NEAR(cell.q(1), begun, 0.05);
}

TEST(FeetechFaults, a_stream_that_ends_brakes_as_the_joints_may) {
  FeetechCell cell;
  auto motion = cell.motion_to({1.4, 0.2, 0.2}, 1.2);
  cell.run(motion, 600ms);
  const double there = cell.q(0);
  cell.run_for(2s);
  ASSERT_TRUE(cell.failure());
  EXPECT_EQ(cell.failure()->code, ErrorCode::kStreamEnded);
  EXPECT_GT(cell.q(0), there + 0.15) << "80 ms of motion, and a braking distance";
}

TEST(FeetechFaults, replies_over_a_slow_network_are_waited_for) {
  FeetechCell cell(feetech_robot(), {.late = 30ms});
  auto motion = cell.motion_to({0.8, 0.3, 0.3}, 1.5);
  cell.run(motion);
  EXPECT_FALSE(cell.failure());
  EXPECT_EQ(cell.driver.state(), DriverState::kReady);
  EXPECT_NEAR(cell.q(0), 0.8, kFeetechSag);
}

TEST(FeetechFaults, whatever_the_line_does_every_claim_holds_and_every_command_ends) {
  test::for_random_cases(60, [](test::Random& random) {
    test::FeetechCellOptions options;
    options.faults.seed = random.bits();
    for (sim::ByteFaults& way : options.faults.bytes) {
      way.flip = random.chance(0.5) ? random.uniform(0, 2e-4) : 0;
      way.drop = random.chance(0.5) ? random.uniform(0, 1e-3) : 0;
      way.duplicate = random.chance(0.3) ? random.uniform(0, 1e-3) : 0;
    }
    options.late = random.chance(0.3) ? 5ms : 0ms;
    FeetechCell cell(feetech_robot(random.chance(0.3) ? FeetechSeries::kScs : FeetechSeries::kSts),
                     options);
    std::size_t accepted = 0;
    for (int k = 0; k < 4; ++k) {
      JointVector to;
      for (int i = 0; i < 3; ++i) to.push_back(random.uniform(-1, 1));
      auto motion = cell.motion_to(to, random.uniform(1.5, 2.5));
      cell.refused.reset();
      cell.run(motion, std::chrono::milliseconds(random.integer(100, 3000)));
      accepted += motion.next - 1;
      if (random.chance(0.4)) cell.driver.stop(cell.now);
      cell.run_for(1500ms);
      if (cell.driver.state() == DriverState::kFault && cell.driver.clear_fault(cell.now)) {
        ++accepted;
        cell.run_for(1s);
      }
    }
    ASSERT_NE(cell.driver.state(), DriverState::kMoving);
    const std::size_t ends =
        cell.count(Kind::kDone) + cell.count(Kind::kFailed) + cell.count(Kind::kStopped);
    ASSERT_GE(ends, accepted);
    ASSERT_LE(cell.fastest, 2.0);
  });
}

}  // namespace
}  // namespace sinew
