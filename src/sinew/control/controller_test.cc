#include "sinew/control/controller.h"

#include <gtest/gtest.h>

#include <set>

#include "sinew/control/controller_test_cell.h"
#include "sinew/core/error_code.h"
#include "support/allocation_guard.h"
#include "support/property.h"

namespace sinew::control::test {
namespace {

using Kind = ControlEvent::Kind;
using enum MachineState;

constexpr const char* kStreaming = "learm";
constexpr const char* kWholeMoves = "bigrobotarm";

TEST(Controller, a_motion_begins_at_ready_and_ends_there) {
  ControlCell cell(kStreaming);
  EXPECT_EQ(cell.controller.state(), kOff);
  cell.make_ready();
  const JointVector q = cell.by(0.2);
  const std::uint32_t id = cell.give(Begin{&cell.path_to(q)});
  EXPECT_EQ(cell.controller.state(), kMoving);
  EXPECT_EQ(cell.controller.task(), id);
  ASSERT_TRUE(cell.run_until([&] { return cell.end_of(id).has_value(); }));
  EXPECT_EQ(cell.end_of(id)->kind, Kind::kDone);
  EXPECT_EQ(cell.states(), (std::vector{kMoving, kReady}));
  EXPECT_EQ(*cell.controller.reference(), q);
  for (std::size_t j = 0; j < q.size(); ++j) {
    EXPECT_EQ(cell.driver.pieces.back().q[j], q[j]);
    EXPECT_EQ(cell.driver.pieces.back().qd[j], 0);
  }
}

TEST(Controller, moves_for_the_holder_of_the_lease_only) {
  ControlCell cell(kStreaming);
  cell.make_ready();
  MotionSource& motion = cell.path_to(cell.by(0.1));
  const LeaseToken stranger{.client = 9, .epoch = cell.lease.epoch};
  const LeaseToken old{.client = cell.lease.client, .epoch = cell.lease.epoch - 1};
  for (const LeaseToken& wrong : {stranger, old, LeaseToken{}}) {
    cell.cycle({Command{100, wrong, Begin{&motion}}});
    ASSERT_TRUE(cell.end_of(100));
    EXPECT_EQ(cell.end_of(100)->kind, Kind::kRefused);
    EXPECT_EQ(cell.end_of(100)->error.code, ErrorCode::kLeaseLost);
    cell.events.clear();
  }
  cell.run(100ms);
  EXPECT_TRUE(cell.driver.pieces.empty());
}

TEST(Controller, is_stopped_by_anybody) {
  ControlCell cell(kStreaming);
  cell.make_ready();
  const std::uint32_t id = cell.give(Begin{&cell.path_to(cell.by(0.5))});
  cell.run(200ms);
  cell.cycle({Command{100, LeaseToken{.client = 9}, Stop{}}});
  EXPECT_EQ(cell.driver.stops, 1);  // in the very same cycle
  EXPECT_EQ(cell.controller.state(), kStopping);
  const std::size_t pieces = cell.driver.pieces.size();
  ASSERT_TRUE(cell.run_until([&] { return cell.controller.state() == kReady; }));
  EXPECT_EQ(cell.driver.pieces.size(), pieces);
  EXPECT_EQ(cell.end_of(id)->kind, Kind::kStopped);
  EXPECT_EQ(cell.end_of(id)->cause, StopCause::kClient);
}

TEST(Controller, a_pause_rests_on_the_way_and_goes_on_to_its_end) {
  ControlCell cell(kStreaming);
  cell.make_ready();
  const JointVector q = cell.by(0.5);
  const std::uint32_t id = cell.give(Begin{&cell.path_to(q)});
  cell.run(400ms);
  cell.give(Hold{});
  EXPECT_EQ(cell.controller.state(), kStopping);
  ASSERT_TRUE(cell.run_until([&] { return cell.controller.state() == kHeld; }));
  EXPECT_EQ(cell.driver.stops, 0);
  const JointVector held = *cell.controller.reference();
  EXPECT_LT(held[0], q[0] - 0.01);
  EXPECT_FALSE(cell.end_of(id));
  cell.run(1s);
  EXPECT_EQ(*cell.controller.reference(), held);
  cell.give(Resume{});
  ASSERT_TRUE(cell.run_until([&] { return cell.end_of(id).has_value(); }));
  EXPECT_EQ(cell.end_of(id)->kind, Kind::kDone);
  EXPECT_EQ(*cell.controller.reference(), q);
}

TEST(Controller, whole_moves_pause_between_two_of_them) {
  ControlCell cell(kWholeMoves);
  cell.make_ready();
  JointMove first{.q = cell.by(0.1), .qd = {}, .duration = 1s};
  first.qd.resize(first.q.size());
  JointMove second = first;
  second.q = cell.by(0.2);
  PieceMotion motion(*cell.controller.reference(), {first, second}, cell.robot);
  const std::uint32_t id = cell.give(Begin{&motion});
  cell.run(300ms);
  cell.give(Hold{});
  ASSERT_TRUE(cell.run_until([&] { return cell.controller.state() == kHeld; }));
  EXPECT_EQ(*cell.controller.reference(), first.q);
  cell.give(Resume{});
  ASSERT_TRUE(cell.run_until([&] { return cell.end_of(id).has_value(); }));
  EXPECT_EQ(*cell.controller.reference(), second.q);
}

TEST(Controller, a_held_motion_is_given_up_by_a_stop) {
  ControlCell cell(kStreaming);
  cell.make_ready();
  const std::uint32_t id = cell.give(Begin{&cell.path_to(cell.by(0.5))});
  cell.run(300ms);
  cell.give(Hold{});
  ASSERT_TRUE(cell.run_until([&] { return cell.controller.state() == kHeld; }));
  cell.give(Stop{});
  EXPECT_EQ(cell.controller.state(), kReady);
  EXPECT_EQ(cell.end_of(id)->kind, Kind::kStopped);
}

TEST(Controller, a_silent_holder_loses_the_lease_and_the_motion_is_held) {
  ControlCell cell(kStreaming);
  cell.make_ready();
  const std::uint32_t id = cell.give(Begin{&cell.path_to(cell.by(1.0))});
  cell.run(100ms);
  cell.renews = false;
  cell.run(900ms);
  EXPECT_EQ(cell.controller.state(), kMoving);
  ASSERT_TRUE(cell.run_until([&] { return cell.controller.state() == kHeld; }, 5s));
  EXPECT_EQ(cell.controller.last_stop(), StopCause::kLeaseEnded);
  EXPECT_FALSE(cell.end_of(id));
  const std::uint32_t resume = cell.give(Resume{});
  EXPECT_EQ(cell.end_of(resume)->error.code, ErrorCode::kLeaseLost);
}

TEST(Controller, a_take_over_brakes_on_the_path_and_the_motion_is_held) {
  ControlCell cell(kStreaming);
  cell.make_ready();
  const std::uint32_t id = cell.give(Begin{&cell.path_to(cell.by(0.5))});
  cell.run(200ms);
  cell.cycle({Command{100, LeaseToken{.client = 9}, TakeLease{.take_over = false}}});
  EXPECT_EQ(cell.end_of(100)->error.code, ErrorCode::kLeaseHeld);
  EXPECT_EQ(cell.driver.stops, 0);
  cell.renews = false;
  cell.cycle({Command{101, LeaseToken{.client = 9}, TakeLease{.take_over = true}}});
  ASSERT_TRUE(cell.run_until([&] { return cell.controller.state() == kHeld; }, 5s));
  EXPECT_EQ(cell.controller.last_stop(), StopCause::kTakeOver);
  EXPECT_FALSE(cell.end_of(id));
  cell.lease = *cell.controller.lease_holder(cell.now);
  EXPECT_EQ(cell.lease.client, 9U);
  // It is the new holder's to go on with.
  cell.renews = true;
  EXPECT_EQ(cell.end_of(cell.give(Resume{}))->kind, Kind::kDone);
  ASSERT_TRUE(cell.run_until([&] { return cell.end_of(id).has_value(); }));
  EXPECT_EQ(cell.end_of(id)->kind, Kind::kDone);
}

TEST(Controller, a_stop_waits_for_as_long_as_the_device_can_still_move) {
  for (const bool told : {true, false}) {
    ControlCell cell("bigrobotarm", true);
    cell.driver.stop_takes = 21s;
    cell.driver.tells_how_long = told;
    cell.make_ready();
    cell.give(Begin{&cell.whole_move_to(cell.by(1.2), 20s)});
    cell.run(1s);
    cell.give(Stop{});
    cell.run(25s);
    EXPECT_EQ(cell.controller.state(), told ? MachineState::kReady : MachineState::kFault);
    EXPECT_EQ(cell.controller.latched().has_value(), !told);
  }
}

TEST(Controller, a_jog_goes_on_as_long_as_it_is_asked_for_and_rests_by_itself) {
  ControlCell cell(kStreaming);
  cell.make_ready();
  const JointVector from = *cell.controller.reference();
  JogAt jog;
  jog.velocity.velocity = {0.2, 0, 0, 0, 0};
  const std::uint32_t id = cell.give(jog);
  EXPECT_EQ(cell.controller.state(), kMoving);
  for (int k = 0; k < 50; ++k) cell.give(jog);
  EXPECT_EQ(cell.controller.state(), kMoving);
  ASSERT_TRUE(cell.run_until([&] { return cell.controller.state() == kReady; }, 2s));
  EXPECT_EQ(cell.end_of(id)->kind, Kind::kDone);
  const JointVector to = *cell.controller.reference();
  EXPECT_GT(to[0], from[0] + 0.05);
  EXPECT_LT(to[0], from[0] + 0.25);
  EXPECT_EQ(to[1], from[1]);
  EXPECT_EQ(cell.driver.stops, 0);
}

TEST(Controller, devices_that_take_whole_moves_do_not_jog) {
  ControlCell cell(kWholeMoves);
  cell.make_ready();
  JogAt jog;
  jog.velocity.velocity = {0.2, 0, 0, 0, 0};
  const std::uint32_t id = cell.give(jog);
  EXPECT_EQ(cell.end_of(id)->error.code, ErrorCode::kTaskNotSupported);
}

TEST(Controller, another_feed_takes_another_time) {
  const auto time_at = [](double share) {
    ControlCell cell(kStreaming);
    cell.make_ready();
    cell.give(SetFeed{share});
    const Instant begin = cell.now;
    const std::uint32_t id = cell.give(Begin{&cell.path_to(cell.by(0.5))});
    EXPECT_TRUE(cell.run_until([&] { return cell.end_of(id).has_value(); }));
    return to_seconds(cell.now - begin);
  };
  const double whole = time_at(1);
  EXPECT_GT(time_at(0.25), 2.5 * whole);
  ControlCell cell(kStreaming);
  cell.make_ready();
  for (const double wrong : {-0.1, 2.1, std::nan("")}) {
    const std::uint32_t id = cell.give(SetFeed{wrong});
    EXPECT_EQ(cell.end_of(id)->error.code, ErrorCode::kMoveInput);
  }
  EXPECT_EQ(cell.controller.feed(), 1);
}

TEST(Controller, a_feed_of_zero_waits_and_the_next_one_goes_on) {
  ControlCell cell(kStreaming);
  cell.make_ready();
  const std::uint32_t id = cell.give(Begin{&cell.path_to(cell.by(0.5))});
  cell.run(300ms);
  cell.give(SetFeed{0});
  cell.run(2s);
  EXPECT_EQ(cell.controller.state(), kMoving);
  EXPECT_EQ(cell.driver.state(), DriverState::kReady);
  cell.give(SetFeed{1});
  ASSERT_TRUE(cell.run_until([&] { return cell.end_of(id).has_value(); }));
  EXPECT_EQ(cell.end_of(id)->kind, Kind::kDone);
}

TEST(Controller, a_fault_is_latched_until_its_cause_is_gone_and_acknowledged) {
  ControlCell cell(kStreaming);
  cell.make_ready();
  const std::uint32_t id = cell.give(Begin{&cell.path_to(cell.by(0.5))});
  cell.run(200ms);
  cell.driver.fail({ErrorCode::kEncodersDisagree, 2});
  cell.cycle();
  EXPECT_EQ(cell.end_of(id)->kind, Kind::kFailed);
  EXPECT_EQ(cell.end_of(id)->error.code, ErrorCode::kEncodersDisagree);
  ASSERT_TRUE(cell.run_until([&] { return cell.controller.state() == kFault; }, 1s));
  ASSERT_TRUE(cell.controller.latched());
  EXPECT_EQ(cell.controller.latched()->error, (Error{ErrorCode::kEncodersDisagree, 2}));
  // Later causes are listed, each once, and do not take the first one's place.
  for (int k = 0; k < 2; ++k) {
    cell.driver.fail({ErrorCode::kEncoderLost, 2});
    cell.run(50ms);
  }
  EXPECT_EQ(cell.controller.latched()->error.code, ErrorCode::kEncodersDisagree);
  ASSERT_EQ(cell.controller.later_causes().size(), 1U);
  EXPECT_EQ(cell.controller.later_causes()[0].error.code, ErrorCode::kEncoderLost);
  for (const auto& what : {CommandWhat(Begin{&cell.path_to(cell.by(0.1))}), CommandWhat(Enable{}),
                           CommandWhat(Resume{})}) {
    const std::uint32_t refused = cell.give(what);
    EXPECT_EQ(cell.end_of(refused)->error.code, ErrorCode::kWrongState);
  }
  const std::uint32_t acknowledged = cell.give(Acknowledge{});
  EXPECT_EQ(cell.end_of(acknowledged)->kind, Kind::kDone);
  EXPECT_EQ(cell.controller.state(), kOff);
  EXPECT_FALSE(cell.controller.latched());
  const std::size_t pieces = cell.driver.pieces.size();
  cell.run(2s);
  EXPECT_EQ(cell.driver.pieces.size(), pieces);
  EXPECT_EQ(cell.controller.state(), kOff);
  EXPECT_FALSE(cell.controller.latched()) << "closing the device is no fault of it";
}

TEST(Controller, a_fault_whose_cause_stays_is_not_acknowledged) {
  ControlCell cell(kStreaming);
  cell.make_ready();
  cell.driver.fail({ErrorCode::kEmergencyStop, 1});
  cell.driver.cause_stays = true;
  ASSERT_TRUE(cell.run_until([&] { return cell.controller.state() == kFault; }, 1s));
  const std::uint32_t id = cell.give(Acknowledge{});
  EXPECT_EQ(cell.end_of(id)->error.code, ErrorCode::kEmergencyStop);
  EXPECT_EQ(cell.controller.state(), kFault);
}

TEST(Controller, a_jog_that_is_refused_is_told_once_while_it_is_held) {
  ControlCell cell(kStreaming);
  cell.make_ready();
  cell.driver.refusal = Error{ErrorCode::kDeviceRefused, 0};
  JogAt jog;
  jog.velocity.velocity = {0.2, 0, 0, 0, 0};
  const auto hold = [&] {
    std::uint32_t last = 0;
    for (int k = 0; k < 20; ++k) {
      last = cell.give(jog);
      cell.run(50ms);
    }
    return last;
  };
  const auto told = [&] {
    return std::ranges::count_if(cell.events, [](const ControlEvent& event) {
      return event.kind == Kind::kStop || event.kind == Kind::kFailed;
    });
  };
  const auto before = told();
  const std::uint32_t last = hold();
  const auto once = told() - before;
  EXPECT_LE(once, 2) << "the jog that failed, and its stop";
  EXPECT_EQ(cell.end_of(last)->kind, Kind::kRefused);
  EXPECT_EQ(cell.end_of(last)->error.code, ErrorCode::kDeviceRefused) << "with its cause";
  // Let go, and pressed again: asked anew.
  cell.run(500ms);
  cell.driver.refusal.reset();
  const std::uint32_t again = cell.give(jog);
  EXPECT_FALSE(cell.end_of(again));
  ASSERT_TRUE(cell.run_until([&] { return cell.end_of(again).has_value(); }));
}

TEST(Controller, acknowledging_ends_before_the_port_is_closed) {
  for (const bool fails : {false, true}) {
    ControlCell cell(kStreaming);
    cell.make_ready();
    cell.driver.clearing_takes = 600ms;
    cell.driver.clearing_fails = fails;
    cell.driver.fail({ErrorCode::kStopLatched, 0});
    ASSERT_TRUE(cell.run_until([&] { return cell.controller.state() == kFault; }, 1s));
    const std::uint32_t id = cell.give(Acknowledge{});
    EXPECT_FALSE(cell.end_of(id));
    cell.run(300ms);
    EXPECT_EQ(cell.controller.state(), kFault);
    EXPECT_TRUE(cell.driver.clearing()) << "it is still being told";
    const std::uint32_t again = cell.give(Acknowledge{});
    EXPECT_EQ(cell.end_of(again)->error.code, ErrorCode::kWrongState);
    ASSERT_TRUE(cell.run_until([&] { return cell.end_of(id).has_value(); }, 2s));
    EXPECT_EQ(cell.end_of(id)->kind, fails ? Kind::kFailed : Kind::kDone);
    EXPECT_EQ(cell.controller.state(), fails ? kFault : kOff);
    if (fails) continue;
    const std::uint32_t enabled = cell.give(Enable{});
    cell.run_until([&] { return cell.end_of(enabled).has_value(); }, 2s);
    EXPECT_EQ(cell.controller.state(), kReady);
  }
}

TEST(Controller, acknowledging_waits_for_a_stop_that_is_under_way_in_the_device) {
  ControlCell cell(kStreaming);
  cell.make_ready();
  cell.driver.stop_takes = 400ms;
  cell.driver.stops_in_fault = true;
  cell.driver.fail({ErrorCode::kEmergencyStop, 0});
  ASSERT_TRUE(cell.run_until([&] { return cell.controller.state() == kFault; }, 1s));
  ASSERT_EQ(cell.driver.state(), DriverState::kStopping);
  const std::uint32_t id = cell.give(Acknowledge{});
  EXPECT_FALSE(cell.end_of(id));
  EXPECT_EQ(cell.driver.clears, 0);
  ASSERT_TRUE(cell.run_until([&] { return cell.end_of(id).has_value(); }, 2s));
  EXPECT_EQ(cell.end_of(id)->kind, Kind::kDone);
  EXPECT_EQ(cell.driver.clears, 1) << "what the stop has latched is cleared too";
  EXPECT_EQ(cell.controller.state(), kOff);
}

TEST(Controller, a_device_that_is_silent_at_enabling_is_a_fault_with_its_reason) {
  ControlCell cell(kStreaming);
  cell.driver.silent = true;
  cell.give(TakeLease{});
  cell.lease = *cell.controller.lease_holder(cell.now);
  const std::uint32_t id = cell.give(Enable{});
  ASSERT_TRUE(cell.run_until([&] { return cell.controller.state() == kFault; }, 10s));
  EXPECT_EQ(cell.end_of(id)->kind, Kind::kFailed);
  EXPECT_EQ(cell.controller.latched()->error.code, ErrorCode::kDeviceSilent);
}

TEST(Controller, a_doubt_of_the_driver_at_rest_takes_no_commands_until_it_is_over) {
  ControlCell cell(kStreaming);
  cell.make_ready();
  cell.driver.doubt(cell.now);
  cell.cycle();
  EXPECT_EQ(cell.controller.state(), kEnabling);
  const std::uint32_t id = cell.give(Home{});
  EXPECT_EQ(cell.end_of(id)->error.code, ErrorCode::kWrongState);
  ASSERT_TRUE(cell.run_until([&] { return cell.controller.state() == kReady; }, 1s));
}

TEST(Controller, a_pulled_plug_is_a_fault_and_the_motion_has_failed) {
  ControlCell cell(kStreaming);
  cell.make_ready();
  const std::uint32_t id = cell.give(Begin{&cell.path_to(cell.by(0.5))});
  cell.run(200ms);
  cell.port_open = false;
  ASSERT_TRUE(cell.run_until([&] { return cell.controller.state() == kFault; }, 1s));
  EXPECT_EQ(cell.end_of(id)->error.code, ErrorCode::kPortClosed);
  EXPECT_EQ(cell.controller.latched()->error.code, ErrorCode::kPortClosed);
}

TEST(Controller, a_host_that_was_away_stops_and_latches_and_one_that_is_late_twice_holds) {
  ControlCell cell(kStreaming);
  cell.make_ready();
  cell.give(Begin{&cell.path_to(cell.by(1.0))});
  cell.run(100ms);
  cell.now += 30ms;  // once is no reason
  cell.cycle();
  cell.run(100ms);
  EXPECT_EQ(cell.controller.state(), kMoving);
  cell.now += 30ms;
  cell.cycle();
  cell.now += 30ms;
  cell.cycle();
  EXPECT_EQ(cell.controller.last_stop(), StopCause::kCycleOverrun);
  ASSERT_TRUE(cell.run_until([&] { return cell.controller.state() == kHeld; }, 3s));
  cell.give(Resume{});
  cell.run(50ms);
  cell.now += 700ms;
  cell.cycle();
  ASSERT_TRUE(cell.run_until([&] { return cell.controller.state() == kFault; }, 3s));
  EXPECT_EQ(cell.controller.latched()->cause, StopCause::kClockGap);
}

TEST(Controller, a_low_supply_is_a_notice_and_the_motion_goes_on) {
  ControlCell cell(kStreaming);
  cell.make_ready();
  const std::uint32_t id = cell.give(Begin{&cell.path_to(cell.by(0.5))});
  cell.run(200ms);
  cell.driver.notice({ErrorCode::kSupplyLow, -1, 6.1, 6.5});
  ASSERT_TRUE(cell.run_until([&] { return cell.end_of(id).has_value(); }));
  EXPECT_EQ(cell.end_of(id)->kind, Kind::kDone);
  EXPECT_EQ(std::ranges::count(cell.events, Kind::kNotice, &ControlEvent::kind), 1);
}

TEST(Controller, a_motion_that_was_planned_from_elsewhere_is_refused) {
  ControlCell cell(kStreaming);
  cell.make_ready();
  MotionSource& motion = cell.path_to(cell.by(0.2));
  const std::uint32_t first = cell.give(Begin{&motion});
  ASSERT_TRUE(cell.run_until([&] { return cell.end_of(first).has_value(); }));
  const std::uint32_t again = cell.give(Begin{&motion});
  EXPECT_EQ(cell.end_of(again)->error.code, ErrorCode::kMovedUnasked);
}

TEST(Controller, a_piece_outside_the_limits_never_reaches_the_driver) {
  ControlCell cell(kWholeMoves);
  cell.make_ready();
  JointVector q = *cell.controller.reference();
  q[0] = cell.robot.joints[0].upper + 0.1;
  const std::uint32_t id = cell.give(Begin{&cell.whole_move_to(q)});
  cell.run(100ms);
  EXPECT_EQ(cell.end_of(id)->error.code, ErrorCode::kJointLimit);
  EXPECT_TRUE(cell.driver.pieces.empty());
  // Nothing moves: a stop would only be latched by boards that do so.
  EXPECT_EQ(cell.driver.stops, 0);
  ASSERT_TRUE(cell.run_until([&] { return cell.controller.state() == kReady; }, 1s));
}

TEST(Controller, a_driver_that_takes_nothing_is_asked_why) {
  ControlCell cell(kWholeMoves);
  cell.make_ready();
  cell.driver.deaf = true;
  cell.driver.refusal = Error{ErrorCode::kNotHomed, 1};
  const std::uint32_t id = cell.give(Begin{&cell.whole_move_to(cell.by(0.1))});
  cell.run(1s);
  EXPECT_FALSE(cell.end_of(id));
  ASSERT_TRUE(cell.run_until([&] { return cell.end_of(id).has_value(); }, 3s));
  EXPECT_EQ(cell.end_of(id)->error.code, ErrorCode::kNotHomed);
}

TEST(Controller, a_machine_that_is_not_known_takes_a_slow_first_move_only) {
  ControlCell cell(kWholeMoves);
  cell.driver.lose(3);
  cell.make_ready();
  EXPECT_FALSE(cell.controller.reference());
  JointVector home;
  for (const Joint& joint : cell.robot.joints) home.push_back(joint.home);
  JointMove move{.q = home, .qd = {}, .duration = 3s};
  move.qd.resize(home.size());
  PieceMotion motion(home, {move}, cell.robot);
  const std::uint32_t refused = cell.give(Begin{&motion});
  EXPECT_EQ(cell.end_of(refused)->error, (Error{ErrorCode::kPositionUnknown, 3}));
  const std::uint32_t id = cell.give(Begin{&motion, true});
  EXPECT_EQ(cell.controller.state(), kRecovering);
  ASSERT_TRUE(cell.run_until([&] { return cell.end_of(id).has_value(); }));
  EXPECT_EQ(cell.controller.state(), kReady);
  EXPECT_EQ(*cell.controller.reference(), home);
}

TEST(Controller, what_somebody_declares_is_where_the_next_motion_begins) {
  ControlCell cell(kStreaming);
  cell.make_ready();
  Declare where;
  for (const Joint& joint : cell.robot.joints) {
    const double q = joint.home + 0.01;
    where.positions.push_back({PositionQuality::kCommanded, q, q, q});
  }
  where.moved = true;
  const std::uint32_t id = cell.give(where);
  EXPECT_EQ(cell.end_of(id)->kind, Kind::kDone);
  EXPECT_EQ((*cell.controller.reference())[0], cell.robot.joints[0].home + 0.01);
  where.positions[1].q = where.positions[1].lower = where.positions[1].upper = 99;
  const std::uint32_t wrong = cell.give(where);
  EXPECT_EQ(cell.end_of(wrong)->error.code, ErrorCode::kJointLimit);
}

TEST(Controller, homing_and_tools_end_as_their_driver_says) {
  ControlCell cell(kStreaming);
  cell.make_ready();
  const std::uint32_t tool = cell.give(UseTool{JawsTo{0.01}});
  EXPECT_EQ(cell.controller.state(), kReady);
  const std::uint32_t busy = cell.give(UseTool{JawsTo{0.02}});
  EXPECT_EQ(cell.end_of(busy)->error.code, ErrorCode::kBusy);
  EXPECT_EQ(cell.controller.tool(), ToolState{}) << "on their way";
  ASSERT_TRUE(cell.run_until([&] { return cell.end_of(tool).has_value(); }, 1s));
  EXPECT_EQ(cell.end_of(tool)->kind, Kind::kDone);
  EXPECT_EQ(cell.controller.tool(), (ToolState{0.01, {}}));
  const std::uint32_t home = cell.give(Home{});
  EXPECT_EQ(cell.controller.state(), kRecovering);
  ASSERT_TRUE(cell.run_until([&] { return cell.end_of(home).has_value(); }, 5s));
  EXPECT_EQ(cell.end_of(home)->kind, Kind::kDone);
  EXPECT_EQ(cell.controller.state(), kReady);
  const std::uint32_t stopped = cell.give(Home{});
  cell.run(200ms);
  cell.give(Stop{});
  ASSERT_TRUE(cell.run_until([&] { return cell.controller.state() == kReady; }, 1s));
  EXPECT_EQ(cell.end_of(stopped)->kind, Kind::kStopped);
}

// The journal.

TEST(Controller, nothing_is_handed_over_before_its_intent_is_safe) {
  ControlCell cell(kStreaming, true);
  cell.sync = 200ms;
  cell.make_ready();
  cell.run(300ms);
  const std::uint32_t id = cell.give(Begin{&cell.path_to(cell.by(0.02))});
  cell.run(80ms);
  EXPECT_TRUE(cell.driver.pieces.empty());
  ASSERT_EQ(cell.records.back().kind, JournalKind::kIntent);
  cell.sync = 15ms;
  ASSERT_TRUE(cell.run_until([&] { return cell.end_of(id).has_value(); }));
  EXPECT_FALSE(cell.driver.pieces.empty());
  cell.run(100ms);
  EXPECT_EQ(cell.records.back().kind, JournalKind::kRest);
  EXPECT_EQ(cell.records.back().positions[0].q, (*cell.controller.reference())[0]);
}

TEST(Controller, the_truth_is_in_every_record_that_a_crash_may_leave) {
  ControlCell cell(kStreaming, true);
  cell.make_ready();
  cell.run(300ms);
  const std::uint32_t id = cell.give(Begin{&cell.path_to(cell.by(-0.6))});
  std::size_t looked = 0;
  while (!cell.end_of(id)) {
    cell.run(10ms);
    for (const JournalRecord& record : cell.records) {
      if (record.sequence < cell.durable) continue;
      for (std::size_t j = 0; j < 5; ++j) {
        const JointPosition& said = record.positions[j];
        const double q = cell.driver.positions()[j].q;
        ASSERT_LE(said.lower, q + 1e-12);
        ASSERT_GE(said.upper, q - 1e-12);
        ++looked;
      }
    }
  }
  EXPECT_GT(looked, 500U);
  EXPECT_EQ(cell.end_of(id)->kind, Kind::kDone);
}

TEST(Controller, a_disk_that_fails_holds_within_100_ms_and_nothing_new_moves) {
  ControlCell cell(kStreaming, true);
  cell.make_ready();
  cell.run(300ms);
  const std::uint32_t id = cell.give(Begin{&cell.path_to(cell.by(1.2))});
  cell.run(300ms);
  cell.disk_failed = true;
  const Instant failed = cell.now;
  ASSERT_TRUE(cell.run_until([&] { return cell.controller.state() == kStopping; }, 1s));
  EXPECT_LE(cell.now - failed, 20ms);
  ASSERT_TRUE(cell.run_until([&] { return cell.controller.state() == kFault; }, 5s));
  EXPECT_EQ(cell.end_of(id)->cause, StopCause::kNotRecorded);
  const std::uint32_t ack = cell.give(Acknowledge{});
  EXPECT_EQ(cell.end_of(ack)->error.code, ErrorCode::kNotRecorded);
}

TEST(Controller, a_look_at_a_motions_end_waits_for_its_record_however_slow_and_stops_nothing) {
  ControlCell cell(kStreaming, true);
  cell.make_ready();
  cell.run(300ms);
  cell.driver.looks_at_ends = true;
  const std::uint32_t id = cell.give(Begin{&cell.path_to(cell.by(0.3))});
  const auto sent_whole = [&] {
    return !cell.driver.pieces.empty() &&
           std::ranges::all_of(cell.driver.pieces.back().qd, [](double qd) { return qd == 0; });
  };
  ASSERT_TRUE(cell.run_until(sent_whole));
  cell.sync = 400ms;
  cell.run(300ms);
  EXPECT_TRUE(cell.driver.looking) << "nothing says yet that it is looked";
  EXPECT_FALSE(cell.end_of(id));
  EXPECT_EQ(cell.records.back().kind, JournalKind::kLook);
  EXPECT_EQ(cell.controller.last_stop(), std::nullopt);
  ASSERT_TRUE(cell.run_until([&] { return cell.end_of(id).has_value(); }, 1s));
  EXPECT_EQ(cell.end_of(id)->kind, Kind::kDone);
  cell.run(50ms);
  EXPECT_EQ(cell.records.back().kind, JournalKind::kRest);
  EXPECT_FALSE(cell.driver.looks_allowed);
}

TEST(Controller, a_disk_that_is_slow_holds_and_the_motion_can_go_on) {
  ControlCell cell(kStreaming, true);
  cell.make_ready();
  cell.run(300ms);
  const std::uint32_t id = cell.give(Begin{&cell.path_to(cell.by(1.2))});
  cell.run(200ms);
  cell.sync = 3s;
  ASSERT_TRUE(cell.run_until([&] { return cell.controller.state() == kHeld; }, 5s));
  EXPECT_EQ(cell.controller.last_stop(), StopCause::kRecordLate);
  cell.sync = 15ms;
  cell.run(4s);
  cell.give(Resume{});
  ASSERT_TRUE(cell.run_until([&] { return cell.end_of(id).has_value(); }));
  EXPECT_EQ(cell.end_of(id)->kind, Kind::kDone);
}

TEST(Controller, homing_gives_the_position_up_on_disk_before_it_begins) {
  ControlCell cell(kStreaming, true);
  cell.make_ready();
  cell.run(300ms);
  cell.give(Home{});
  EXPECT_EQ(cell.records.back().kind, JournalKind::kLost);
  EXPECT_NE(cell.driver.state(), DriverState::kMoving);
  cell.run(40ms);
  EXPECT_EQ(cell.driver.state(), DriverState::kMoving);
  cell.run(3s);
  EXPECT_EQ(cell.controller.state(), kReady);
  EXPECT_EQ(cell.records.back().kind, JournalKind::kRest);
  EXPECT_GE(cell.records.back().positions[0].quality, PositionQuality::kCommanded);
}

TEST(Controller, records_say_that_a_stop_of_its_own_is_latched_and_the_next_run_is_told) {
  ControlCell cell(kStreaming, true);
  cell.make_ready();
  cell.driver.held = true;
  cell.run(200ms);
  ASSERT_FALSE(cell.records.empty());
  EXPECT_EQ(cell.records.back().cause, JournalCause::kHeld);
  cell.driver.held = false;
  cell.run(200ms);
  EXPECT_EQ(cell.records.back().cause, JournalCause::kNone);
  ControlCell next(kStreaming, true,
                   {.positions = {},
                    .journal_end = {},
                    .memory = {.ended_in_motion = false, .held_by_stop = true, .counted = 5}});
  next.make_ready();
  next.cycle();
  EXPECT_TRUE(next.driver.remembered.held_by_stop);
  EXPECT_EQ(next.driver.remembered.counted, 5);
}

TEST(Controller, an_end_in_order_is_the_last_record) {
  ControlCell cell(kStreaming, true);
  cell.make_ready();
  cell.run(300ms);
  cell.closing = true;
  cell.run(200ms);
  EXPECT_EQ(cell.records.back().kind, JournalKind::kClosed);
  EXPECT_GE(cell.records.back().positions[0].quality, PositionQuality::kCommanded);
}

TEST(Controller, allocates_nothing) {
  ControlCell cell(kStreaming, true);
  cell.make_ready();
  cell.run(300ms);
  MotionSource& motion = cell.path_to(cell.by(0.8));
  JogAt jog;
  jog.velocity.velocity = {0.2, 0, 0, 0, 0};
  std::uint64_t allocated = 0;
  std::uint32_t id = 1000;
  const auto step = [&](std::initializer_list<Command> commands) {
    cell.now += 10ms;
    cell.driver.poll(cell.now);
    const Inputs inputs{.commands = {commands.begin(), commands.size()},
                        .port_open = true,
                        .durable_sequence = ~0ULL,
                        .journal_failed = false,
                        .closing = false,
                        .wall_ns = 0};
    // The pretended driver's own are not the controller's.
    cell.driver.pieces.reserve(4000);
    const sinew::test::AllocationCounter counter;
    cell.controller.step(inputs, cell.now);
    allocated += counter.count();
  };
  step({{++id, cell.lease, Begin{&motion}}});
  for (int k = 0; k < 40; ++k) step({{++id, cell.lease, RenewLease{}}});
  step({{++id, cell.lease, SetFeed{0.5}}});
  step({{++id, cell.lease, Hold{}}});
  for (int k = 0; k < 200; ++k) step({{++id, cell.lease, RenewLease{}}});
  EXPECT_EQ(cell.controller.state(), kHeld);
  step({{++id, cell.lease, Resume{}}, {++id, cell.lease, SetFeed{1.5}}});
  for (int k = 0; k < 800; ++k) step({{++id, cell.lease, RenewLease{}}});
  EXPECT_EQ(cell.controller.state(), kReady);
  for (int k = 0; k < 50; ++k) step({{++id, cell.lease, JogAt{jog}}});
  EXPECT_EQ(allocated, 0U);
}

/// What may never be, after each cycle of random commands and misfortunes.
void look(const ControlCell& cell, std::size_t pieces_before, MachineState before) {
  const MachineState state = cell.controller.state();
  const bool may = may_move(before) || may_move(state);
  ASSERT_TRUE(may || cell.driver.pieces.size() == pieces_before) << name(before);
  ASSERT_TRUE(state != kFault || cell.controller.latched());
  ASSERT_TRUE((state != kMoving && state != kRecovering) || cell.controller.task() != 0);
}

/// Left alone and asked nicely, it takes commands again.
void come_back(ControlCell& cell) {
  cell.port_open = true;
  cell.renews = false;
  cell.run(3s);
  cell.give(TakeLease{.take_over = true});
  cell.lease = *cell.controller.lease_holder(cell.now);
  cell.renews = true;
  cell.run(6s);
  if (cell.controller.state() == kFault) cell.give(Acknowledge{});
  if (cell.controller.state() == kOff) cell.give(Enable{});
  cell.give(Stop{});
  ASSERT_TRUE(cell.run_until([&] { return cell.controller.state() == kReady; }, 10s))
      << name(cell.controller.state());
}

TEST(Controller, random_commands_and_misfortunes_keep_the_rules) {
  std::set<MachineState> seen;
  sinew::test::for_random_cases(60, [&](sinew::test::Random& random) {
    ControlCell cell(random.chance(0.5) ? kStreaming : kWholeMoves, random.chance(0.5));
    cell.make_ready();
    cell.run(300ms);
    for (int k = 0; k < 1500 && !::testing::Test::HasFatalFailure(); ++k) {
      const MachineState before = cell.controller.state();
      const std::size_t pieces = cell.driver.pieces.size();
      seen.insert(before);
      const auto dice = random.integer(0, 400);
      cell.renews = !random.chance(0.002) && (cell.renews || random.chance(0.1));
      const bool idle = before == kReady && cell.controller.task() == 0;
      if (idle && dice < 60 && cell.controller.reference()) {
        const JointVector q = cell.by(random.uniform(-0.3, 0.3));
        bool inside = true;
        for (std::size_t j = 0; j < q.size(); ++j) {
          inside &= within_limits(cell.robot.joints[j], q[j]);
        }
        const bool streams = cell.robot.device.capability.motion == MotionKind::kStream;
        if (inside) cell.give(Begin{streams ? &cell.path_to(q) : &cell.whole_move_to(q)});
      } else if (dice < 10) {
        cell.give(Stop{});
      } else if (dice < 20) {
        cell.give(Hold{});
      } else if (dice < 40) {
        cell.give(Resume{});
      } else if (dice < 45) {
        cell.give(SetFeed{random.uniform(0, 1.2)});
      } else if (dice < 50) {
        cell.give(Acknowledge{});
      } else if (dice < 60) {
        cell.give(Enable{});
      } else if (dice < 62) {
        cell.give(Disable{});
      } else if (dice < 80) {
        JogAt jog;
        jog.velocity.velocity = {random.uniform(-0.3, 0.3), 0, 0, 0, 0};
        cell.give(jog);
      } else if (dice < 82) {
        cell.give(Home{});
      } else if (dice < 84) {
        cell.driver.fail({ErrorCode::kStalled, 1});
      } else if (dice < 86) {
        cell.driver.doubt(cell.now);
      } else if (dice < 90) {
        cell.port_open = !cell.port_open;
      } else if (dice < 92) {
        cell.now += std::chrono::milliseconds(random.integer(10, 900));
      } else if (dice < 110) {
        cell.port_open = true;
        cell.give(TakeLease{.take_over = random.chance(0.5)});
        if (const auto holder = cell.controller.lease_holder(cell.now)) cell.lease = *holder;
      }
      cell.cycle();
      look(cell, pieces, before);
    }
    come_back(cell);
  });
  EXPECT_EQ(seen.size(), kMachineStates);
}

}  // namespace
}  // namespace sinew::control::test
