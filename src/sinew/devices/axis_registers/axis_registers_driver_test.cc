#include "sinew/devices/axis_registers/axis_registers_driver.h"

#include <gtest/gtest.h>

#include <cmath>
#include <iostream>
#include <vector>

#include "sinew/core/error_code.h"
#include "sinew/devices/axis_registers/axis_registers_test_cell.h"
#include "support/allocation_guard.h"
#include "support/property.h"

namespace sinew {
namespace {

using namespace std::chrono_literals;
using test::RegisterCell;
using Kind = DriverEvent::Kind;
using Quality = PositionQuality;

using enum AxisRegisterProfile;

AxisRegistersDevice boards_without_status() {
  AxisRegistersDevice device = test::six_boards();
  device.reports_status = false;
  return device;
}

TEST(AxisRegistersDriver, opening_finds_every_board_and_says_what_it_knows) {
  RegisterCell cell;
  EXPECT_EQ(cell.driver->state(), DriverState::kClosed);
  cell.axes[2].place(from_deg(30));
  cell.driver->open(cell.now);
  EXPECT_EQ(cell.driver->state(), DriverState::kOpening);
  ASSERT_TRUE(cell.run_until([&] { return cell.saw(Kind::kReady); }, 10));
  EXPECT_EQ(cell.driver->state(), DriverState::kReady);
  for (std::size_t i = 0; i < 6; ++i) {
    EXPECT_EQ(cell.driver->positions()[i].quality, i == 2 ? Quality::kUncertain : Quality::kLost);
  }
  cell.expect_honest();
  EXPECT_TRUE(cell.driver->wants_move(cell.now));
  const auto refused = cell.driver->move(cell.to({0, 0, 0, 0, 0, 0}), cell.now);
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error(), (Error{ErrorCode::kPositionUnknown, 0}));
}

TEST(AxisRegistersDriver, homing_takes_the_joints_in_turn_and_learns_where_they_are) {
  RegisterCell cell;
  cell.driver->open(cell.now);
  cell.run_until([&] { return cell.saw(Kind::kReady); }, 10);
  cell.events.clear();
  ASSERT_TRUE(cell.driver->home(cell.now));
  int most = 0;
  ASSERT_TRUE(cell.run_until(
      [&] {
        int homing = 0;
        for (const auto& axis : cell.axes) homing += axis.status().homing ? 1 : 0;
        most = std::max(most, homing);
        cell.expect_honest();
        return !cell.ends().empty();
      },
      600));
  EXPECT_EQ(cell.finish().kind, Kind::kDone);
  EXPECT_EQ(most, 1);
  for (std::size_t i = 0; i < 6; ++i) {
    EXPECT_EQ(cell.driver->positions()[i].quality, Quality::kCommanded) << i;
    EXPECT_NEAR(cell.driver->positions()[i].q, cell.joints[i].lower, 1e-12);
  }
  cell.expect_honest();
  ASSERT_TRUE(cell.driver->home(cell.now, 0b10100));
  EXPECT_EQ(cell.finish(600).kind, Kind::kDone);
  for (std::size_t i = 0; i < 6; ++i) {
    EXPECT_EQ(cell.axes[i].homings, i == 2 || i == 4 ? 2 : 1) << i;
  }
}

TEST(AxisRegistersDriver, a_move_goes_to_whole_degrees_and_says_so) {
  RegisterCell cell;
  cell.start_at();
  ASSERT_TRUE(cell.driver->move(cell.to({-30, 20.4, 45.6, 0, 0, 10}), cell.now));
  EXPECT_EQ(cell.driver->state(), DriverState::kMoving);
  EXPECT_EQ(cell.driver->move(cell.to({0, 0, 0, 0, 0, 0}), cell.now).error().code,
            ErrorCode::kBusy);
  cell.run_for(300ms);
  EXPECT_EQ(cell.driver->positions()[0].quality, Quality::kUncertain);
  cell.expect_honest("under way");
  EXPECT_EQ(cell.finish().kind, Kind::kDone);
  const std::array<double, 6> told{-30, 20, 46, 0, 0, 10};
  for (std::size_t i = 0; i < 6; ++i) {
    EXPECT_EQ(cell.driver->positions()[i].quality, Quality::kCommanded);
    EXPECT_NEAR(to_deg(cell.driver->positions()[i].q), told[i], 1e-9);
    const double half = told[i] == 0 ? 0 : 0.5;  // who stands keeps what was declared of it
    EXPECT_NEAR(to_deg(cell.driver->positions()[i].upper), told[i] + half, 1e-9);
    EXPECT_NEAR(to_deg(cell.axes[i].q()), told[i], 1e-9);
    EXPECT_EQ(cell.axes[i].moves, told[i] == 0 ? 0 : 1) << "who stands is told nothing";
  }
}

TEST(AxisRegistersDriver, stop_reaches_all_six_at_once_and_is_verified) {
  RegisterCell cell;
  cell.start_at();
  ASSERT_TRUE(cell.driver->move(cell.to({90, 60, 60, 60, 60, 60}), cell.now));
  cell.run_for(800ms);
  const Instant asked = cell.now;
  cell.driver->stop(cell.now);
  const auto latched = [&] {
    int count = 0;
    for (const auto& axis : cell.axes) count += axis.status().emergency_stopped ? 1 : 0;
    return count;
  };
  ASSERT_TRUE(cell.run_until([&] { return latched() == 6; }, 1));
  EXPECT_LE(cell.now - asked, 164ms);
  EXPECT_LE(cell.contended, 1) << "at SYN, where each repeats the last byte of what it said before";
  EXPECT_EQ(cell.finish().kind, Kind::kStopped);
  EXPECT_EQ(cell.driver->state(), DriverState::kReady);
  for (const auto& axis : cell.axes) EXPECT_EQ(axis.stops, 1) << "the broadcast was enough";
  cell.expect_honest();
  EXPECT_EQ(cell.driver->positions()[0].quality, Quality::kUncertain);
  // The next move takes the latch back and ends the doubt.
  ASSERT_TRUE(cell.driver->move(cell.to({0, 0, 0, 0, 0, 0}), cell.now));
  EXPECT_EQ(cell.finish().kind, Kind::kDone);
  cell.expect_honest();
  EXPECT_EQ(cell.driver->positions()[0].quality, Quality::kCommanded);
}

TEST(AxisRegistersDriver, a_document_transaction_takes_its_documented_time) {
  for (const bool four_bytes : {false, true}) {
    const AxisRegistersDevice device = test::six_boards();
    AxisRegisterLink link(device, {});
    RegisterCell cell;
    const auto write = [&](axis_registers::Data data, std::uint16_t address) {
      const Instant start = cell.now;
      const auto size = static_cast<std::uint16_t>(data.size());
      link.start({.select = 1,
                  .operation = axis_registers::Operation::kWrite,
                  .address = address,
                  .size = size,
                  .data = data},
                 cell.now);
      std::optional<AxisRegisterOutcome> outcome;
      int transfers = 0;
      while (!outcome) {
        cell.now = std::max(cell.now, *link.next_deadline());
        const auto transfer = link.take_transfer(cell.now);
        ++transfers;
        spi::Bytes miso;
        miso.resize(transfer->mosi.size());
        cell.boards[0].exchange({transfer->mosi.data(), transfer->mosi.size()},
                                {miso.data(), miso.size()});
        cell.now += transfer->setup + spi::wire_time(*transfer);
        link.exchanged({miso.data(), miso.size()}, cell.now);
        outcome = link.take_outcome();
      }
      EXPECT_FALSE(outcome->error);
      // The pause behind the last transfer belongs to it: the next may not begin before.
      AxisRegisterRequest next;
      next.select = 1;
      link.start(next, cell.now);
      cell.now = *link.next_deadline();
      link.abandon();
      return std::pair(cell.now - start, transfers);
    };
    const axis_registers::Data angle{0, 0, 0, 90};
    const auto first = four_bytes ? write(angle, 1) : write({1}, 4);
    EXPECT_EQ(first.second, 7 + axis_registers::kResyncBursts) << "the first one finds the board";
    const auto [time, transfers] = four_bytes ? write(angle, 1) : write({1}, 4);
    EXPECT_EQ(time, four_bytes ? Duration(81'880us) : Duration(81'832us));
    EXPECT_EQ(transfers, 7);
  }
}

TEST(AxisRegistersDriver, boards_without_status_are_done_after_the_predicted_time) {
  RegisterCell cell(kAsBuilt, boards_without_status());
  cell.start_at();
  EXPECT_EQ(cell.driver->home(cell.now).error().code, ErrorCode::kTaskNotSupported);
  JointMove move = cell.to({90, 0, 0, 0, 0, 0});
  const Instant start = cell.now;
  ASSERT_TRUE(cell.driver->move(move, cell.now));
  EXPECT_EQ(cell.finish().kind, Kind::kDone);
  // 90 deg inside 100 deg/s, 10 deg/s^2, 10 deg/s^3 take 7.083 s.
  EXPECT_NEAR(to_seconds(cell.now - start), 7.083 + 0.072, 0.2);
  EXPECT_EQ(cell.driver->positions()[0].quality, Quality::kCommanded);
  move = cell.to({0, 0, 0, 0, 0, 0});
  move.duration = 20s;
  const Instant second = cell.now;
  ASSERT_TRUE(cell.driver->move(move, cell.now));
  EXPECT_EQ(cell.finish().kind, Kind::kDone);
  EXPECT_GE(cell.now - second, 20s);
}

TEST(AxisRegistersDriver, one_broadcast_sets_six_of_six_in_81_8_ms) {
  RegisterCell cell;
  cell.start_at();
  cell.run_for(3s);
  // A write to each leaves the same last byte with all, so that nothing collides at SYN either.
  ASSERT_TRUE(cell.driver->clear_fault(cell.now));
  cell.run_until([&] { return cell.axes[5].releases == 1; }, 5);
  const Instant asked = cell.now;
  Instant last{};
  int broadcasts = 0;
  Instant verify{};
  cell.watch = [&](const spi::Transfer& transfer) {
    broadcasts += transfer.select == 0x3F ? 1 : 0;
    if (transfer.select != 0x3F && broadcasts > 0 && verify == Instant{}) verify = cell.now;
  };
  cell.driver->stop(cell.now);
  EXPECT_GT(cell.driver->goes_on_until().value_or(asked), asked + 1s);
  cell.run_until(
      [&] {
        const bool all = std::ranges::all_of(
            cell.axes, [](const auto& axis) { return axis.status().emergency_stopped; });
        if (all && last == Instant{}) last = cell.now;
        return cell.driver->state() != DriverState::kStopping;
      },
      5);
  EXPECT_EQ(broadcasts, 7);
  EXPECT_EQ(verify - asked, 81'832us + 10ms + 10ms + 264us) << "behind the write's COMMIT";
  EXPECT_LE(last - asked, 81'832us);
  std::cout << "  six of six after " << to_seconds(last - asked) * 1e3 << " ms\n";
  EXPECT_EQ(cell.contended, 0);
}

TEST(AxisRegistersDriver, boards_with_a_bus_each_are_told_one_after_the_other) {
  AxisRegistersDevice device = test::six_boards();
  for (std::size_t i = 0; i < 6; ++i) device.boards[i].spi_bus = static_cast<std::uint8_t>(i / 3);
  RegisterCell cell(kDocument, device);
  cell.start_at();
  std::vector<int> selects;
  cell.watch = [&](const spi::Transfer& transfer) {
    if (selects.empty() || selects.back() != transfer.select) selects.push_back(transfer.select);
  };
  cell.driver->stop(cell.now);
  EXPECT_EQ(cell.finish().kind, Kind::kStopped);
  ASSERT_GE(selects.size(), 3U);
  const auto first = std::ranges::find(selects, 0x07);
  ASSERT_NE(first, selects.end());
  EXPECT_EQ(*(first + 1), 0x38);
  for (const auto& axis : cell.axes) EXPECT_EQ(axis.stops, 1);
}

TEST(AxisRegistersDriver, every_encoding_carries_every_joint_to_its_limits) {
  using enum AngleEncoding;
  for (const AngleEncoding encoding : {kDegU32, kMdegI32, kF32Be, kF32Le}) {
    RegisterCell cell(kDocument, test::six_boards(encoding));
    cell.start_at();
    for (const double part : {-1.0, 1.0, 0.37}) {
      std::vector<double> q_deg;
      q_deg.reserve(cell.joints.size());
      for (const Joint& joint : cell.joints) q_deg.push_back(to_deg(joint.upper) * part);
      ASSERT_TRUE(cell.driver->move(cell.to(q_deg), cell.now));
      EXPECT_EQ(cell.finish().kind, Kind::kDone);
      for (std::size_t i = 0; i < 6; ++i) {
        const double unit = encoding == kDegU32 ? 0.5 : 0.0005;
        EXPECT_NEAR(to_deg(cell.axes[i].q()), q_deg[i], unit + 1e-9);
      }
      cell.expect_honest();
    }
  }
}

TEST(AxisRegistersDriver, values_that_must_not_leave_are_refused) {
  RegisterCell cell;
  cell.joints[0].upper = from_deg(90.6);
  cell.new_host();
  cell.start_at();
  int sent = 0;
  const auto refused = [&](std::vector<double> q_deg) {
    const auto result = cell.driver->move(cell.to(std::move(q_deg)), cell.now);
    return result ? Error{} : result.error();
  };
  EXPECT_EQ(refused({0, 91, 0, 0, 0, 0}).code, ErrorCode::kJointLimit);
  EXPECT_EQ(refused({0, 91, 0, 0, 0, 0}).index, 1);
  EXPECT_EQ(refused({0, 0, 0, 0, 0, std::nan("")}).code, ErrorCode::kJointLimit);
  EXPECT_EQ(refused({0, 0, 0, 0, 0, HUGE_VAL}).index, 5);
  EXPECT_EQ(refused({-171, 0, 0, 0, 0, 0}).index, 0);
  EXPECT_EQ(cell.driver->state(), DriverState::kReady);
  cell.watch = [&](const spi::Transfer& t) { sent += t.mosi.size() == 14 && t.mosi[4] == 2; };
  cell.run_for(2s);
  EXPECT_EQ(sent, 0);
  EXPECT_EQ(cell.driver->tool(Suction{}, cell.now).error().code, ErrorCode::kToolNotFitted);
  // 90.6 is inside; 91, the nearest that can be said, is not.
  ASSERT_TRUE(cell.driver->move(cell.to({90.6, 0, 0, 0, 0, 0}), cell.now));
  EXPECT_EQ(cell.finish().kind, Kind::kDone);
  EXPECT_NEAR(to_deg(cell.driver->positions()[0].q), 90, 1e-9);
}

TEST(AxisRegistersDriver, predicted_times_are_those_of_the_documents_profile) {
  const Joint joint = test::six_joints()[0];
  const auto time = [&](double deg) { return axis_registers::quickest_time(joint, from_deg(deg)); };
  EXPECT_NEAR(time(90), 7.083, 5e-4) << "as measured on the first firmware";
  EXPECT_NEAR(time(20), 4, 1e-9) << "jerk alone: 32 d / j = 4^3";
  EXPECT_NEAR(time(1100), 22, 1e-9) << "just reaches 100 deg/s";
  EXPECT_NEAR(time(2100), 32, 1e-9);
  EXPECT_EQ(time(0), 0);
  Joint slow = joint;
  slow.velocity_max = from_deg(2.5);
  EXPECT_NEAR(axis_registers::quickest_time(slow, from_deg(10)), 4 + 1, 1e-9)
      << "cruises before it has its acceleration";
}

TEST(AxisRegistersDriver, self_test_asks_every_board_and_tells_of_one_that_fails) {
  RegisterCell cell;
  cell.start_at(20);
  ASSERT_TRUE(cell.driver->service(DeviceService::kSelfTest, cell.now));
  EXPECT_EQ(cell.driver->state(), DriverState::kMoving);
  EXPECT_EQ(cell.driver->service(DeviceService::kSelfTest, cell.now).error().code,
            ErrorCode::kBusy);
  EXPECT_EQ(cell.finish().kind, Kind::kDone);
  for (const auto& axis : cell.axes) EXPECT_EQ(axis.self_tests, 1);
  cell.expect_honest();
  EXPECT_EQ(cell.driver->positions()[0].quality, PositionQuality::kCommanded);
  EXPECT_TRUE(cell.driver->counted(0)) << "what was read at the opening still counts";
  // The others test themselves all the same, and a board whose time is over has failed.
  cell.axes[1].told().moving = true;
  cell.axes[1].endless = true;
  cell.axes[4].test_fails = true;
  ASSERT_TRUE(cell.driver->service(DeviceService::kSelfTest, cell.now));
  const DriverEvent end = cell.finish();
  EXPECT_EQ(end.kind, Kind::kFailed);
  EXPECT_EQ(end.error, (Error{ErrorCode::kSelfTestFailed, 1}));
  EXPECT_EQ(cell.driver->axis_fault(4)->code, ErrorCode::kSelfTestFailed);
  for (const auto& axis : cell.axes) EXPECT_EQ(axis.self_tests, 2);
  EXPECT_FALSE(cell.driver->axis_fault(0));
  // Held until it is acknowledged.
  EXPECT_EQ(cell.driver->state(), DriverState::kFault);
  cell.axes[1].told().moving = cell.axes[1].endless = false;
  cell.axes[4].test_fails = false;
  ASSERT_TRUE(cell.driver->clear_fault(cell.now));
  EXPECT_EQ(cell.finish().kind, Kind::kDone);
  ASSERT_TRUE(cell.driver->service(DeviceService::kSelfTest, cell.now));
  EXPECT_EQ(cell.finish().kind, Kind::kDone);
}

TEST(AxisRegistersDriver, self_test_tells_of_a_board_whose_power_was_away) {
  RegisterCell cell;
  cell.start_at(20);
  cell.axes[2].told().moving = true;
  cell.axes[2].endless = true;
  ASSERT_TRUE(cell.driver->service(DeviceService::kSelfTest, cell.now));
  cell.run_for(1s);
  cell.axes[2].reboot();
  const DriverEvent end = cell.finish();
  EXPECT_EQ(end.kind, Kind::kFailed);
  EXPECT_EQ(end.error, (Error{ErrorCode::kPositionUnknown, 2}));
}

TEST(AxisRegistersDriver, boards_that_tell_nothing_of_themselves_are_asked_for_no_self_test) {
  AxisRegistersDevice boards = test::six_boards();
  boards.reports_status = false;
  RegisterCell cell(AxisRegisterProfile::kAsBuilt, boards);
  cell.start_at();
  for (const DeviceService what : {DeviceService::kSelfTest, DeviceService::kWake}) {
    EXPECT_EQ(cell.driver->service(what, cell.now).error().code, ErrorCode::kNoSuchService);
  }
}

TEST(AxisRegistersDriver, every_fault_of_an_axis_has_its_word) {
  const std::vector<std::pair<AxisFault, ErrorCode>> kWords{
      {AxisFault::kFollowingError, ErrorCode::kFollowingError},
      {AxisFault::kStalled, ErrorCode::kStalled},
      {AxisFault::kEncodersDisagree, ErrorCode::kEncodersDisagree},
      {AxisFault::kJointEncoder, ErrorCode::kEncoderLost},
      {AxisFault::kMotorEncoder, ErrorCode::kEncoderLost},
      {AxisFault::kEndStop, ErrorCode::kEndStop},
      {AxisFault::kHomingTimeout, ErrorCode::kHomingFailed},
      {AxisFault::kEndStopStuck, ErrorCode::kHomingFailed},
      {AxisFault::kSupplyLow, ErrorCode::kSupplyFlag},
      {AxisFault::kTooHot, ErrorCode::kOverheated},
      {AxisFault::kLinkSilent, ErrorCode::kLinkSilent},
      {AxisFault::kSelfTest, ErrorCode::kSelfTestFailed},
      {static_cast<AxisFault>(77), ErrorCode::kUnexpectedReply}};
  EXPECT_FALSE(axis_registers::fault_of(0));
  for (const auto& [fault, code] : kWords) {
    RegisterCell cell;
    cell.start_at();
    ASSERT_TRUE(cell.driver->move(cell.to({0, 0, 0, 60, 0, 0}), cell.now));
    cell.run_for(1s);
    cell.axes[3].stop(fault);
    const DriverEvent end = cell.finish();
    EXPECT_EQ(end.kind, Kind::kFailed);
    EXPECT_EQ(end.error.code, code);
    EXPECT_EQ(end.error.index, 3);
    cell.expect_honest();
    // The board gave a word and no number; so the sentence has none.
    const std::string sentence = describe(end.error, "the forearm");
    const bool numbers = code == ErrorCode::kUnexpectedReply;
    EXPECT_EQ(sentence.find_first_of("0123456789") != std::string::npos, numbers) << sentence;
  }
}

TEST(AxisRegistersDriver, homing_can_have_another_order_and_learns_a_clear_position) {
  AxisRegistersDevice boards = test::six_boards();
  const std::vector<std::size_t> wanted{5, 0, 3, 1, 4, 2};
  for (std::size_t k = 0; k < wanted.size(); ++k) {
    boards.boards[wanted[k]].homing_place = static_cast<std::uint8_t>(k + 1);
  }
  RegisterCell cell(kDocument, boards, {});
  for (auto& axis : cell.axes) axis.home_q += from_deg(4);
  cell.driver->open(cell.now);
  cell.run_until([&] { return cell.saw(Kind::kReady); }, 10);
  cell.events.clear();
  ASSERT_TRUE(cell.driver->home(cell.now));
  std::vector<std::size_t> order;
  cell.run_until(
      [&] {
        for (std::size_t i = 0; i < 6; ++i) {
          const bool homing = cell.axes[i].status().homing;
          if (homing && (order.empty() || order.back() != i)) order.push_back(i);
        }
        return !cell.ends().empty();
      },
      200);
  EXPECT_EQ(cell.finish().kind, Kind::kDone);
  EXPECT_EQ(order, wanted);
  EXPECT_EQ(cell.driver->positions()[0].quality, Quality::kCommanded);
  EXPECT_NEAR(to_deg(cell.driver->positions()[0].q), -166, 1e-9);
  cell.expect_honest();
  // Homed again from where homing ends: the register does not say whether it was touched.
  ASSERT_TRUE(cell.driver->home(cell.now));
  EXPECT_EQ(cell.finish(600).kind, Kind::kDone);
  EXPECT_EQ(cell.driver->positions()[0].quality, Quality::kUncertain);
  EXPECT_LT(to_deg(cell.driver->positions()[0].upper - cell.driver->positions()[0].lower), 5.1);
  cell.expect_honest();
}

TEST(AxisRegistersDriver, stop_while_homing_cancels_it) {
  RegisterCell cell;
  cell.driver->open(cell.now);
  cell.run_until([&] { return cell.saw(Kind::kReady); }, 10);
  cell.events.clear();
  cell.axes[0].home_q = from_deg(-1000);
  ASSERT_TRUE(cell.driver->home(cell.now));
  cell.run_for(2s);
  EXPECT_TRUE(cell.axes[0].status().homing);
  cell.driver->stop(cell.now);
  EXPECT_EQ(cell.finish().kind, Kind::kStopped);
  EXPECT_FALSE(cell.axes[0].status().homing);
  EXPECT_EQ(cell.axes[0].cancels, 1);
  EXPECT_EQ(cell.driver->positions()[0].quality, Quality::kLost);
  EXPECT_EQ(cell.axes[1].homings, 0);
}

TEST(AxisRegistersDriver, homing_without_end_is_given_up) {
  AxisRegistersTiming timing;
  timing.homing_limit = 5s;
  RegisterCell cell(kDocument, test::six_boards(), timing);
  cell.driver->open(cell.now);
  cell.run_until([&] { return cell.saw(Kind::kReady); }, 10);
  cell.events.clear();
  cell.axes[0].endless = true;
  ASSERT_TRUE(cell.driver->home(cell.now));
  const DriverEvent end = cell.finish();
  EXPECT_EQ(end.error, (Error{ErrorCode::kHomingFailed, 0}));
  cell.run_for(3s);
  EXPECT_EQ(cell.driver->state(), DriverState::kFault);
  EXPECT_TRUE(cell.axes[0].status().emergency_stopped);
  EXPECT_FALSE(cell.axes[0].status().homing);
}

TEST(AxisRegistersDriver, somebody_elses_emergency_stop_is_a_fault_until_it_is_acknowledged) {
  RegisterCell cell;
  cell.start_at();
  cell.axes[2].emergency_stop();
  cell.run_for(3s);
  ASSERT_TRUE(cell.saw(Kind::kNotice));
  cell.events.clear();
  EXPECT_EQ(cell.driver->axis_fault(2), (Error{ErrorCode::kEmergencyStop, 2}));
  EXPECT_EQ(cell.driver->state(), DriverState::kFault) << "of the whole arm";
  EXPECT_EQ(cell.driver->move(cell.to({9, 0, 0, 0, 0, 0}), cell.now).error().code,
            ErrorCode::kEmergencyStop);
  EXPECT_TRUE(cell.axes[2].status().emergency_stopped);
  ASSERT_TRUE(cell.driver->clear_fault(cell.now));
  EXPECT_EQ(cell.finish().kind, Kind::kDone);
  EXPECT_FALSE(cell.axes[2].status().emergency_stopped);
  EXPECT_EQ(cell.driver->axis_fault(2), std::nullopt);
  ASSERT_TRUE(cell.driver->move(cell.to({9, 0, 9, 0, 0, 0}), cell.now));
  EXPECT_EQ(cell.finish().kind, Kind::kDone);
}

TEST(AxisRegistersDriver, a_board_that_takes_a_target_and_keeps_the_old_one_is_caught) {
  RegisterCell cell;
  cell.start_at();
  cell.joints[3].upper = from_deg(200);
  cell.new_host();
  cell.start_at();
  // The host's file allows 190, the board does not, and the wire has no word for it.
  ASSERT_TRUE(cell.driver->move(cell.to({0, 0, 0, 190, 0, 0}), cell.now));
  const DriverEvent end = cell.finish();
  EXPECT_EQ(end.error, (Error{ErrorCode::kMotionIgnored, 3}));
  cell.expect_honest();
}

TEST(AxisRegistersDriver, a_move_that_never_ends_is_given_up_and_stopped) {
  RegisterCell cell;
  cell.start_at();
  cell.axes[1].endless = true;
  ASSERT_TRUE(cell.driver->move(cell.to({0, 20, 0, 0, 0, 0}), cell.now));
  const Instant start = cell.now;
  const DriverEvent end = cell.finish();
  EXPECT_EQ(end.error, (Error{ErrorCode::kMotionIgnored, 1}));
  EXPECT_NEAR(to_seconds(cell.now - start), 4 * 1.5 + 2, 0.5);
  cell.run_for(3s);
  for (const auto& axis : cell.axes) EXPECT_TRUE(axis.status().emergency_stopped);
  EXPECT_EQ(cell.driver->state(), DriverState::kFault);
  EXPECT_EQ(cell.driver->move(cell.to({0, 0, 0, 0, 0, 0}), cell.now).error().code,
            ErrorCode::kMotionIgnored);
}

TEST(AxisRegistersDriver, a_reopened_port_trusts_only_a_target_that_is_still_there) {
  RegisterCell cell;
  cell.start_at(10);
  cell.driver->close(cell.now);
  EXPECT_EQ(cell.driver->state(), DriverState::kClosed);
  EXPECT_EQ(cell.driver->move(cell.to({0, 0, 0, 0, 0, 0}), cell.now).error().code,
            ErrorCode::kPortClosed);
  cell.axes[4].place(from_deg(55));  // another program was here
  cell.axes[5].reboot();
  cell.driver->open(cell.now);
  cell.run_until([&] { return cell.saw(Kind::kReady); }, 10);
  EXPECT_EQ(cell.driver->positions()[0].quality, Quality::kCommanded);
  EXPECT_EQ(cell.driver->positions()[4].quality, Quality::kUncertain);
  EXPECT_EQ(cell.driver->positions()[5].quality, Quality::kLost);
  cell.expect_honest();
}

TEST(AxisRegistersDriver, closing_ends_a_command_and_leaves_its_interval) {
  RegisterCell cell;
  cell.start_at();
  ASSERT_TRUE(cell.driver->move(cell.to({90, 0, 0, 0, 0, 0}), cell.now));
  cell.run_for(1s);
  cell.driver->close(cell.now);
  cell.run_for(1ms);
  ASSERT_EQ(cell.ends().size(), 1U);
  EXPECT_EQ(cell.ends()[0].error.code, ErrorCode::kPortClosed);
  EXPECT_FALSE(cell.driver->take_transfer(cell.now));
  EXPECT_FALSE(cell.driver->next_deadline());
  cell.run_for(5s);
  cell.expect_honest("after the port went");
  cell.driver->stop(cell.now);
  cell.run_for(1ms);
  EXPECT_EQ(cell.ends().back().kind, Kind::kStopped);
}

// What the next host finds on boards that kept their power, and on those that did not.

/// A host dies and the next one begins with what was recorded.
void restart(RegisterCell& cell, const DriverMemory& memory) {
  const auto known = cell.driver->positions();
  const std::vector<JointPosition> recorded(known.begin(), known.end());
  cell.new_host();
  cell.driver->declare_positions(recorded);
  cell.driver->remember(memory);
  cell.driver->open(cell.now);
}

bool opened(RegisterCell& cell) {
  return cell.run_until(
      [&] {
        const DriverState state = cell.driver->state();
        return state == DriverState::kReady || state == DriverState::kFault;
      },
      120);
}

TEST(AxisRegistersRestart, homed_boards_that_kept_their_power_are_known_again) {
  RegisterCell cell;
  cell.start_at();
  ASSERT_TRUE(cell.driver->move(cell.to({10, 0, -20, 0, 0, 0}), cell.now));
  EXPECT_EQ(cell.finish().kind, Kind::kDone);
  restart(cell, {});
  ASSERT_TRUE(opened(cell));
  for (std::size_t i = 0; i < 6; ++i) {
    EXPECT_EQ(cell.driver->positions()[i].quality, Quality::kCommanded) << i;
    EXPECT_TRUE(cell.driver->counted(i)) << i;
  }
  EXPECT_NEAR(cell.driver->counted(2)->lower / 2 + cell.driver->counted(2)->upper / 2,
              from_deg(-20), 1e-9);
  cell.expect_honest();
  cell.axes[1].reboot();
  restart(cell, {});
  ASSERT_TRUE(opened(cell));
  EXPECT_EQ(cell.driver->positions()[1].quality, Quality::kLost) << "its power was away";
  EXPECT_FALSE(cell.driver->counted(1));
}

TEST(AxisRegistersRestart, a_host_that_died_in_a_motion_leaves_boards_that_end_it_and_are_known) {
  RegisterCell cell;
  cell.start_at();
  ASSERT_TRUE(cell.driver->move(cell.to({90, 0, -60, 0, 0, 0}), cell.now));
  cell.run_for(1200ms);
  ASSERT_TRUE(cell.axes[0].status().moving);
  restart(cell, {.ended_in_motion = true});
  ASSERT_TRUE(cell.run_until([&] { return cell.driver->goes_on_until().has_value(); }, 10));
  EXPECT_EQ(cell.driver->state(), DriverState::kOpening) << "it is waited for";
  ASSERT_TRUE(opened(cell));
  EXPECT_EQ(cell.driver->state(), DriverState::kReady);
  EXPECT_FALSE(cell.driver->goes_on_until());
  EXPECT_EQ(cell.driver->positions()[0].quality, Quality::kCommanded);
  EXPECT_NEAR(cell.driver->positions()[0].q, from_deg(90), 1e-9);
  EXPECT_EQ(cell.driver->positions()[2].quality, Quality::kCommanded);
  cell.expect_honest();
}

TEST(AxisRegistersRestart, behind_a_stop_the_register_reads_the_target_and_settles_nothing) {
  RegisterCell cell;
  cell.start_at();
  ASSERT_TRUE(cell.driver->move(cell.to({90, 0, 0, 0, 0, 0}), cell.now));
  cell.run_for(1s);
  cell.driver->stop(cell.now);
  EXPECT_EQ(cell.finish().kind, Kind::kStopped);
  EXPECT_TRUE(cell.driver->held_by_stop());
  restart(cell, {.held_by_stop = true});
  EXPECT_TRUE(cell.driver->held_by_stop()) << "as long as nobody has looked";
  ASSERT_TRUE(opened(cell));
  cell.events.clear();
  ASSERT_TRUE(cell.driver->clear_fault(cell.now));
  EXPECT_EQ(cell.finish().kind, Kind::kDone);
  EXPECT_FALSE(cell.driver->held_by_stop());
  restart(cell, {});
  ASSERT_TRUE(opened(cell));
  EXPECT_EQ(cell.driver->positions()[0].quality, Quality::kUncertain);
  EXPECT_FALSE(cell.driver->counted(0));
  EXPECT_EQ(cell.driver->positions()[1].quality, Quality::kCommanded) << "it was not moved";
  cell.expect_honest();
}

TEST(AxisRegistersRestart, a_latch_that_is_on_record_is_told_as_such_and_released_without_motion) {
  for (const bool recorded : {true, false}) {
    RegisterCell cell;
    cell.start_at(20);
    cell.driver->stop(cell.now);
    EXPECT_EQ(cell.finish().kind, Kind::kStopped);
    restart(cell, {.held_by_stop = recorded});
    ASSERT_TRUE(opened(cell));
    EXPECT_EQ(cell.driver->state(), DriverState::kFault);
    const ErrorCode who = recorded ? ErrorCode::kStopLatched : ErrorCode::kEmergencyStop;
    EXPECT_EQ(cell.driver->fault(), (Error{who, 0}));
    EXPECT_EQ(cell.driver->home(cell.now).error().code, who);
    cell.events.clear();
    ASSERT_TRUE(cell.driver->clear_fault(cell.now));
    EXPECT_TRUE(cell.driver->clearing());
    EXPECT_EQ(cell.driver->state(), DriverState::kOpening);
    EXPECT_EQ(cell.finish().kind, Kind::kDone);
    EXPECT_FALSE(cell.driver->clearing());
    EXPECT_EQ(cell.driver->state(), DriverState::kReady);
    for (const auto& axis : cell.axes) {
      EXPECT_FALSE(axis.status().emergency_stopped);
      EXPECT_EQ(axis.moves + axis.homings, 0);
      EXPECT_NEAR(axis.q(), from_deg(20), 1e-9);
    }
    ASSERT_TRUE(cell.driver->home(cell.now));
    EXPECT_EQ(cell.finish().kind, Kind::kDone) << "software brings it back";
  }
}

TEST(AxisRegistersRestart, what_the_register_reads_contradicts_a_declaration_of_somebody_else) {
  RegisterCell cell;
  for (auto& axis : cell.axes) axis.place(from_deg(30));
  cell.driver->open(cell.now);
  ASSERT_TRUE(opened(cell));
  EXPECT_EQ(cell.driver->positions()[3].quality, Quality::kUncertain) << "nobody has recorded it";
  EXPECT_TRUE(cell.driver->counted(3));
  EXPECT_NEAR(cell.driver->counted(3)->lower / 2 + cell.driver->counted(3)->upper / 2, from_deg(30),
              1e-9);
  cell.driver->stop(cell.now);
  EXPECT_EQ(cell.finish().kind, Kind::kStopped);
  EXPECT_FALSE(cell.driver->counted(3)) << "it may have been moving";
}

std::vector<JointPosition> all_at(double q_deg) {
  const double q = from_deg(q_deg);
  return std::vector<JointPosition>(6, {Quality::kCommanded, q, q, q});
}

TEST(AxisRegistersRestart, what_is_said_behind_a_stop_is_kept_by_the_next_host) {
  RegisterCell cell;
  cell.start_at();
  ASSERT_TRUE(cell.driver->move(cell.to({90, 0, 0, 0, 0, 0}), cell.now));
  cell.run_for(1500ms);
  cell.driver->stop(cell.now);
  EXPECT_EQ(cell.finish().kind, Kind::kStopped);
  ASSERT_TRUE(cell.driver->clear_fault(cell.now));
  cell.finish();
  restart(cell, {});
  ASSERT_TRUE(opened(cell));
  const double truth = cell.axes[0].q();
  std::vector<JointPosition> said = all_at(0);
  said[0] = {Quality::kCommanded, truth, truth, truth};
  cell.driver->declare_positions(said);
  const JointPosition& first = cell.driver->positions()[0];
  EXPECT_EQ(first.quality, Quality::kCommanded);
  EXPECT_NEAR(first.upper - first.q, from_deg(0.5), 1e-9) << "as fine as the board's angles";
  EXPECT_NEAR(first.count_zero.value_or(9), truth - from_deg(90), 1e-9);
  for (int host = 0; host < 2; ++host) {
    restart(cell, {});
    ASSERT_TRUE(opened(cell));
    EXPECT_EQ(cell.driver->positions()[0].quality, Quality::kCommanded) << host;
    EXPECT_NEAR(cell.driver->positions()[0].q, truth, 1e-9);
    EXPECT_FALSE(cell.driver->counted(0)) << "the register is no evidence there";
    cell.expect_honest();
  }
  ASSERT_TRUE(cell.driver->move(cell.to({30, 0, 0, 0, 0, 0}), cell.now));
  EXPECT_EQ(cell.finish().kind, Kind::kDone);
  EXPECT_FALSE(cell.driver->positions()[0].count_zero) << "the register is where it stands again";
  restart(cell, {});
  ASSERT_TRUE(opened(cell));
  EXPECT_TRUE(cell.driver->counted(0));
  cell.expect_honest();
}

TEST(AxisRegistersRestart, a_host_that_died_before_its_order_left_settles_nothing_behind_a_stop) {
  RegisterCell cell;
  cell.start_at();
  ASSERT_TRUE(cell.driver->move(cell.to({90, 0, 0, 0, 0, 0}), cell.now));
  cell.run_for(1500ms);
  cell.driver->stop(cell.now);
  EXPECT_EQ(cell.finish().kind, Kind::kStopped);
  ASSERT_TRUE(cell.driver->clear_fault(cell.now));
  cell.finish();
  // Its last record: an intent, with the latch that it was about to release.
  restart(cell, {.ended_in_motion = true, .held_by_stop = true});
  ASSERT_TRUE(opened(cell));
  EXPECT_EQ(cell.driver->positions()[0].quality, Quality::kUncertain);
  cell.expect_honest();
}

TEST(AxisRegistersRestart, a_board_that_knows_better_takes_no_statement) {
  RegisterCell cell;
  for (auto& axis : cell.axes) axis.place(from_deg(30));
  cell.axes[2].reboot();
  cell.driver->open(cell.now);
  ASSERT_TRUE(opened(cell));
  cell.driver->declare_positions(all_at(30));
  EXPECT_EQ(cell.driver->positions()[2].quality, Quality::kLost) << "it is not homed";
  EXPECT_EQ(cell.driver->positions()[3].quality, Quality::kCommanded);
  cell.driver->declare_positions(all_at(10));
  EXPECT_NEAR(cell.driver->positions()[3].q, from_deg(30), 1e-9) << "it counts elsewhere";
}

TEST(AxisRegistersRestart, a_board_that_never_ends_its_motion_is_not_waited_for_for_ever) {
  RegisterCell cell;
  cell.start_at();
  cell.axes[4].endless = true;
  ASSERT_TRUE(cell.driver->move(cell.to({0, 0, 0, 0, 40, 0}), cell.now));
  cell.run_for(1s);
  restart(cell, {.ended_in_motion = true});
  const Instant start = cell.now;
  ASSERT_TRUE(opened(cell));
  EXPECT_NEAR(to_seconds(cell.now - start), 60, 5);
  EXPECT_EQ(cell.driver->positions()[4].quality, Quality::kUncertain);
  EXPECT_EQ(cell.driver->positions()[3].quality, Quality::kCommanded);
  cell.expect_honest();
}

TEST(AxisRegistersDriver, commanding_does_not_allocate) {
  RegisterCell cell;
  cell.start_at();
  const JointMove move = cell.to({40, 0, 0, 0, 0, -20});
  spi::Bytes miso;
  const test::AllocationCounter allocations;
  ASSERT_TRUE(cell.driver->move(move, cell.now));
  int events = 0;
  const auto run = [&] {
    for (int i = 0; i < 100'000 && events == 0; ++i) {
      if (const auto transfer = cell.driver->take_transfer(cell.now)) {
        miso.resize(transfer->mosi.size());
        for (std::size_t k = 0; k < cell.boards.size(); ++k) {
          if ((transfer->select >> k & 1) == 0) continue;
          cell.boards[k].exchange({transfer->mosi.data(), transfer->mosi.size()},
                                  {miso.data(), miso.size()});
        }
        cell.now += transfer->setup + spi::wire_time(*transfer);
        cell.driver->exchanged({miso.data(), miso.size()}, cell.now);
      } else {
        cell.now = std::max(cell.now, cell.driver->next_deadline().value_or(cell.now + 1ms));
        cell.driver->poll(cell.now);
      }
      for (auto& axis : cell.axes) axis.advance(cell.now);
      while (cell.driver->take_event()) ++events;
    }
  };
  run();
  EXPECT_EQ(events, 1);
  events = 0;
  cell.driver->stop(cell.now);
  run();
  EXPECT_EQ(events, 1);
  EXPECT_EQ(allocations.count(), 0U);
}

}  // namespace
}  // namespace sinew
