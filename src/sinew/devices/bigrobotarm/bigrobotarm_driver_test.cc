#include "sinew/devices/bigrobotarm/bigrobotarm_driver.h"

#include <gtest/gtest.h>

#include <cmath>

#include "sinew/core/error_code.h"
#include "sinew/core/units.h"
#include "sinew/devices/bigrobotarm/bigrobotarm_test_cell.h"
#include "support/allocation_guard.h"

namespace sinew {
namespace {

using namespace std::chrono_literals;
using Kind = DriverEvent::Kind;
using test::BigRobotArmCell;
using test::kThere;

double distance(const BigRobotArmCell& cell, const std::array<double, 5>& q) {
  const sim::Truth truth = cell.machine.truth();
  double most = 0;
  for (std::size_t i = 0; i < 5; ++i) most = std::max(most, std::abs(truth.joints[i].q - q[i]));
  return most;
}

PositionQuality worst(const BigRobotArmCell& cell) {
  PositionQuality quality = PositionQuality::kMeasured;
  for (const auto& one : cell.driver.positions()) quality = std::min(quality, one.quality);
  return quality;
}

/// What the device hears while nobody of ours has said it.
void order(BigRobotArmCell& cell, const bigrobotarm::Request& request) {
  const auto bytes = bigrobotarm::byte::encode_request(request);
  cell.machine.receive({bytes.data(), bytes.size()}, cell.now);
  const std::uint8_t end = bigrobotarm::byte::kTerminator;
  cell.machine.receive({&end, 1}, cell.now);
}

class EveryDevice : public ::testing::TestWithParam<std::tuple<BigRobotArmProfile, int>> {
 protected:
  RobotModel robot() const {
    const int kind = std::get<1>(GetParam());
    return test::big_robot_arm(kind == 0 ? BigRobotArmWire::kByte : BigRobotArmWire::kText,
                               kind == 2 ? BigRobotArmDialect::k2026 : BigRobotArmDialect::k2021);
  }
  BigRobotArmProfile profile() const { return std::get<0>(GetParam()); }
};
INSTANTIATE_TEST_SUITE_P(BigRobotArm, EveryDevice,
                         ::testing::Combine(::testing::Values(BigRobotArmProfile::kDocument,
                                                              BigRobotArmProfile::kAsBuilt,
                                                              BigRobotArmProfile::kOwn),
                                            ::testing::Values(0, 1, 2)));

TEST_P(EveryDevice, move_goes_there_and_joints_arrive_together) {
  BigRobotArmCell cell(robot(), profile());
  cell.make_ready();
  ASSERT_TRUE(cell.driver.move(cell.move_to(kThere), cell.now));
  EXPECT_FALSE(cell.driver.wants_move(cell.now));
  std::array<double, 5> arrived{};
  const Instant start = cell.now;
  while (cell.driver.state() == DriverState::kMoving) {
    cell.run(20ms);
    EXPECT_EQ(cell.liar(), -1);
    const sim::Truth truth = cell.machine.truth();
    for (std::size_t i = 0; i < 5; ++i) {
      const bool there = std::abs(truth.joints[i].q - kThere[i]) < 0.02;
      if (there && arrived[i] == 0) arrived[i] = to_seconds(cell.now - start);
    }
  }
  EXPECT_EQ(cell.kinds(), (std::vector{Kind::kDone}));
  EXPECT_LT(distance(cell, kThere), 0.03);
  EXPECT_EQ(worst(cell), PositionQuality::kCommanded);
  if (profile() == BigRobotArmProfile::kAsBuilt) return;  // its processor has its own mind
  for (const double time : arrived) EXPECT_NEAR(time, arrived[2], 0.15 * arrived[2]);
}

TEST_P(EveryDevice, move_takes_no_less_than_it_was_given) {
  BigRobotArmCell cell(robot(), profile());
  cell.make_ready();
  const Instant start = cell.now;
  ASSERT_TRUE(cell.driver.move(cell.move_to(kThere, 12s), cell.now));
  cell.run_until(DriverState::kReady);
  EXPECT_EQ(cell.kinds(), (std::vector{Kind::kDone}));
  EXPECT_NEAR(to_seconds(cell.now - start), 12, 0.08 * 12);
}

TEST_P(EveryDevice, port_that_resets_the_board_costs_the_right_to_move_until_declared) {
  BigRobotArmCell cell(robot(), profile());
  cell.make_ready();
  ASSERT_TRUE(cell.driver.move(cell.move_to(kThere), cell.now));
  cell.run_until(DriverState::kReady);
  cell.driver.close(cell.now);
  cell.machine.port_opened(cell.now);
  cell.driver.open(cell.now);
  cell.run_until(DriverState::kReady);
  EXPECT_EQ(worst(cell), PositionQuality::kUncertain);
  EXPECT_EQ(cell.liar(), -1);
  EXPECT_EQ(cell.driver.move(cell.move_to({}), cell.now).error().code, ErrorCode::kPositionUnknown);
  // Recorded as it is: moves are taken, and stay as uncertain as the place they began at.
  const std::vector<JointPosition> known(cell.driver.positions().begin(),
                                         cell.driver.positions().end());
  cell.driver.declare_positions(known);
  ASSERT_TRUE(cell.driver.move(cell.move_to({}), cell.now));
  cell.run_until(DriverState::kReady);
  EXPECT_EQ(worst(cell), PositionQuality::kUncertain);
  EXPECT_EQ(cell.liar(), -1);
  EXPECT_LT(distance(cell, {}), 0.12);
}

TEST_P(EveryDevice, stop_lets_the_motion_under_way_end_and_says_so_then) {
  for (const auto after : {0us, 100us, 1000us, 8000us, 200'000us, 1'000'000us}) {
    BigRobotArmCell cell(robot(), profile());
    cell.make_ready();
    ASSERT_TRUE(cell.driver.move(cell.move_to(kThere), cell.now));
    cell.run(after);
    cell.driver.stop(cell.now);
    cell.run_until(DriverState::kReady);
    cell.run(1ms);
    EXPECT_EQ(cell.kinds(), (std::vector{Kind::kStopped})) << after.count();
    EXPECT_FALSE(cell.machine.firmware().moving());
    EXPECT_EQ(cell.liar(), -1);
    ASSERT_TRUE(cell.driver.move(cell.move_to({}), cell.now)) << after.count();
    cell.run_until(DriverState::kReady);
    EXPECT_EQ(cell.count(Kind::kDone), 1);
  }
}

TEST_P(EveryDevice, stop_of_a_long_motion_says_until_when_it_goes_on) {
  BigRobotArmCell cell(robot(), profile());
  cell.make_ready();
  EXPECT_FALSE(cell.driver.goes_on_until());
  ASSERT_TRUE(cell.driver.move(cell.move_to(kThere, 20s), cell.now));
  cell.run(2s);
  cell.driver.stop(cell.now);
  const Instant asked = cell.now;
  bool told = true;
  std::optional<Instant> until;
  cell.run_to(cell.now + 60s, [&] {
    if (cell.driver.state() != DriverState::kStopping) return true;
    until = cell.driver.goes_on_until();
    told = told && until.has_value();
    return false;
  });
  EXPECT_TRUE(told);
  EXPECT_GT(cell.now - asked, 10s);
  EXPECT_LE(cell.now, until.value_or(asked));
  EXPECT_FALSE(cell.driver.goes_on_until());
}

/// The next host's driver, told what a journal had of the one before.
void next_host(BigRobotArmCell& cell, std::span<const JointPosition> recorded,
               const DriverMemory& memory = {}) {
  cell.driver = BigRobotArmDriver(cell.device(), cell.robot.joints);
  cell.driver.remember(memory);
  cell.to_machine.clear();
  cell.to_host.clear();
  cell.events.clear();
  cell.driver.declare_positions(recorded);
  cell.driver.open(cell.now);
  cell.run_until(DriverState::kReady);
}

std::vector<JointPosition> recorded(const BigRobotArmCell& cell) {
  return {cell.driver.positions().begin(), cell.driver.positions().end()};
}

TEST_P(EveryDevice, count_settles_where_a_host_left_the_board_that_died_at_any_instant) {
  for (const auto after : {0us, 300us, 2000us, 20'000us, 400'000us, 1'500'000us, 4'000'000us}) {
    BigRobotArmCell cell(robot(), profile());
    cell.make_ready();
    ASSERT_TRUE(cell.driver.move(cell.move_to({0.1, 0.1, 0, 0, 0.2}), cell.now));
    cell.run_until(DriverState::kReady);
    ASSERT_TRUE(cell.driver.move(cell.move_to(kThere), cell.now));
    cell.run(after);
    // As an intent has it: somewhere on the way.
    std::vector<JointPosition> told = recorded(cell);
    for (std::size_t i = 0; i < told.size(); ++i) {
      told[i].quality = PositionQuality::kUncertain;
      told[i].lower = std::min(told[i].lower, kThere[i] - 0.005);
      told[i].upper = std::max(told[i].upper, kThere[i] + 0.005);
    }
    next_host(cell, told);
    EXPECT_EQ(worst(cell), PositionQuality::kCommanded) << after.count();
    EXPECT_EQ(cell.liar(), -1) << after.count();
    for (std::size_t i = 0; i < told.size(); ++i) {
      const BigRobotArmJoint& own = cell.device().joints[i];
      const double full_step = own.steps_per_motor_rev / 200 / std::abs(own.steps_per_rad);
      const JointPosition& joint = cell.driver.positions()[i];
      EXPECT_LE(joint.upper - joint.lower, 6 * full_step + 1e-9) << after.count() << ", " << i;
    }
    ASSERT_TRUE(cell.driver.move(cell.move_to({}), cell.now));
    cell.run_until(DriverState::kReady);
    EXPECT_LT(distance(cell, {}), from_deg(0.7));
  }
}

TEST_P(EveryDevice, board_that_was_reset_behind_a_dead_host_stays_uncertain) {
  BigRobotArmCell cell(robot(), profile());
  cell.make_ready();
  ASSERT_TRUE(cell.driver.move(cell.move_to(kThere), cell.now));
  cell.run(300ms);
  const std::vector<JointPosition> told = recorded(cell);
  ASSERT_TRUE(told[0].count_zero);
  cell.machine.port_opened(cell.now);
  next_host(cell, told);
  EXPECT_EQ(worst(cell), PositionQuality::kUncertain);
  EXPECT_EQ(cell.liar(), -1);
  EXPECT_FALSE(cell.driver.positions()[0].count_zero) << "its count begins anew";
}

TEST(BigRobotArmDriver, count_against_what_is_recorded_loses_the_position_and_says_both) {
  BigRobotArmCell cell;
  cell.make_ready();
  ASSERT_TRUE(cell.driver.move(cell.move_to(kThere), cell.now));
  cell.run_until(DriverState::kReady);
  const std::vector<JointPosition> told = recorded(cell);
  // Another program has it meanwhile.
  order(cell, bigrobotarm::Goto{{1000, 0, 0, 0, 0}});
  cell.run(10s);
  next_host(cell, told);
  EXPECT_EQ(worst(cell), PositionQuality::kLost);
  const double counted = 1000 / cell.device().joints[0].steps_per_rad;
  const auto notice = std::ranges::find(cell.events, Kind::kNotice, &DriverEvent::kind);
  ASSERT_NE(notice, cell.events.end());
  EXPECT_EQ(notice->error.code, ErrorCode::kCountedElsewhere);
  EXPECT_EQ(notice->error.index, 0);
  EXPECT_NEAR(notice->error.measured, kThere[0], 0.01);
  EXPECT_NEAR(notice->error.limit, counted, 0.01);
  // It is evidence for whoever says where it stands, in the process after the next one too.
  next_host(cell, recorded(cell));
  const auto evidence = cell.driver.counted(0);
  ASSERT_TRUE(evidence);
  EXPECT_LT(evidence->lower, counted);
  EXPECT_GT(evidence->upper, counted);
  EXPECT_LT(evidence->upper - evidence->lower, from_deg(1.5));
}

TEST(BigRobotArmDriver, without_a_record_the_count_is_evidence_for_whoever_says_home) {
  BigRobotArmCell cell;
  cell.make_ready();
  ASSERT_TRUE(cell.driver.move(cell.move_to(kThere), cell.now));
  cell.run_until(DriverState::kReady);
  cell.driver = BigRobotArmDriver(cell.device(), cell.robot.joints);
  cell.driver.open(cell.now);
  cell.run_until(DriverState::kReady);
  EXPECT_EQ(worst(cell), PositionQuality::kLost);
  for (std::size_t i = 0; i < kThere.size(); ++i) {
    const auto counted = cell.driver.counted(i);
    ASSERT_TRUE(counted) << i;
    EXPECT_LT(counted->lower, kThere[i]) << i;
    EXPECT_GT(counted->upper, kThere[i]) << i;
  }
}

TEST(BigRobotArmDriver, slow_move_of_a_host_that_died_is_waited_for_to_its_end) {
  BigRobotArmCell cell;
  cell.make_ready();
  ASSERT_TRUE(cell.driver.move(cell.move_to(kThere, 60s), cell.now));
  cell.run(6s);
  std::vector<JointPosition> told = recorded(cell);
  const Instant opened = cell.now;
  next_host(cell, told, {.ended_in_motion = true, .since = 6s});
  EXPECT_EQ(cell.driver.state(), DriverState::kReady);
  EXPECT_EQ(cell.kinds(), std::vector{Kind::kReady}) << "never told as silent";
  EXPECT_GT(cell.now - opened, 40s);
  EXPECT_EQ(worst(cell), PositionQuality::kCommanded);
  EXPECT_EQ(cell.liar(), -1);
  // How long it may still take is told, and becomes less as time passes between the two.
  const auto waits = [&](Duration since) {
    BigRobotArmDriver next(cell.device(), cell.robot.joints);
    next.declare_positions(told);
    next.remember({.ended_in_motion = true, .since = since});
    next.open(cell.now);
    const auto until = next.goes_on_until();
    return until ? *until - cell.now : Duration{};
  };
  EXPECT_GT(waits(6s), 54s);
  EXPECT_NEAR(to_seconds(waits(6s) - waits(36s)), 30, 1e-6);
  EXPECT_EQ(waits(std::chrono::hours(10)), Duration{});
}

TEST(BigRobotArmDriver, counters_reset_where_it_stands_leave_the_place_and_read_zero) {
  BigRobotArmCell cell;
  cell.make_ready();
  ASSERT_TRUE(cell.driver.move(cell.move_to(kThere), cell.now));
  cell.run_until(DriverState::kReady);
  const std::vector<JointPosition> before = recorded(cell);
  ASSERT_TRUE(cell.driver.zero_counters(cell.now));
  cell.run_until(DriverState::kReady);
  EXPECT_EQ(cell.count(Kind::kDone), 2);
  for (std::size_t i = 0; i < before.size(); ++i) {
    const JointPosition& joint = cell.driver.positions()[i];
    EXPECT_EQ(joint.quality, PositionQuality::kCommanded);
    EXPECT_NEAR(joint.q, before[i].q, 1e-12);
    EXPECT_NEAR(joint.count_zero.value_or(9), before[i].q, 1e-12);
  }
  ASSERT_TRUE(cell.driver.move(cell.move_to({}), cell.now));
  cell.run_until(DriverState::kReady);
  EXPECT_LT(distance(cell, {}), from_deg(0.3));
}

TEST_P(EveryDevice, gripper_jumps_and_its_range_is_kept) {
  BigRobotArmCell cell(robot(), profile());
  cell.make_ready();
  ASSERT_TRUE(cell.driver.tool(GripperTo{true, from_deg(40)}, cell.now));
  cell.run_until(DriverState::kReady);
  EXPECT_EQ(cell.kinds(), (std::vector{Kind::kDone}));
  EXPECT_NEAR(cell.machine.truth().tool, from_deg(40), 1e-9);
  ASSERT_TRUE(cell.driver.tool(GripperTo{false, {}}, cell.now));
  cell.run_until(DriverState::kReady);
  EXPECT_FALSE(cell.machine.firmware().gripper().enabled);
  ASSERT_TRUE(cell.driver.tool(GripperTo{true, {}}, cell.now));
  cell.run_until(DriverState::kReady);
  EXPECT_EQ(cell.machine.firmware().gripper(), (bigrobotarm::Gripper{true, 40}));
  EXPECT_EQ(cell.driver.tool(GripperTo{true, from_deg(181)}, cell.now).error().code,
            ErrorCode::kGripperRange);
  EXPECT_EQ(cell.driver.tool(GripperTo{true, std::nan("")}, cell.now).error().code,
            ErrorCode::kGripperRange);
  EXPECT_EQ(cell.driver.tool(Suction{}, cell.now).error().code, ErrorCode::kToolNotFitted);
  EXPECT_EQ(cell.driver.home(cell.now).error().code, ErrorCode::kTaskNotSupported);
}

TEST_P(EveryDevice, gripper_that_nobody_has_told_is_switched_on_only_where_it_says_its_place) {
  BigRobotArmCell cell(robot(), profile());
  cell.make_ready();
  const bigrobotarm::Gripper before = cell.machine.firmware().gripper();
  const auto on = cell.driver.tool(GripperTo{true, {}}, cell.now);
  if (on) {
    cell.run_until(DriverState::kReady);
    EXPECT_EQ(cell.machine.firmware().gripper(), (bigrobotarm::Gripper{true, before.position}));
  } else {
    EXPECT_EQ(on.error().code, ErrorCode::kNotMeasured);
    EXPECT_EQ(cell.machine.firmware().gripper(), before);
  }
}

TEST(BigRobotArmDriver, nothing_moves_before_somebody_says_where_the_arm_stands) {
  BigRobotArmCell cell;
  EXPECT_EQ(cell.driver.move(cell.move_to(kThere), cell.now).error().code, ErrorCode::kPortClosed);
  cell.driver.open(cell.now);
  EXPECT_EQ(cell.driver.move(cell.move_to(kThere), cell.now).error().code, ErrorCode::kBusy);
  cell.run_until(DriverState::kReady);
  EXPECT_EQ(cell.kinds(), (std::vector{Kind::kReady}));
  EXPECT_EQ(worst(cell), PositionQuality::kLost);
  EXPECT_EQ(cell.driver.move(cell.move_to(kThere), cell.now).error().code,
            ErrorCode::kPositionUnknown);
}

TEST(BigRobotArmDriver, journal_told_before_the_port_opens_is_uncertain_after_a_reset) {
  BigRobotArmCell cell;
  std::array<JointPosition, 5> upright{};
  for (auto& one : upright) one = {PositionQuality::kCommanded, 0, 0, 0};
  cell.driver.declare_positions(upright);
  cell.driver.open(cell.now);
  cell.run_until(DriverState::kReady);
  EXPECT_EQ(worst(cell), PositionQuality::kUncertain);
  EXPECT_EQ(cell.liar(), -1) << "two full steps are what a power stage may snap by";
}

TEST(BigRobotArmDriver, values_out_of_range_never_leave) {
  BigRobotArmCell cell;
  cell.make_ready();
  for (const double bad : {2.0, -2.0, std::nan(""), HUGE_VAL}) {
    EXPECT_EQ(cell.driver.move(cell.move_to({0, bad, 0, 0, 0}), cell.now).error().code,
              ErrorCode::kJointLimit);
  }
  JointMove rolling = cell.move_to(kThere);
  rolling.qd[0] = 0.1;
  EXPECT_EQ(cell.driver.move(rolling, cell.now).error().code, ErrorCode::kTaskNotSupported);
  const double unsendable =
      cell.driver.positions()[0].q + 3400 / cell.device().joints[0].steps_per_rad;
  const auto refused = cell.driver.move(cell.move_to({unsendable, 0, 0, 0, 0}), cell.now);
  EXPECT_EQ(refused.error(), (Error{ErrorCode::kUnsendable, 0, 3400, 0}));
  cell.run(1s);
  EXPECT_TRUE(cell.to_device.empty());
}

TEST(BigRobotArmDriver, reset_that_nobody_saw_is_found_before_the_arm_moves) {
  BigRobotArmCell cell;
  cell.make_ready();
  ASSERT_TRUE(cell.driver.move(cell.move_to(kThere), cell.now));
  cell.run_until(DriverState::kReady);
  cell.machine.disturb({sim::Disturbance::Kind::kSupply, -1, 3});
  cell.run(10ms);
  cell.machine.disturb({sim::Disturbance::Kind::kSupply, -1, 12});
  cell.run(3s);
  cell.events.clear();
  ASSERT_TRUE(cell.driver.move(cell.move_to({}), cell.now));
  cell.run_until(DriverState::kReady);
  EXPECT_EQ(cell.count(Kind::kFailed), 1);
  EXPECT_EQ(cell.count(Kind::kDone), 0);
  EXPECT_LT(distance(cell, kThere), 0.06) << "it did not move";
  EXPECT_EQ(worst(cell), PositionQuality::kUncertain);
  EXPECT_EQ(cell.liar(), -1);
}

TEST(BigRobotArmDriver, reset_in_motion_loses_the_position) {
  BigRobotArmCell cell;
  cell.make_ready();
  ASSERT_TRUE(cell.driver.move(cell.move_to(kThere), cell.now));
  cell.run(1s);
  cell.machine.disturb({sim::Disturbance::Kind::kSupply, -1, 3});
  cell.run(10ms);
  cell.machine.disturb({sim::Disturbance::Kind::kSupply, -1, 12});
  cell.run_until(DriverState::kReady);
  EXPECT_EQ(cell.count(Kind::kFailed), 1);
  EXPECT_EQ(worst(cell), PositionQuality::kLost);
}

TEST(BigRobotArmDriver, device_in_sync_mode_is_a_fault_until_it_is_cleared) {
  BigRobotArmCell cell;
  cell.machine.receive(std::array<std::uint8_t, 3>{7, 1, 13}, cell.now);
  cell.driver.open(cell.now);
  cell.run_until(DriverState::kFault);
  ASSERT_TRUE(cell.driver.fault());
  EXPECT_EQ(cell.driver.fault()->code, ErrorCode::kDeviceSync);
  EXPECT_EQ(cell.driver.move(cell.move_to({}), cell.now).error().code, ErrorCode::kDeviceSync);
  ASSERT_TRUE(cell.driver.clear_fault(cell.now));
  cell.run_until(DriverState::kReady);
  cell.declare();
  EXPECT_TRUE(cell.driver.move(cell.move_to({}), cell.now));
}

TEST(BigRobotArmDriver, closed_port_fails_the_move_and_the_hull_stays_true) {
  BigRobotArmCell cell;
  cell.make_ready();
  ASSERT_TRUE(cell.driver.move(cell.move_to(kThere), cell.now));
  cell.run(1s);
  cell.driver.close(cell.now);
  cell.run(5s);
  EXPECT_EQ(cell.kinds(), (std::vector{Kind::kFailed}));
  EXPECT_EQ(cell.events[0].error.code, ErrorCode::kPortClosed);
  EXPECT_EQ(worst(cell), PositionQuality::kUncertain);
  EXPECT_EQ(cell.liar(), -1);
}

TEST(BigRobotArmDriver, motion_and_reset_that_noise_ordered_lose_the_position) {
  BigRobotArmCell cell;
  cell.make_ready();
  // Back on its zero by its own counters, and not in truth.
  const std::uint8_t garbage = 0xA5;
  cell.driver.receive({&garbage, 1}, cell.now);
  order(cell, bigrobotarm::Goto{{3000, -2000, -2600, 800, -1000}});
  order(cell, bigrobotarm::Reset{});
  cell.run_until(DriverState::kReady);
  EXPECT_GT(distance(cell, {}), 0.5);
  EXPECT_EQ(worst(cell), PositionQuality::kLost);
  EXPECT_EQ(cell.driver.move(cell.move_to({}), cell.now).error().code, ErrorCode::kPositionUnknown);
}

/// A rotor pressed against an end stands anywhere between its rests, and goes to one of them when
/// the arm is told to come back: up to three full steps beside where it was seen to stand.
TEST(BigRobotArmDriver, arm_declared_where_noise_drove_it_into_its_end_is_never_elsewhere) {
  constexpr std::size_t kWrist = 4;
  for (int quarter = 0; quarter < 16; ++quarter) {
    BigRobotArmCell cell;
    cell.make_ready();
    const BigRobotArmJoint& wrist = cell.device().joints[kWrist];
    const double full_step = wrist.steps_per_motor_rev / 200 / std::abs(wrist.steps_per_rad);
    const double beyond = cell.robot.joints[kWrist].lower - 0.5 - 0.25 * quarter * full_step;
    const std::uint8_t garbage = 0xA5;
    cell.driver.receive({&garbage, 1}, cell.now);
    bigrobotarm::Goto go{};
    go.positions[kWrist] = static_cast<std::int32_t>(std::lround(beyond * wrist.steps_per_rad));
    order(cell, go);
    cell.run_until(DriverState::kReady);
    ASSERT_TRUE(cell.machine.truth().joints[kWrist].lost_steps);
    ASSERT_EQ(worst(cell), PositionQuality::kLost);
    cell.declare();
    ASSERT_TRUE(cell.driver.move(cell.move_to({0, 0, 0, 0, -1}), cell.now));
    cell.run_until(DriverState::kReady);
    EXPECT_EQ(worst(cell), PositionQuality::kCommanded);
    EXPECT_EQ(cell.liar(), -1) << quarter;
    // Its motors have turned: what is seen now is where they are.
    cell.declare();
    const JointPosition& claim = cell.driver.positions()[kWrist];
    EXPECT_NEAR(claim.upper - claim.lower, 2 * full_step, 1e-9);
  }
}

TEST(BigRobotArmDriver, interval_of_a_journal_is_kept_by_the_next_host) {
  BigRobotArmCell cell;
  cell.make_ready();
  ASSERT_TRUE(cell.driver.move(cell.move_to(kThere), cell.now));
  cell.run_until(DriverState::kReady);
  const std::vector<JointPosition> known(cell.driver.positions().begin(),
                                         cell.driver.positions().end());
  cell.driver = BigRobotArmDriver(cell.device(), cell.robot.joints);
  cell.driver.declare_positions(known);
  cell.driver.open(cell.now);
  cell.run_until(DriverState::kReady);
  for (std::size_t i = 0; i < known.size(); ++i) {
    const JointPosition& claim = cell.driver.positions()[i];
    EXPECT_EQ(claim.quality, PositionQuality::kCommanded) << i;
    EXPECT_LE(claim.lower, known[i].lower + 1e-12) << i;
    EXPECT_GE(claim.upper, known[i].upper - 1e-12) << i;
  }
}

TEST(BigRobotArmDriver, garbage_while_it_moves_on_our_order_leaves_the_position_known) {
  BigRobotArmCell cell;
  cell.make_ready();
  ASSERT_TRUE(cell.driver.move(cell.move_to(kThere), cell.now));
  cell.run(500ms);
  const std::uint8_t garbage = 0xA5;
  cell.driver.receive({&garbage, 1}, cell.now);
  cell.run_until(DriverState::kReady);
  EXPECT_EQ(cell.count(Kind::kFailed), 1);
  EXPECT_EQ(worst(cell), PositionQuality::kCommanded);
  EXPECT_LT(distance(cell, kThere), 0.06);
}

TEST(BigRobotArmDriver, cable_that_was_out_for_long_leaves_the_position_known) {
  BigRobotArmCell cell;
  cell.make_ready();
  ASSERT_TRUE(cell.driver.move(cell.move_to(kThere), cell.now));
  cell.run_until(DriverState::kReady);
  cell.cut = true;
  EXPECT_TRUE(cell.driver.move(cell.move_to({}), cell.now));
  cell.run(20s);
  cell.cut = false;
  cell.run_until(DriverState::kReady);
  EXPECT_EQ(worst(cell), PositionQuality::kCommanded);
  EXPECT_EQ(cell.liar(), -1);
}

TEST(BigRobotArmDriver, silent_device_fails_to_open_and_a_stop_ends_all_the_same) {
  BigRobotArmCell cell;
  cell.cut = true;
  cell.driver.open(cell.now);
  cell.run(9s);
  ASSERT_EQ(cell.kinds(), (std::vector{Kind::kFailed}));
  EXPECT_EQ(cell.events[0].error.code, ErrorCode::kDeviceSilent);
  cell.driver.stop(cell.now);
  cell.run(10s);
  EXPECT_EQ(cell.events.size(), 2U);
  cell.cut = false;
  cell.run_until(DriverState::kReady);
  EXPECT_EQ(cell.driver.state(), DriverState::kReady);
}

TEST(BigRobotArmDriver, stop_without_a_listener_overflows_nothing) {
  BigRobotArmCell cell;
  cell.make_ready();
  for (int i = 0; i < 100; ++i) cell.driver.stop(cell.now);
  EXPECT_EQ(cell.driver.take_event()->kind, Kind::kStopped);
  EXPECT_FALSE(cell.driver.take_event());
}

TEST(BigRobotArmDriver, exchange_does_not_allocate) {
  const RobotModel robot = test::big_robot_arm();
  BigRobotArmCell cell(robot);
  cell.make_ready();
  std::array<std::uint8_t, 128> bytes{};
  const JointMove move = cell.move_to(kThere);
  int events = 0;
  const test::AllocationCounter allocations;
  ASSERT_TRUE(cell.driver.move(move, cell.now));
  for (int i = 0; i < 800; ++i, cell.now += 10ms) {
    cell.machine.receive(std::span(bytes).first(cell.driver.take_output(bytes)), cell.now);
    cell.driver.receive(std::span(bytes).first(cell.machine.take_output(bytes)), cell.now);
    cell.driver.poll(cell.now);
    while (cell.driver.take_event()) ++events;
  }
  EXPECT_EQ(allocations.count(), 0U);
  EXPECT_EQ(events, 1);
}

TEST(BigRobotArmDriver, garbage_is_counted_byte_by_byte_also_while_it_probes) {
  for (const bool probes : {false, true}) {
    RobotModel robot = test::big_robot_arm(BigRobotArmWire::kByte, BigRobotArmDialect::k2021);
    auto& device = robot.device.settings.get<BigRobotArmDevice>();
    device.probe_wire = probes;
    BigRobotArmDriver driver(device, robot.joints);
    Instant now{};
    driver.open(now);
    std::array<std::uint8_t, 50> garbage{};
    std::array<std::uint8_t, 64> out{};
    std::optional<Error> failure;
    for (int i = 0; i < 1000; ++i) {
      now += 20ms;
      driver.receive(garbage, now);
      driver.poll(now);
      (void)driver.take_output(out);
      while (const auto event = driver.take_event()) {
        if (event->kind == Kind::kFailed) failure = event->error;
      }
    }
    EXPECT_EQ(driver.health().unexpected, 50'000U) << probes;
    ASSERT_TRUE(failure) << probes;
    EXPECT_EQ(failure->code, ErrorCode::kUnaskedReply) << probes;
  }
}

}  // namespace
}  // namespace sinew
