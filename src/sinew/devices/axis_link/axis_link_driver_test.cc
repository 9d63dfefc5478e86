#include "sinew/devices/axis_link/axis_link_driver.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "sinew/core/error_code.h"
#include "sinew/devices/axis_link/axis_link_test_cell.h"
#include "support/allocation_guard.h"
#include "support/property.h"

namespace sinew {
namespace {

using namespace std::chrono_literals;
using Kind = DriverEvent::Kind;
using test::LinkCell;

TEST(AxisLinkDriver, open_greets_every_axis_and_then_knows_where_it_is) {
  LinkCell cell;
  EXPECT_EQ(cell.driver->positions()[0].quality, PositionQuality::kLost);
  cell.axes[2]->place(0.5);
  cell.driver->open(cell.now);
  EXPECT_EQ(cell.driver->state(), DriverState::kOpening);
  ASSERT_TRUE(cell.run_to_event(Kind::kReady, 50ms));
  EXPECT_EQ(cell.events.size(), 1U);
  EXPECT_EQ(cell.driver->state(), DriverState::kReady);
  EXPECT_EQ(cell.driver->positions()[0].quality, PositionQuality::kLost) << "not homed";
  const JointPosition& known = cell.driver->positions()[2];
  EXPECT_EQ(known.quality, PositionQuality::kMeasured);
  EXPECT_NEAR(known.q, 0.5, 1e-8);
  EXPECT_NEAR(known.upper - known.q, 2 * kPi / 4096, 2e-6) << "the uncertainty the axis told";
  EXPECT_GE(known.upper - known.q, 2 * kPi / 4096);
}

TEST(AxisLinkDriver, a_joint_beyond_its_limit_goes_inward_and_no_farther_out) {
  for (const double side : {-1.0, 1.0}) {
    LinkCell cell;
    const Joint& joint = cell.joints[1];
    const double here = side < 0 ? joint.lower - from_deg(3) : joint.upper + from_deg(3);
    cell.open_at(here);
    const auto out = cell.driver->move(cell.move_to(here + side * from_deg(0.1), 1s), cell.now);
    ASSERT_FALSE(out);
    EXPECT_EQ(out.error().code, ErrorCode::kJointLimit);
    ASSERT_TRUE(cell.driver->move(cell.move_to(here - side * from_deg(1), 1s), cell.now));
    ASSERT_TRUE(cell.run_to_event(Kind::kDone, 2s));
    EXPECT_NEAR(cell.axes[1]->q(), here - side * from_deg(1), 1e-7);
  }
}

TEST(AxisLinkDriver, a_move_follows_the_cubic_and_is_done_when_it_stands_there) {
  LinkCell cell;
  cell.open_at(0);
  ASSERT_TRUE(cell.driver->move(cell.move_to(from_deg(30), 1s), cell.now));
  EXPECT_EQ(cell.driver->state(), DriverState::kMoving);
  const Instant start = cell.now;
  double worst = 0;
  ASSERT_TRUE(cell.run_until(
      [&] {
        const double s = to_seconds(cell.now - start);
        const double expected = from_deg(30) * s * s * (3 - 2 * s);
        if (s < 1) worst = std::max(worst, std::abs(cell.axes[3]->q() - expected));
        cell.expect_truth_inside();
        return cell.count(Kind::kDone) > 0;
      },
      2s));
  EXPECT_EQ(cell.events.size(), 1U);
  EXPECT_GE(cell.now - start, 1s);
  EXPECT_LT(cell.now - start, 1010ms);
  // Two cycles of 1 ms at 45 deg/s.
  EXPECT_LT(to_deg(worst), 0.1);
  for (const auto& axis : cell.axes) EXPECT_NEAR(axis->q(), from_deg(30), 1e-7);
  cell.expect_only_sent_targets();
}

TEST(AxisLinkDriver, segments_join_without_a_gap_and_each_one_is_done) {
  LinkCell cell;
  cell.open_at(0);
  const double speed = from_deg(20);
  ASSERT_TRUE(cell.driver->move(cell.move_to(speed * 0.05, 100ms, speed), cell.now));
  double pace = 0;
  int segments = 1;
  cell.run_until(
      [&] {
        if (segments < 20 && cell.driver->wants_move(cell.now)) {
          const double q = speed * (0.05 + 0.02 * segments++);
          EXPECT_TRUE(cell.driver->move(cell.move_to(q, 20ms, speed), cell.now));
        }
        return segments == 20;
      },
      5s);
  const Instant from = cell.now;
  const double q = cell.axes[0]->q();
  cell.run_for(20ms);
  pace = (cell.axes[0]->q() - q) / to_seconds(cell.now - from);
  EXPECT_NEAR(pace, speed, 0.06 * speed);
  ASSERT_TRUE(cell.driver->move(cell.move_to(speed * 0.48, 100ms, 0), cell.now));
  ASSERT_TRUE(cell.run_until([&] { return cell.count(Kind::kDone) == 21; }, 2s));
  EXPECT_EQ(cell.events.size(), 21U);
  EXPECT_EQ(cell.driver->state(), DriverState::kReady);
}

TEST(AxisLinkDriver, a_motion_that_nobody_continues_is_stopped_and_says_so) {
  LinkCell cell;
  cell.open_at(0);
  ASSERT_TRUE(cell.driver->move(cell.move_to(from_deg(2), 100ms, from_deg(20)), cell.now));
  ASSERT_TRUE(cell.run_to_event(Kind::kFailed, 1s));
  EXPECT_EQ(cell.failure()->code, ErrorCode::kSegmentTime);
  EXPECT_EQ(cell.driver->state(), DriverState::kStopping);
  cell.run_for(2s);
  EXPECT_EQ(cell.driver->state(), DriverState::kReady) << "it stands and may go on";
  EXPECT_EQ(cell.events.size(), 1U);
  // 20 deg/s are braked within 1 deg at 200 deg/s^2.
  EXPECT_LT(to_deg(cell.axes[0]->q()), 3.5);
}

TEST(AxisLinkDriver, what_may_not_be_sent_is_refused_with_its_reason) {
  LinkCell cell;
  EXPECT_EQ(cell.driver->move(cell.move_to(0, 1s), cell.now).error().code, ErrorCode::kPortClosed);
  cell.axes[4]->place(0);
  cell.driver->open(cell.now);
  cell.run_for(20ms);
  EXPECT_EQ(cell.driver->move(cell.move_to(0, 1s), cell.now).error(),
            (Error{ErrorCode::kPositionUnknown, 0}));
  LinkCell homed;
  homed.open_at(0);
  const auto refusal = [&](const JointMove& move) {
    return homed.driver->move(move, homed.now).error();
  };
  EXPECT_EQ(refusal(homed.move_to(from_deg(91), 10s)),
            (Error{ErrorCode::kJointLimit, 1, from_deg(91), from_deg(90)}));
  EXPECT_EQ(refusal(homed.move_to(std::nan(""), 10s)).code, ErrorCode::kJointLimit);
  EXPECT_EQ(refusal(homed.move_to(0, 1s, std::nan(""))).code, ErrorCode::kUnsendable);
  EXPECT_EQ(refusal(homed.move_to(0, 1s, std::numeric_limits<double>::infinity())).code,
            ErrorCode::kUnsendable);
  EXPECT_EQ(refusal(homed.move_to(0, 0s)).code, ErrorCode::kSegmentTime);
  EXPECT_EQ(refusal(homed.move_to(0, -1s)).code, ErrorCode::kSegmentTime);
  const Error fast = refusal(homed.move_to(from_deg(80), 1s));
  EXPECT_EQ(fast.code, ErrorCode::kSegmentTime);
  EXPECT_NEAR(fast.limit, 1.2, 1e-9) << "a cubic peaks at 1.5 times its mean";
  EXPECT_EQ(refusal(homed.move_to(from_deg(89.9), 2s, from_deg(-60))).code, ErrorCode::kJointLimit)
      << "it swings out beyond the limit before it ends inside";
  JointMove short_move;
  short_move.duration = 1s;
  EXPECT_EQ(refusal(short_move).code, ErrorCode::kUnsendable);
  homed.run_for(50ms);
  EXPECT_TRUE(homed.axes[0]->targets.empty()) << "nothing was sent";
  EXPECT_TRUE(homed.events.empty());
}

TEST(AxisLinkDriver, a_target_on_the_limit_is_not_rounded_beyond_it) {
  LinkCell cell;
  cell.open_at(from_deg(80));
  for (const double side : {1.0, -1.0}) {
    JointMove move = cell.move_to(0, 6s);
    for (std::size_t i = 0; i < 6; ++i)
      move.q[i] = side * std::min(cell.joints[i].upper, from_deg(170));
    ASSERT_TRUE(cell.driver->move(move, cell.now));
    ASSERT_TRUE(cell.run_to_event(Kind::kDone, 10s)) << "the axis would refuse one unit more";
    EXPECT_NEAR(cell.axes[1]->q(), side * from_deg(90), 2e-8);
    cell.events.clear();
  }
}

/// A stream to the limit: its cubics swing out by less than anybody would see.
TEST(AxisLinkDriver, a_swing_between_two_ends_stays_at_the_limit) {
  LinkCell cell;
  const double limit = cell.joints[1].upper;
  cell.open_at(limit - 0.001);
  ASSERT_TRUE(cell.driver->move(cell.move_to(limit - 0.0003, 50ms, 0.02), cell.now));
  ASSERT_TRUE(cell.driver->move(cell.move_to(limit, 50ms), cell.now));
  ASSERT_TRUE(cell.run_until([&] { return cell.count(Kind::kDone) == 2; }, 1s));
  EXPECT_EQ(cell.failure(), std::nullopt);
  EXPECT_NEAR(cell.axes[1]->q(), limit, 2e-8);
}

/// The encoder reads a count beyond the limit at which the axis stands; the axis refuses that.
TEST(AxisLinkDriver, a_count_beyond_the_limit_is_the_limit) {
  LinkCell cell;
  const double limit = cell.joints[1].upper;
  cell.open_at(limit + 2e-5);
  cell.axes[1]->place(limit);
  JointMove move = cell.move_to(limit - 0.1, 1s);
  move.q[1] = limit + 2e-5;
  ASSERT_TRUE(cell.driver->move(move, cell.now));
  ASSERT_TRUE(cell.run_to_event(Kind::kDone, 2s));
  EXPECT_EQ(cell.failure(), std::nullopt);
  ASSERT_TRUE(cell.driver->move(cell.move_to(limit - 0.1, 1s), cell.now));
  EXPECT_TRUE(cell.run_until([&] { return cell.count(Kind::kDone) == 2; }, 2s));
}

TEST(AxisLinkDriver, stop_is_in_the_next_frame_to_all_whatever_goes_on) {
  for (const char* when : {"opening", "idle", "moving", "homing", "settling", "stopping"}) {
    SCOPED_TRACE(when);
    LinkCell cell;
    const std::string_view name = when;
    if (name == "opening") {
      cell.driver->open(cell.now);
      cell.step();
    } else {
      cell.open_at(0);
    }
    std::size_t pending = 1;
    if (name == "moving" || name == "stopping") {
      ASSERT_TRUE(cell.driver->move(cell.move_to(from_deg(20), 1s, from_deg(20)), cell.now));
      ASSERT_TRUE(cell.driver->move(cell.move_to(from_deg(40), 1s, 0), cell.now));
      pending = 2;
      cell.run_for(500ms);
    }
    if (name == "settling") {
      cell.axes[0]->jammed = true;
      ASSERT_TRUE(cell.driver->move(cell.move_to(from_deg(1), 200ms), cell.now));
      cell.run_for(300ms);
    }
    if (name == "homing") {
      ASSERT_TRUE(cell.driver->home(cell.now));
      cell.run_for(100ms);
    }
    if (name == "stopping") {
      cell.driver->stop(cell.now);
      cell.run_for(3ms);
    }
    cell.driver->stop(cell.now);
    const auto transfer = cell.driver->take_transfer(cell.now);
    ASSERT_TRUE(transfer);
    EXPECT_EQ(transfer->select, 0x3F);
    const auto request =
        axis_link::decode_request(std::span<const std::uint8_t>(transfer->mosi).first<16>());
    EXPECT_EQ(request->mode, axis_link::Mode::kStop);
    EXPECT_TRUE(request->to_all);
    cell.driver->exchanged(spi::Bytes(std::span<const std::uint8_t>(transfer->mosi)), cell.now);
    cell.axes[0]->jammed = false;
    cell.run_for(2s);
    EXPECT_EQ(cell.count(Kind::kStopped), pending);
    EXPECT_EQ(cell.count(Kind::kFailed), 0U);
    for (const auto& axis : cell.axes) EXPECT_FALSE(axis->status().moving);
    // The broadcast was kept from the axes here: each was told alone as well.
    EXPECT_GE(cell.axes[5]->stops, name == "opening" ? 0 : 1);
    EXPECT_EQ(cell.driver->state(), DriverState::kReady);
  }
}

TEST(AxisLinkDriver, six_moving_axes_stand_half_a_second_after_stop) {
  LinkCell cell;
  cell.open_at(0);
  ASSERT_TRUE(cell.driver->move(cell.move_to(from_deg(60), 1s), cell.now));
  cell.run_for(500ms);
  cell.driver->stop(cell.now);
  const Instant asked = cell.now;
  cell.step();
  for (const auto& axis : cell.axes) EXPECT_EQ(axis->stops, 1) << "in one frame";
  EXPECT_LT(cell.now - asked, 100us);
  const auto until = cell.driver->goes_on_until();
  ASSERT_TRUE(until);
  ASSERT_TRUE(cell.run_to_event(Kind::kStopped, 2s));
  EXPECT_LE(cell.now, *until);
  EXPECT_FALSE(cell.driver->goes_on_until());
  // 90 deg/s at 200 deg/s^2 are 450 ms.
  EXPECT_LT(cell.now - asked, 460ms);
  EXPECT_EQ(cell.events.size(), 1U);
}

TEST(AxisLinkDriver, homing_takes_the_axes_in_turn_and_ends_measured) {
  LinkCell cell;
  cell.driver->open(cell.now);
  cell.run_for(20ms);
  cell.events.clear();
  ASSERT_TRUE(cell.driver->home(cell.now));
  EXPECT_EQ(cell.driver->home(cell.now).error().code, ErrorCode::kBusy);
  bool one_at_a_time = true;
  ASSERT_TRUE(cell.run_until(
      [&] {
        const auto homing = std::ranges::count_if(
            cell.axes, [](const auto& axis) { return axis->status().homing; });
        one_at_a_time = one_at_a_time && homing <= 1;
        return cell.count(Kind::kDone) > 0;
      },
      200s));
  EXPECT_TRUE(one_at_a_time);
  for (std::size_t i = 0; i < 6; ++i) {
    EXPECT_EQ(cell.axes[i]->homings, 1);
    EXPECT_EQ(cell.driver->positions()[i].quality, PositionQuality::kMeasured);
    EXPECT_NEAR(cell.driver->positions()[i].q, cell.joints[i].lower, 1e-7);
  }
  cell.events.clear();
  ASSERT_TRUE(cell.driver->home(cell.now, 0b10100));
  ASSERT_TRUE(cell.run_to_event(Kind::kDone, 200s));
  for (std::size_t i = 0; i < 6; ++i) EXPECT_EQ(cell.axes[i]->homings, i == 2 || i == 4 ? 2 : 1);
}

TEST(AxisLinkDriver, a_search_that_names_its_zero_elsewhere_is_seen_by_as_much) {
  LinkCell cell(2);
  cell.driver->open(cell.now);
  cell.run_for(20ms);
  const auto home = [&] {
    cell.events.clear();
    ASSERT_TRUE(cell.driver->home(cell.now));
    ASSERT_TRUE(cell.run_to_event(Kind::kDone, 200s));
  };
  home();
  EXPECT_FALSE(cell.driver->zero_shift(0)) << "there was none before";
  for (auto& axis : cell.axes) axis->home_angle += from_deg(10);
  cell.axes[0]->zero_shift = from_deg(-2);
  home();
  ASSERT_TRUE(cell.driver->zero_shift(0));
  EXPECT_NEAR(*cell.driver->zero_shift(0), from_deg(-2), from_deg(0.05));
  EXPECT_NEAR(cell.driver->zero_shift(1).value_or(99), 0, from_deg(0.05));
  // Another session knows nothing of the frame before.
  cell.driver->close(cell.now);
  cell.driver->open(cell.now);
  cell.run_for(20ms);
  EXPECT_FALSE(cell.driver->zero_shift(0));
}

TEST(AxisLinkDriver, homing_that_ends_nowhere_or_is_refused_fails_with_its_axis) {
  AxisLinkTiming timing;
  timing.homing_timeout = 2s;
  LinkCell cell(3, timing);
  cell.driver->open(cell.now);
  cell.run_for(20ms);
  cell.axes[1]->jammed = true;
  cell.axes[0]->place(cell.joints[0].lower);
  ASSERT_TRUE(cell.driver->home(cell.now));
  ASSERT_TRUE(cell.run_to_event(Kind::kFailed, 10s));
  EXPECT_EQ(cell.failure()->code, ErrorCode::kHomingFailed);
  EXPECT_EQ(cell.failure()->index, 1);
  EXPECT_EQ(cell.axes[2]->homings, 0);
}

TEST(AxisLinkDriver, self_test_goes_from_axis_to_axis_and_ends_with_the_one_that_fails) {
  LinkCell cell(3);
  cell.open_at(0);
  EXPECT_EQ(cell.driver->service(DeviceService::kWake, cell.now).error().code,
            ErrorCode::kNoSuchService);
  ASSERT_TRUE(cell.driver->service(DeviceService::kSelfTest, cell.now));
  ASSERT_TRUE(cell.run_to_event(Kind::kDone, 1s));
  for (const auto& axis : cell.axes) EXPECT_EQ(axis->self_tests, 1);
  cell.axes[1]->test_fails = true;
  ASSERT_TRUE(cell.driver->service(DeviceService::kSelfTest, cell.now));
  ASSERT_TRUE(cell.run_to_event(Kind::kFailed, 1s));
  EXPECT_EQ(cell.failure(), (Error{ErrorCode::kSelfTestFailed, 1}));
  EXPECT_EQ(cell.axes[0]->self_tests, 2);
  EXPECT_EQ(cell.axes[2]->self_tests, 1);
}

TEST(AxisLinkDriver, self_test_is_refused_where_an_axis_is_out) {
  LinkCell cell(3);
  cell.open_at(0);
  cell.axes[1]->stop(AxisFault::kTooHot);
  cell.run_for(20ms);
  EXPECT_EQ(cell.driver->service(DeviceService::kSelfTest, cell.now).error(),
            (Error{ErrorCode::kOverheated, 1}));
  EXPECT_EQ(cell.axes[0]->self_tests, 0);
}

TEST(AxisLinkDriver, an_axis_fault_in_motion_stops_all_and_clear_fault_brings_it_back) {
  LinkCell cell;
  cell.open_at(0);
  ASSERT_TRUE(cell.driver->move(cell.move_to(from_deg(60), 1s), cell.now));
  cell.run_for(300ms);
  cell.axes[2]->stop(AxisFault::kFollowingError);
  ASSERT_TRUE(cell.run_to_event(Kind::kFailed, 5ms));
  EXPECT_EQ(cell.failure(), (Error{ErrorCode::kFollowingError, 2}));
  cell.run_for(1s);
  for (const auto& axis : cell.axes) EXPECT_FALSE(axis->status().moving);
  EXPECT_EQ(cell.driver->state(), DriverState::kFault);
  EXPECT_EQ(cell.driver->fault(), (Error{ErrorCode::kFollowingError, 2}));
  EXPECT_EQ(cell.driver->move(cell.move_to(0, 3s), cell.now).error().code,
            ErrorCode::kFollowingError);
  EXPECT_EQ(cell.events.size(), 1U);
  cell.events.clear();
  const double held = cell.axes[2]->q();
  ASSERT_TRUE(cell.driver->clear_fault(cell.now));
  ASSERT_TRUE(cell.run_to_event(Kind::kDone, 1s));
  EXPECT_EQ(cell.axes[2]->clears, 1) << "once, though its frame goes out until it is answered";
  EXPECT_EQ(cell.axes[1]->clears, 0);
  EXPECT_EQ(cell.driver->state(), DriverState::kReady);
  EXPECT_EQ(cell.axes[2]->q(), held) << "clearing resumes nothing";
}

TEST(AxisLinkDriver, the_others_stay_commandable_while_one_axis_is_out) {
  LinkCell cell;
  cell.open_at(0);
  cell.axes[4]->fault_stays = true;
  cell.axes[4]->told().fault = AxisFault::kTooHot;
  cell.run_for(10ms);
  EXPECT_EQ(cell.count(Kind::kNotice), 1U);
  EXPECT_EQ(cell.driver->axis_fault(4), (Error{ErrorCode::kOverheated, 4}));
  EXPECT_EQ(cell.driver->state(), DriverState::kReady);
  EXPECT_EQ(cell.driver->move(cell.move_to(from_deg(10), 1s), cell.now).error().code,
            ErrorCode::kOverheated);
  JointMove move = cell.move_to(from_deg(10), 1s);
  move.q[4] = 0;
  ASSERT_TRUE(cell.driver->move(move, cell.now));
  ASSERT_TRUE(cell.run_to_event(Kind::kDone, 2s));
  EXPECT_NEAR(cell.axes[5]->q(), from_deg(10), 1e-7);
  EXPECT_EQ(cell.axes[4]->q(), 0);
  ASSERT_TRUE(cell.driver->clear_fault(cell.now));
  cell.run_for(100ms);
  EXPECT_EQ(cell.driver->axis_fault(4), (Error{ErrorCode::kOverheated, 4})) << "its cause stays";
  EXPECT_EQ(cell.count(Kind::kDone), 2U);
}

TEST(AxisLinkDriver, emergency_stop_freezes_latches_and_needs_clear_fault) {
  LinkCell cell;
  cell.open_at(0);
  ASSERT_TRUE(cell.driver->move(cell.move_to(from_deg(60), 1s), cell.now));
  cell.run_for(300ms);
  cell.driver->emergency_stop(cell.now);
  cell.step();
  for (const auto& axis : cell.axes) EXPECT_TRUE(axis->status().emergency_stopped);
  ASSERT_TRUE(cell.run_to_event(Kind::kStopped, 1s));
  EXPECT_EQ(cell.driver->fault()->code, ErrorCode::kEmergencyStop);
  cell.events.clear();
  ASSERT_TRUE(cell.driver->clear_fault(cell.now));
  EXPECT_TRUE(cell.driver->clearing()) << "closed before that is over, the boards keep their latch";
  ASSERT_TRUE(cell.run_to_event(Kind::kDone, 1s));
  EXPECT_FALSE(cell.driver->clearing());
  EXPECT_EQ(cell.driver->state(), DriverState::kReady);
  for (const auto& axis : cell.axes) EXPECT_FALSE(axis->status().moving);
}

TEST(AxisLinkDriver, a_jammed_axis_is_a_missed_target_and_never_done) {
  LinkCell cell;
  cell.open_at(0);
  cell.axes[3]->jammed = true;
  ASSERT_TRUE(cell.driver->move(cell.move_to(from_deg(10), 500ms), cell.now));
  ASSERT_TRUE(cell.run_to_event(Kind::kFailed, 10s));
  EXPECT_EQ(cell.failure()->code, ErrorCode::kMissedTarget);
  EXPECT_EQ(cell.failure()->index, 3);
  EXPECT_EQ(cell.count(Kind::kDone), 0U);
}

TEST(AxisLinkDriver, close_fails_what_is_under_way_and_open_starts_afresh) {
  LinkCell cell;
  cell.open_at(0);
  ASSERT_TRUE(cell.driver->move(cell.move_to(from_deg(60), 1s), cell.now));
  cell.run_for(300ms);
  cell.driver->close(cell.now);
  EXPECT_EQ(cell.driver->state(), DriverState::kClosed);
  EXPECT_EQ(cell.driver->positions()[0].quality, PositionQuality::kLost);
  EXPECT_FALSE(cell.driver->next_deadline());
  cell.run_for(1s);
  ASSERT_EQ(cell.events.size(), 1U);
  EXPECT_EQ(cell.failure()->code, ErrorCode::kPortClosed);
  for (const auto& axis : cell.axes) {
    EXPECT_FALSE(axis->status().moving) << "the deadline of 100 ms stopped it";
    EXPECT_EQ(axis->status().fault, AxisFault::kLinkSilent);
  }
  cell.events.clear();
  cell.driver->open(cell.now);
  ASSERT_TRUE(cell.run_to_event(Kind::kReady, 1s));
  EXPECT_EQ(cell.count(Kind::kNotice), cell.axes.size()) << "each had stopped by itself";
  EXPECT_EQ(cell.driver->state(), DriverState::kReady);
  EXPECT_EQ(cell.driver->positions()[0].quality, PositionQuality::kMeasured);
}

TEST(AxisLinkDriver, health_comes_in_at_rest) {
  LinkCell cell(2);
  cell.axes[0]->told().supply_volts = 24.1;
  cell.axes[1]->told().supply_volts = 23.7;
  cell.axes[1]->told().temperature_c = 41.5;
  cell.open_at(0);
  cell.run_for(2s);
  EXPECT_NEAR(*cell.driver->health().supply_volts, 23.7, 1e-9);
  EXPECT_NEAR(*cell.driver->health().temperature_c, 41.5, 1e-9);
  EXPECT_EQ(cell.driver->health().unexpected, 0U);
  EXPECT_GT(cell.driver->health().requests, 3000U);
}

TEST(AxisLinkDriver, nothing_allocates_once_it_is_built) {
  LinkCell cell;
  cell.open_at(0);
  cell.keep_record = false;
  cell.events.reserve(64);
  for (auto& axis : cell.axes) axis->keep_record = false;
  const test::AllocationCounter counter;
  ASSERT_TRUE(cell.driver->move(cell.move_to(from_deg(10), 500ms), cell.now));
  cell.run_for(1s);
  cell.driver->stop(cell.now);
  cell.run_for(1s);
  ASSERT_TRUE(cell.driver->clear_fault(cell.now));
  cell.run_for(100ms);
  EXPECT_EQ(counter.count(), 0U);
  EXPECT_EQ(cell.count(Kind::kDone), 2U);
}

}  // namespace
}  // namespace sinew
