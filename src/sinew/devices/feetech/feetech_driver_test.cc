#include "sinew/devices/feetech/feetech_driver.h"

#include <gtest/gtest.h>

#include "sinew/core/error_code.h"
#include "sinew/devices/feetech/feetech_test_cell.h"

namespace sinew {
namespace {

using namespace std::chrono_literals;
using namespace feetech;
using test::feetech_robot;
using test::FeetechCell;
using test::kFeetechSag;
using Kind = DriverEvent::Kind;

TEST(FeetechDriver, opens_and_measures_without_moving_anything) {
  FeetechCell cell(feetech_robot(), {.opened = false});
  cell.driver.open(cell.now);
  EXPECT_EQ(cell.driver.state(), DriverState::kOpening);
  EXPECT_TRUE(cell.run_until(DriverState::kReady, 1s));
  EXPECT_EQ(cell.count(Kind::kReady), 1U);
  for (std::size_t i = 0; i < 3; ++i) {
    EXPECT_EQ(cell.driver.positions()[i].quality, PositionQuality::kMeasured);
    EXPECT_NEAR(cell.driver.positions()[i].q, cell.q(i), 0.002);
  }
  const DriverHealth health = cell.driver.health();
  EXPECT_NEAR(health.supply_volts.value(), 7.4, 0.1);
  EXPECT_NEAR(health.temperature_c.value(), 25, 1);
  ASSERT_TRUE(health.jaws_width);
  EXPECT_NEAR(*health.jaws_width, cell.machine.truth().tool, 1e-3);
}

TEST(FeetechDriver, a_streamed_motion_arrives_in_its_time_and_each_piece_is_done_once) {
  FeetechCell cell;
  auto motion = cell.motion_to({1, -0.6, 0.4}, 1.2);
  cell.run(motion);
  EXPECT_EQ(cell.driver.state(), DriverState::kReady);
  EXPECT_NEAR(to_seconds(cell.now - motion.begun), 1.2, 0.2);
  EXPECT_EQ(cell.count(Kind::kDone), 60U);
  EXPECT_EQ(cell.events.size(), 60U);
  EXPECT_NEAR(cell.q(0), 1, kFeetechSag);
  EXPECT_NEAR(cell.q(1), -0.6, kFeetechSag);
  EXPECT_NEAR(cell.q(2), 0.4, kFeetechSag);
  EXPECT_LE(cell.fastest, 1.05);
}

TEST(FeetechDriver, follows_its_path_on_the_way) {
  FeetechCell cell;
  const JointVector to{1.2, 0.5, -0.5};
  auto motion = cell.motion_to(to, 1.5);
  const JointVector from = motion.from;
  double worst = 0;
  while (motion.next <= motion.segments || cell.driver.state() == DriverState::kMoving) {
    cell.feed(motion);
    cell.step();
    const double t = std::min(1.0, to_seconds(cell.now - motion.begun) / 1.5);
    const double planned = from[0] + (to[0] - from[0]) * (1 - std::cos(kPi * t)) / 2;
    worst = std::max(worst, std::abs(cell.q(0) - planned));
  }
  EXPECT_LT(worst, 0.12) << "rad, at up to 1.3 rad/s: a tick, and the servo's own lag";
}

TEST(FeetechDriver, stop_brakes_each_joint_and_ends_every_command_once) {
  FeetechCell cell;
  auto motion = cell.motion_to({1.4, -0.6, 0.4}, 1.2);
  cell.run(motion, 600ms);
  const std::size_t accepted = motion.next - 1;
  const double there = cell.q(0);
  cell.driver.stop(cell.now);
  EXPECT_EQ(cell.driver.state(), DriverState::kStopping);
  EXPECT_TRUE(cell.run_until(DriverState::kReady, 2s));
  EXPECT_EQ(cell.count(Kind::kDone) + cell.count(Kind::kStopped), accepted);
  EXPECT_GT(cell.q(0), there);
  EXPECT_LT(cell.q(0), there + 0.35);
  auto back = cell.motion_to({0, 0, 0}, 1.2);
  cell.run(back);
  EXPECT_FALSE(cell.refused);
  EXPECT_NEAR(cell.q(0), 0, kFeetechSag);
}

TEST(FeetechDriver, a_stop_at_rest_ends_at_once) {
  FeetechCell cell;
  cell.driver.stop(cell.now);
  cell.run_for(50ms);
  EXPECT_EQ(cell.count(Kind::kStopped), 1U);
  EXPECT_EQ(cell.driver.state(), DriverState::kReady);
}

TEST(FeetechDriver, a_stream_that_ends_too_early_is_a_failure_and_the_arm_stands) {
  FeetechCell cell;
  auto motion = cell.motion_to({1, 0.5, 0.5}, 1.2);
  cell.feed(motion);
  cell.run_for(1s);
  ASSERT_TRUE(cell.failure());
  EXPECT_EQ(cell.failure()->code, ErrorCode::kStreamEnded);
  EXPECT_EQ(cell.driver.state(), DriverState::kReady);
  EXPECT_FALSE(cell.machine.truth().moving);
}

TEST(FeetechDriver, a_limp_arm_is_held_where_it_is_before_it_moves) {
  FeetechCell cell;
  ASSERT_TRUE(cell.driver.service(DeviceService::kFree, cell.now));
  EXPECT_TRUE(cell.run_until(DriverState::kReady, 1s));
  EXPECT_EQ(cell.count(Kind::kDone), 1U);
  EXPECT_TRUE(cell.driver.free());
  cell.run_for(2s);
  EXPECT_FALSE(cell.machine.truth().moving) << "it has sunk";
  EXPECT_GT(std::abs(cell.q(1)), 0.5);
  cell.events.clear();
  double fastest = 0;
  auto motion = cell.motion_to({0.3, 0.2, 0.2}, 2);
  motion.from = {cell.q(0), cell.q(1), cell.q(2)};
  cell.feed(motion);
  for (int i = 0; i < 1500; ++i) {  // 150 ms of lead
    cell.step();
    fastest = std::max(fastest, std::abs(cell.machine.truth().joints[1].qd));
  }
  EXPECT_LT(fastest, 1.0) << "nothing jumps as motors come on";
  cell.run(motion);
  EXPECT_FALSE(cell.refused);
  EXPECT_FALSE(cell.driver.free());
  EXPECT_NEAR(cell.q(1), 0.2, kFeetechSag);
}

TEST(FeetechDriver, hold_ends_free_drive_where_a_hand_has_left_the_arm) {
  FeetechCell cell;
  ASSERT_TRUE(cell.driver.service(DeviceService::kFree, cell.now));
  ASSERT_TRUE(cell.run_until(DriverState::kReady, 1s));
  cell.run_for(1s);
  const double there = cell.q(1);
  ASSERT_TRUE(cell.driver.service(DeviceService::kHold, cell.now));
  ASSERT_TRUE(cell.run_until(DriverState::kReady, 1s));
  cell.run_for(1s);
  EXPECT_FALSE(cell.driver.free());
  EXPECT_NEAR(cell.q(1), there, kFeetechSag);
  EXPECT_EQ(cell.driver.service(DeviceService::kWake, cell.now).error().code,
            ErrorCode::kNoSuchService);
}

TEST(FeetechDriver, jaws_go_to_their_width) {
  FeetechCell cell;
  for (const double width : {0.05, 0.0, 0.03}) {
    cell.events.clear();
    ASSERT_TRUE(cell.driver.tool(JawsTo{width}, cell.now));
    ASSERT_TRUE(cell.run_until(DriverState::kReady, 3s));
    EXPECT_EQ(cell.count(Kind::kDone), 1U);
    EXPECT_NEAR(cell.machine.truth().tool, width, 1e-3);
    EXPECT_NEAR(cell.driver.health().jaws_width.value(), width, 1e-3);
  }
  EXPECT_EQ(cell.driver.tool(JawsTo{0.06}, cell.now).error().code, ErrorCode::kJawWidth);
  EXPECT_EQ(cell.driver.tool(Suction{}, cell.now).error().code, ErrorCode::kToolNotFitted);
}

TEST(FeetechDriver, jaws_hold_a_thing_with_part_of_their_torque_and_for_long) {
  FeetechCell cell;
  ASSERT_TRUE(cell.driver.tool(JawsTo{0.05}, cell.now));
  ASSERT_TRUE(cell.run_until(DriverState::kReady, 3s));
  cell.machine.disturb({sim::Disturbance::Kind::kBlock, 3, 0.025});
  ASSERT_TRUE(cell.driver.tool(JawsTo{0}, cell.now));
  ASSERT_TRUE(cell.run_until(DriverState::kReady, 3s));
  EXPECT_NEAR(cell.driver.health().jaws_width.value(), 0.025, 1e-3);
  cell.run_for(10s);
  EXPECT_EQ(cell.driver.state(), DriverState::kReady);
  EXPECT_EQ(cell.servo(3).trouble(), 0) << "it does not overload";
  EXPECT_GT(cell.servo(3).command().torque, 0);
  cell.events.clear();
  ASSERT_TRUE(cell.driver.tool(JawsTo{0.05}, cell.now));
  ASSERT_TRUE(cell.run_until(DriverState::kReady, 3s));
  EXPECT_NEAR(cell.machine.truth().tool, 0.05, 1e-3);
}

TEST(FeetechDriver, refuses_what_it_cannot_do) {
  FeetechCell cell;
  const auto here = [&] { return JointVector{cell.q(0), cell.q(1), cell.q(2)}; };
  const auto code = [&](const JointMove& move) {
    return cell.driver.move(move, cell.now).error().code;
  };
  EXPECT_EQ(code({{0, 0}, {0, 0}, 1s, {}}), ErrorCode::kUnsendable);
  EXPECT_EQ(code({{1.6, 0, 0}, {0, 0, 0}, 1s, here()}), ErrorCode::kJointLimit);
  EXPECT_EQ(code({{1.4, 0, 0}, {0, 0, 0}, 100ms, here()}), ErrorCode::kSegmentTime);
  EXPECT_EQ(code({{0, 0, 0}, {0, 0, 0}, 1s, {0.5, 0, 0}}), ErrorCode::kMovedUnasked);
  EXPECT_EQ(code({{0, 0, 0}, {0, NAN, 0}, 1s, here()}), ErrorCode::kUnsendable);
  cell.driver.close(cell.now);
  EXPECT_EQ(code({{0, 0, 0}, {0, 0, 0}, 1s, {}}), ErrorCode::kPortClosed);
  EXPECT_EQ(cell.driver.positions()[0].quality, PositionQuality::kLost);
}

TEST(FeetechDriver, servos_of_the_scs_series_move_alike) {
  FeetechCell cell(feetech_robot(FeetechSeries::kScs));
  auto motion = cell.motion_to({0.8, -0.4, 0.4}, 1.2);
  cell.run(motion);
  EXPECT_EQ(cell.driver.state(), DriverState::kReady);
  EXPECT_NEAR(cell.q(0), 0.8, 2 * kFeetechSag);
  EXPECT_NEAR(cell.q(1), -0.4, 2 * kFeetechSag);
  ASSERT_TRUE(cell.driver.tool(JawsTo{0.02}, cell.now));
  ASSERT_TRUE(cell.run_until(DriverState::kReady, 3s));
  EXPECT_NEAR(cell.machine.truth().tool, 0.02, 2e-3);
}

TEST(FeetechDriver, an_adapter_that_echoes_and_one_that_is_slow_change_nothing) {
  for (const auto& options :
       {test::FeetechCellOptions{.echo = true}, test::FeetechCellOptions{.late = 12ms}}) {
    FeetechCell cell(feetech_robot(), options);
    auto motion = cell.motion_to({1, 0.3, 0.3}, 1.2);
    cell.run(motion);
    EXPECT_EQ(cell.driver.state(), DriverState::kReady);
    EXPECT_EQ(cell.count(Kind::kDone), 60U);
    EXPECT_NEAR(cell.q(0), 1, kFeetechSag);
    EXPECT_EQ(cell.driver.health().timeouts, 0U);
  }
}

TEST(FeetechDriver, the_next_run_takes_over_an_arm_that_is_held) {
  FeetechCell cell;
  auto motion = cell.motion_to({0.7, 0.5, 0.3}, 1.2);
  cell.run(motion);
  cell.driver.close(cell.now);
  cell.run_for(1s);
  EXPECT_NEAR(cell.q(0), 0.7, kFeetechSag) << "servos hold";
  cell.open();
  EXPECT_FALSE(cell.driver.free());
  auto back = cell.motion_to({0, 0, 0}, 1.2);
  cell.run(back);
  EXPECT_FALSE(cell.refused);
  EXPECT_NEAR(cell.q(1), 0, kFeetechSag);
}

}  // namespace
}  // namespace sinew
