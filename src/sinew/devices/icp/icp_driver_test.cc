#include "sinew/devices/icp/icp_driver.h"

#include <gtest/gtest.h>

#include <cmath>
#include <iostream>
#include <vector>

#include "sinew/core/error_code.h"
#include "sinew/devices/icp/icp_test_cell.h"
#include "support/allocation_guard.h"

namespace sinew {
namespace {

using namespace std::chrono_literals;
using test::IcpCell;
using Kind = DriverEvent::Kind;

TEST(IcpDriver, opening_says_nothing_that_could_be_a_step_and_reads_all_six_modules) {
  IcpCell cell;
  std::vector<std::uint8_t> sent;
  cell.up.record = &sent;
  cell.begin();
  EXPECT_EQ(cell.now.time_since_epoch() > 200ms, true);
  std::vector<std::uint8_t> due;
  for (std::uint8_t motor = 1; motor <= 6; ++motor) {
    due.insert(due.end(), {0xFF, 0xF0, motor});
  }
  EXPECT_EQ(sent, due);
  for (std::size_t leg = 0; leg < kLegs; ++leg) {
    ASSERT_TRUE(cell.driver.status(leg).has_value());
    EXPECT_EQ(cell.driver.status(leg)->one.address, 0x61 + leg);
    EXPECT_EQ(cell.driver.status(leg)->one.parameters, icp::kMotorParameters);
  }
}

TEST(IcpDriver, nothing_is_known_and_nothing_moves_before_positions_are_declared) {
  IcpCell cell;
  cell.run_for(100ms);
  EXPECT_EQ(cell.go({1, 0, 0, 0, 0, 0}).error().code, ErrorCode::kPortClosed);
  cell.driver.open(cell.now);
  EXPECT_EQ(cell.go({1, 0, 0, 0, 0, 0}).error().code, ErrorCode::kBusy);
  cell.settle();
  ASSERT_EQ(cell.count(Kind::kReady), 1U);
  for (const auto& position : cell.driver.positions()) {
    EXPECT_EQ(position.quality, PositionQuality::kLost);
  }
  EXPECT_EQ(cell.go({1, 0, 0, 0, 0, 0}).error(), (Error{ErrorCode::kPositionUnknown, 0}));
  cell.driver.declare_positions(IcpCell::at_home());
  EXPECT_TRUE(cell.go({1, 0, 0, 0, 0, 0}));
}

TEST(IcpDriver, six_legs_go_exactly_where_they_were_sent_and_are_read_afterwards) {
  IcpCell cell;
  cell.begin();
  std::vector<std::uint8_t> sent;
  cell.up.record = &sent;
  ASSERT_TRUE(cell.go({100, -50, 0, 30, -1, 7}));
  EXPECT_EQ(cell.driver.state(), DriverState::kMoving);
  EXPECT_EQ(cell.driver.steps_left(), 188);
  cell.settle();
  EXPECT_EQ(cell.count(Kind::kDone), 1U);
  EXPECT_EQ(cell.events.size(), 1U);
  const std::array<std::int64_t, kLegs> due{100, -50, 0, 30, -1, 7};
  for (std::size_t leg = 0; leg < kLegs; ++leg) EXPECT_EQ(cell.truth(leg), due[leg]);
  cell.expect_honest();
  EXPECT_FALSE(cell.uncertain());
  // 188 moves of two bytes and six statuses of three: leg 3 is read too.
  EXPECT_EQ(sent.size(), 188U * 2 + 6 * 3);
}

TEST(IcpDriver, moves_at_the_full_speed_of_the_wire) {
  IcpCell cell;
  cell.begin();
  const Instant start = cell.now;
  ASSERT_TRUE(cell.go({400, -400, 400, -400, 400, 400}));
  cell.run_until([&] { return cell.driver.steps_left() == 0; });
  const double rate = 2400 / to_seconds(cell.now - start);
  std::cout << "  " << rate << " moves/s at 9600 baud\n";
  EXPECT_NEAR(rate, 240, 0.1);
  EXPECT_NEAR(to_seconds(cell.driver.cycle_time()), 4 * 10 / 9600.0, 1e-6);
}

TEST(IcpDriver, controllers_own_time_is_seen_in_the_time_left) {
  IcpCell cell({.processing = 10ms});
  cell.begin();
  ASSERT_TRUE(cell.go({1000, 0, 0, 0, 0, 0}));
  cell.run_for(2s);
  const double left = to_seconds(cell.driver.time_left());
  EXPECT_NEAR(left, static_cast<double>(cell.driver.steps_left()) * 14.1667e-3, 0.02 * left);
  cell.settle();
  cell.expect_honest();
}

TEST(IcpDriver, every_instant_of_a_path_is_within_one_unit_of_its_line) {
  IcpCell cell;
  cell.begin();
  const std::array<std::int64_t, kLegs> due{211, -97, 13, 0, -150, 60};
  ASSERT_TRUE(cell.go(due));
  const auto total = static_cast<double>(cell.driver.steps_left());
  while (cell.driver.steps_left() > 0) {
    cell.run_for(1ms);
    const double share = 1 - static_cast<double>(cell.driver.steps_left()) / total;
    for (std::size_t leg = 0; leg < kLegs; ++leg) {
      // A step that is made and not acknowledged yet is one more.
      EXPECT_LT(
          std::abs(static_cast<double>(cell.truth(leg)) - static_cast<double>(due[leg]) * share),
          2 + 1e-9);
    }
  }
}

TEST(IcpDriver, segments_stream_without_a_gap_and_each_ends_with_one_done) {
  IcpCell cell;
  cell.begin();
  const Instant start = cell.now;
  std::int64_t at = 0;
  for (int segment = 0; segment < 40; ++segment) {
    cell.run_until([&] { return cell.driver.wants_move(cell.now); });
    at += 6;
    ASSERT_TRUE(cell.go({at, -at, 0, 0, 0, 0}, 100ms));
  }
  cell.settle();
  EXPECT_EQ(cell.count(Kind::kDone), 40U);
  EXPECT_EQ(cell.events.size(), 40U);
  // 40 times 100 ms, then the statuses of six legs.
  EXPECT_NEAR(to_seconds(cell.now - start), 4.0 + 6 * 18 * 10 / 9600.0, 0.01);
  EXPECT_EQ(cell.truth(0), 240);
  EXPECT_EQ(cell.truth(1), -240);
}

TEST(IcpDriver, many_small_moves_add_up_without_drift) {
  IcpCell cell;
  cell.begin();
  for (int i = 1; i <= 60; ++i) {
    // 0.37 units each: most of them are no step at all.
    JointVector q = IcpCell::units_off({});
    q[2] += 0.37 * i / test::kIcpUnitsPerM;
    ASSERT_TRUE(cell.driver.move({q, {}, {}}, cell.now));
    cell.settle();
  }
  EXPECT_EQ(cell.truth(2), 22);
  EXPECT_EQ(cell.count(Kind::kDone), 60U);
}

TEST(IcpDriver, values_out_of_range_never_leave) {
  IcpCell cell;
  cell.begin();
  for (const double q : {from_mm(194.99), from_mm(345.01), std::nan(""), HUGE_VAL, -1e300}) {
    JointVector target = IcpCell::units_off({});
    target[4] = q;
    const auto moved = cell.driver.move({target, {}, {}}, cell.now);
    ASSERT_FALSE(moved);
    EXPECT_EQ(moved.error().code, ErrorCode::kLegLength);
    EXPECT_EQ(moved.error().index, 4);
  }
  EXPECT_EQ(cell.go({}, -1ms).error().code, ErrorCode::kSegmentTime);
  EXPECT_EQ(cell.go({}, 25h).error().code, ErrorCode::kSegmentTime);
  EXPECT_EQ(cell.driver.jog(0, 0, cell.now).error().code, ErrorCode::kStepRange);
  EXPECT_EQ(cell.driver.jog(0, 5000, cell.now).error().code, ErrorCode::kStepRange);
  EXPECT_EQ(cell.driver.jog(0, INT64_MIN, cell.now).error().code, ErrorCode::kStepRange);
  cell.run_for(1s);
  EXPECT_EQ(cell.up.count(), 0U);
}

TEST(IcpDriver, jog_moves_a_lost_leg_and_a_known_one_inside_its_limits) {
  IcpCell cell;
  cell.run_for(100ms);
  cell.driver.open(cell.now);
  cell.settle();
  ASSERT_TRUE(cell.driver.jog(5, -20, cell.now));
  cell.settle();
  EXPECT_EQ(cell.truth(5), -20);
  EXPECT_EQ(cell.driver.positions()[5].quality, PositionQuality::kLost);
  auto near_end = IcpCell::at_home();
  near_end[5].q = from_mm(195) + 3 / test::kIcpUnitsPerM;
  cell.driver.declare_positions(near_end);
  EXPECT_EQ(cell.driver.jog(5, -4, cell.now).error().code, ErrorCode::kLegLength);
  EXPECT_TRUE(cell.driver.jog(5, -3, cell.now));
}

TEST(IcpDriver, stop_takes_effect_with_the_exchange_in_flight_in_every_phase_of_it) {
  for (int tenths = 1; tenths < 220; ++tenths) {
    IcpCell cell;
    cell.begin();
    ASSERT_TRUE(cell.go({50, 0, 0, -50, 0, 0}));
    cell.run_for(std::chrono::microseconds(100) * tenths);
    const std::int64_t before = cell.truth(0) - cell.truth(3);
    const Instant asked = cell.now;
    cell.driver.stop(cell.now);
    EXPECT_EQ(cell.driver.state(), DriverState::kStopping);
    const Instant goes_on = cell.driver.goes_on_until().value_or(asked);
    EXPECT_LE(goes_on - asked, 60ms) << "the answer to one step";
    cell.run_for(4'200us);
    EXPECT_FALSE(cell.driver.goes_on_until());
    const std::int64_t stood = cell.truth(0) - cell.truth(3);
    EXPECT_LE(stood - before, 1);
    EXPECT_EQ(cell.count(Kind::kStopped), 0U) << "nobody has looked yet";
    EXPECT_EQ(cell.driver.state(), DriverState::kStopping);
    cell.run_until([&] { return cell.count(Kind::kStopped) == 1; });
    EXPECT_LE(cell.now - asked, 4'200us + 6 * 18'760us);
    EXPECT_EQ(cell.driver.state(), DriverState::kReady);
    EXPECT_EQ(cell.truth(0) - cell.truth(3), stood) << "a step after the stop";
    // Who leaves now leaves with all that is known.
    cell.driver.close(cell.now);
    EXPECT_FALSE(cell.uncertain());
    cell.driver.open(cell.now);
    cell.settle();
    ASSERT_EQ(cell.count(Kind::kReady), 1U);
    cell.events.pop_back();
    EXPECT_EQ(cell.events.size(), 1U);
    EXPECT_FALSE(cell.uncertain());
    cell.expect_honest();
    ASSERT_TRUE(cell.go({10, 0, 0, 0, 0, 0}));
    cell.settle();
    EXPECT_EQ(cell.truth(0), 10);
  }
}

TEST(IcpDriver, stop_is_always_accepted_and_answered_once_for_each_move) {
  IcpCell cell;
  cell.driver.stop(cell.now);
  cell.driver.stop(cell.now);
  ASSERT_EQ(cell.driver.take_event()->kind, Kind::kStopped);
  EXPECT_FALSE(cell.driver.take_event());
  cell.begin();
  ASSERT_TRUE(cell.go({50, 0, 0, 0, 0, 0}));
  ASSERT_TRUE(cell.go({0, 0, 0, 0, 0, 0}));
  cell.run_for(20ms);
  cell.driver.stop(cell.now);
  cell.driver.stop(cell.now);
  cell.settle();
  EXPECT_EQ(cell.count(Kind::kStopped), 2U);
  EXPECT_EQ(cell.events.size(), 2U);
}

TEST(IcpDriver, stop_while_the_line_is_dead_is_told_when_nobody_answers_any_more) {
  IcpCell cell;
  cell.begin();
  cell.down.fault = [](std::uint8_t byte, std::size_t place) {
    return place < 21 ? test::IcpLine::Fate{{byte}, {}} : test::IcpLine::Fate{};
  };
  ASSERT_TRUE(cell.go({50, 0, 0, 0, 0, 0}));
  cell.run_for(46ms);
  const Instant asked = cell.now;
  cell.driver.stop(cell.now);
  cell.run_until([&] { return cell.count(Kind::kStopped) == 1; });
  EXPECT_LE(cell.now - asked, 360ms);
  cell.settle();
  EXPECT_EQ(cell.driver.state(), DriverState::kFault);
  cell.expect_honest();
  EXPECT_TRUE(cell.uncertain());
}

TEST(IcpDriver, both_readings_of_minus_one_and_of_the_direction_bit_come_out_right) {
  for (const bool ones_complement : {false, true}) {
    for (const bool invert : {false, true}) {
      IcpDevice device = test::icp_device();
      device.units_per_down = ones_complement ? 2 : 1;
      device.legs[1].invert = invert;
      IcpCell cell({.minus_one = static_cast<std::int16_t>(ones_complement ? -2 : -1)}, device);
      cell.begin();
      for (const std::int64_t target : {40, -31, 6, 7, -100}) {
        ASSERT_TRUE(cell.go({target, target, 0, 0, 0, 0}));
        cell.settle();
        // Two units at a time may stop one short.
        EXPECT_LE(std::abs(cell.truth(0) - target), ones_complement ? 1 : 0);
        EXPECT_LE(std::abs(cell.truth(1) - target), ones_complement ? 1 : 0);
        cell.expect_honest();
      }
      EXPECT_EQ(cell.count(Kind::kDone), 5U);
    }
  }
}

TEST(IcpDriver, bit_sense_swapped_inside_the_firmware_does_not_matter) {
  IcpCell cell({.bit_one_is_plus = true});
  cell.begin();
  ASSERT_TRUE(cell.go({9, -9, 0, 0, 0, 0}));
  cell.settle();
  EXPECT_EQ(cell.count(Kind::kDone), 1U);
  EXPECT_EQ(cell.truth(0), 9);
  cell.expect_honest();
}

TEST(IcpDriver, double_down_steps_that_nobody_configured_are_found_and_admitted) {
  IcpCell cell({.minus_one = -2});
  cell.begin();
  ASSERT_TRUE(cell.go({0, 0, -20, 0, 0, 0}));
  cell.settle();
  ASSERT_EQ(cell.count(Kind::kFailed), 1U);
  EXPECT_EQ(cell.events[0].error, (Error{ErrorCode::kReplyMismatch, 2, 2, 1}));
  EXPECT_EQ(cell.truth(2), -40);
  cell.expect_honest();
  EXPECT_TRUE(cell.uncertain());
}

TEST(IcpDriver, firmware_that_checks_selectors_is_asked_with_positioning_bytes) {
  IcpCell cell({.dialect = {.checks_selector = true}});
  cell.begin();
  ASSERT_TRUE(cell.go({3, 0, 0, -3, 0, 0}));
  cell.settle();
  EXPECT_EQ(cell.count(Kind::kDone), 1U);
  cell.expect_honest();
  EXPECT_EQ(cell.truth(0), 3);
}

/// A laptop that stutters: the device has answered, and only nobody looked.
TEST(IcpDriver, host_that_looked_away_takes_the_answers_that_waited_for_it) {
  IcpCell cell;
  cell.begin();
  ASSERT_TRUE(cell.go({300, -200, 100, 30, -1, 7}));
  for (int k = 0; k < 12; ++k) {
    cell.run_for(Duration{137'000'000 + k * 1'234'567});
    cell.look_away(120ms);
  }
  cell.settle();
  EXPECT_EQ(cell.count(Kind::kDone), 1U);
  EXPECT_EQ(cell.driver.health().timeouts, 0U);
  EXPECT_FALSE(cell.uncertain());
  cell.expect_honest();
}

TEST(IcpDriver, modules_are_read_and_woken_at_rest_only) {
  IcpCell cell;
  cell.begin();
  ASSERT_TRUE(cell.go({3, 0, 0, 0, 0, 0}));
  EXPECT_EQ(cell.driver.wake(cell.now).error().code, ErrorCode::kBusy);
  cell.settle();
  ASSERT_TRUE(cell.driver.wake(cell.now));
  cell.settle();
  EXPECT_EQ(cell.count(Kind::kDone), 2U);
  EXPECT_EQ(cell.driver.status(0)->two.target, 1);
}

TEST(IcpDriver, wake_works_with_either_firmware) {
  for (const bool knows_wake : {true, false}) {
    IcpCell cell({.dialect = {.knows_wake = knows_wake}});
    cell.begin();
    ASSERT_TRUE(cell.driver.wake(cell.now));
    EXPECT_EQ(cell.driver.wake(cell.now).error().code, ErrorCode::kBusy);
    cell.settle();
    EXPECT_EQ(cell.count(Kind::kDone), 1U);
    EXPECT_EQ(cell.events.size(), 1U);
  }
}

TEST(IcpDriver, killed_controller_needs_its_power_cut) {
  IcpCell cell;
  cell.begin();
  ASSERT_TRUE(cell.driver.kill(cell.now));
  cell.settle();
  EXPECT_EQ(cell.count(Kind::kDone), 1U);
  EXPECT_EQ(cell.driver.fault()->code, ErrorCode::kDeviceKilled);
  EXPECT_EQ(cell.machine.controller().state(), IcpController::State::kDead);
  EXPECT_EQ(cell.go({1, 0, 0, 0, 0, 0}).error().code, ErrorCode::kDeviceKilled);
  ASSERT_TRUE(cell.driver.clear_fault(cell.now));
  cell.settle();
  EXPECT_EQ(cell.driver.fault()->code, ErrorCode::kDeviceSilent);
  cell.machine.power_cycle();
  cell.run_for(100ms);
  ASSERT_TRUE(cell.driver.clear_fault(cell.now));
  cell.settle();
  EXPECT_EQ(cell.driver.state(), DriverState::kReady);
}

TEST(IcpDriver, shutdown_after_a_long_idle_time_is_told_as_one) {
  IcpCell cell({.idle_shutdown = 30min});
  cell.begin();
  cell.run_for(31min);
  ASSERT_TRUE(cell.go({1, 0, 0, 0, 0, 0}));
  cell.settle();
  ASSERT_EQ(cell.count(Kind::kFailed), 1U);
  EXPECT_EQ(cell.events[0].error.code, ErrorCode::kDeviceKilled);
  EXPECT_TRUE(cell.uncertain()) << "a power cut would look the same";
  cell.machine.power_cycle();
  cell.run_for(100ms);
  ASSERT_TRUE(cell.driver.clear_fault(cell.now));
  cell.settle();
  EXPECT_FALSE(cell.uncertain()) << "it never left its home phase";
  cell.expect_honest();
}

TEST(IcpDriver, close_ends_the_command_and_open_finds_the_device_again) {
  for (const auto after : {1ms, 2ms, 3ms, 4ms, 5ms, 250ms}) {
    IcpCell cell;
    cell.begin();
    ASSERT_TRUE(cell.go({20, 0, 0, 0, 0, 0}));
    cell.run_for(after);
    const bool busy = cell.driver.state() == DriverState::kMoving;
    cell.driver.close(cell.now);
    cell.run_for(50ms);
    EXPECT_EQ(cell.count(Kind::kFailed), busy ? 1U : 0U);
    EXPECT_EQ(cell.driver.state(), DriverState::kClosed);
    cell.expect_honest();
    cell.driver.open(cell.now);
    cell.settle();
    EXPECT_EQ(cell.driver.state(), DriverState::kReady);
    cell.expect_honest();
  }
}

TEST(IcpDriver, device_that_is_busy_for_a_second_is_asked_once_more_before_its_power_is_blamed) {
  IcpCell cell;
  cell.begin();
  const Instant back = cell.now + 900ms;
  cell.up.fault = [&](std::uint8_t byte, std::size_t) {
    return cell.now < back ? test::IcpLine::Fate{} : test::IcpLine::Fate{{byte}, {}};
  };
  ASSERT_TRUE(cell.go({3, 0, 0, 0, 0, 0}));
  cell.settle();
  EXPECT_EQ(cell.driver.state(), DriverState::kReady);
  EXPECT_FALSE(cell.uncertain());
  cell.expect_honest();
  EXPECT_EQ(cell.truth(0), 3);
}

TEST(IcpDriver, power_cut_between_two_runs_shows_where_the_record_says_what_modules_held) {
  for (const bool cut : {false, true}) {
    for (const bool recorded : {false, true}) {
      IcpCell cell;
      cell.begin();
      EXPECT_EQ(cell.driver.counters_moved(), 0) << "no step since the power came";
      ASSERT_TRUE(cell.go({40, 0, 0, -30, 0, 0}));
      cell.settle();
      EXPECT_EQ(cell.driver.counters_moved(), 0b1001);
      const std::vector<JointPosition> known(cell.driver.positions().begin(),
                                             cell.driver.positions().end());
      cell.driver.close(cell.now);
      if (cut) cell.machine.power_cycle();
      cell.run_for(1s);
      cell.driver = IcpDriver(test::icp_device(), cell.robot.joints);
      cell.driver.declare_positions(known);
      if (recorded) cell.driver.remember({.counted = 0b1001});
      cell.driver.open(cell.now);
      cell.settle();
      // Without the record the modules of a machine that was switched off look as any others.
      const bool seen = cut && recorded;
      EXPECT_EQ(cell.driver.state(), seen ? DriverState::kFault : DriverState::kReady);
      EXPECT_EQ(cell.uncertain(), seen);
      if (seen) {
        EXPECT_EQ(cell.driver.fault()->code, ErrorCode::kSupplyFlag);
      }
      for (std::size_t leg = 0; leg < kLegs && (seen || !cut); ++leg) {
        const JointPosition& claim = cell.driver.positions()[leg];
        const double q = cell.machine.truth().joints[leg].q;
        const double trails = 17 / test::kIcpUnitsPerM;
        EXPECT_TRUE(q >= claim.lower - trails && q <= claim.upper + trails) << leg;
      }
      EXPECT_EQ(cell.driver.counters_moved(), cut ? 0 : 0b1001);
    }
  }
}

TEST(IcpDriver, nothing_is_allocated) {
  const IcpDevice device = test::icp_device();
  const RobotModel robot = test::icp_robot(device);
  IcpDriver driver(device, robot.joints);
  sim::IcpMachine machine(robot, {}, 1, Instant{});
  Instant now = Instant{100ms};
  const test::AllocationCounter allocations;
  driver.declare_positions(IcpCell::at_home());
  driver.open(now);
  std::array<std::uint8_t, 16> bytes{};
  int ended = 0;
  for (int i = 0; i < 4000; ++i) {
    // A byte up and a byte down fit into this.
    now += 2'100us;
    machine.advance(now);
    if (const auto size = machine.take_output(bytes)) driver.receive({bytes.data(), size}, now);
    driver.poll(now);
    if (const auto size = driver.take_output(bytes)) machine.receive({bytes.data(), size}, now);
    while (const auto event = driver.take_event()) ended += event->kind == Kind::kReady ? 0 : 1;
    if (i % 400 == 300) (void)driver.move({IcpCell::units_off({i, 0, -i, 0, 0, 0}), {}, {}}, now);
    if (i % 1200 == 700) driver.stop(now);
  }
  EXPECT_EQ(allocations.count(), 0U);
  EXPECT_GT(ended, 4);
}

}  // namespace
}  // namespace sinew
