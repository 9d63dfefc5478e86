#include <gtest/gtest.h>

#include <limits>

#include "sinew/control/controller_test_cell.h"
#include "sinew/core/error_code.h"
#include "sinew/core/units.h"
#include "sinew/model/error_sentence.h"

/// The way back of a machine that does not know where it is: one joint a little at a time, then
/// somebody says where it stands.
namespace sinew::control::test {
namespace {

using Kind = ControlEvent::Kind;
using enum MachineState;

constexpr const char* kLostArm = "bigrobotarm";

ControllerStart nothing_known() {
  return {};
}

Declare standing(const RobotModel& robot, double beside = 0) {
  Declare where;
  for (const Joint& joint : robot.joints) {
    const double q = joint.home + beside;
    where.positions.push_back({PositionQuality::kCommanded, q, q, q});
  }
  return where;
}

TEST(Recovery, a_lost_joint_goes_a_little_way_slowly_and_stays_lost) {
  ControlCell cell(kLostArm, true, nothing_known());
  for (std::size_t j = 0; j < 5; ++j) cell.driver.lose(j);
  cell.make_ready();
  cell.run(300ms);
  const Instant began = cell.now;
  const std::uint32_t id = cell.give(Nudge{2, from_deg(1)});
  EXPECT_EQ(cell.controller.state(), kRecovering);
  ASSERT_TRUE(cell.run_until([&] { return cell.end_of(id).has_value(); }, 5s));
  EXPECT_EQ(cell.end_of(id)->kind, Kind::kDone);
  EXPECT_EQ(cell.controller.state(), kReady);
  ASSERT_EQ(cell.driver.nudges.size(), 1U);
  EXPECT_EQ(cell.driver.nudges[0], from_deg(1));
  // A tenth of 0.5 rad/s.
  EXPECT_GE(to_seconds(cell.now - began), from_deg(1) / 0.05);
  EXPECT_EQ(cell.controller.positions()[2].quality, PositionQuality::kLost);
  EXPECT_FALSE(cell.controller.reference());
}

TEST(Recovery, nothing_moves_before_its_intent_is_on_disk) {
  ControlCell cell(kLostArm, true);
  cell.driver.set(1, {PositionQuality::kUncertain, 0.1, 0.05, 0.15});
  cell.sync = 200ms;
  cell.make_ready();
  cell.run(500ms);
  cell.give(Nudge{1, from_deg(-1)});
  cell.run(80ms);
  EXPECT_TRUE(cell.driver.nudges.empty());
  ASSERT_EQ(cell.records.back().kind, JournalKind::kIntent);
  // The whole way and all that was not certain before.
  EXPECT_LE(cell.records.back().positions[1].lower, 0.05 - from_deg(1));
  EXPECT_GE(cell.records.back().positions[1].upper, 0.15);
  cell.run(2s);
  EXPECT_EQ(cell.driver.nudges.size(), 1U);
  EXPECT_EQ(cell.records.back().kind, JournalKind::kRest);
  EXPECT_EQ(cell.records.back().positions[1].quality, PositionQuality::kUncertain);
  EXPECT_DOUBLE_EQ(cell.records.back().positions[1].upper, 0.15 - from_deg(1));
}

TEST(Recovery, anybody_stops_it_and_a_lost_lease_does_too) {
  ControlCell cell(kLostArm);
  cell.driver.lose(0);
  cell.make_ready();
  const std::uint32_t id = cell.give(Nudge{0, from_deg(2)});
  cell.run(100ms);
  cell.cycle({Command{900, LeaseToken{.client = 99}, Stop{}}});
  ASSERT_TRUE(cell.run_until([&] { return cell.controller.state() == kReady; }, 1s));
  EXPECT_EQ(cell.end_of(id)->kind, Kind::kStopped);
  EXPECT_EQ(cell.driver.stops, 1);
  cell.renews = false;
  cell.run(600ms);
  const std::uint32_t again = cell.give(Nudge{0, from_deg(2)});
  ASSERT_TRUE(cell.run_until([&] { return cell.end_of(again).has_value(); }, 3s));
  EXPECT_EQ(cell.end_of(again)->cause, StopCause::kLeaseEnded);
  EXPECT_EQ(cell.driver.stops, 2);
}

TEST(Recovery, a_search_that_the_lost_lease_ended_is_stopped_and_not_done) {
  ControlCell cell(kLostArm);
  cell.make_ready();
  const std::uint32_t id = cell.give(Home{});
  cell.renews = false;
  ASSERT_TRUE(cell.run_until([&] { return cell.end_of(id).has_value(); }, 3s));
  EXPECT_EQ(cell.end_of(id)->kind, Kind::kStopped);
  EXPECT_EQ(cell.end_of(id)->cause, StopCause::kLeaseEnded);
  ASSERT_TRUE(cell.run_until([&] { return cell.controller.state() == kReady; }, 1s));
}

TEST(Recovery, a_resumed_search_leaves_out_what_was_found_and_is_known_still) {
  ControlCell cell(kLostArm);
  cell.make_ready();
  const auto search = [&](bool resumes, std::initializer_list<std::size_t> joints) {
    cell.give(Home{.resumes = resumes});
    for (const std::size_t joint : joints) {
      cell.driver.searching = joint;
      cell.run(20ms);
    }
    cell.give(Stop{});
    cell.driver.searching.reset();
    EXPECT_TRUE(cell.run_until([&] { return cell.controller.state() == kReady; }, 1s));
    return cell.driver.homed.back();
  };
  const auto without = [](unsigned joints) { return static_cast<std::uint8_t>(0xFFU & ~joints); };
  EXPECT_EQ(search(false, {3, 1, 0}), kAllJoints);
  EXPECT_EQ(search(true, {0, 2}), without(0b01010)) << "joint 0 was stopped on its way";
  cell.driver.lose(1);
  EXPECT_EQ(search(true, {1}), without(0b01001));
  EXPECT_EQ(search(false, {3}), kAllJoints) << "a search that somebody asks for anew";
  EXPECT_EQ(search(true, {3, 1, 0, 2, 4}), kAllJoints);
  EXPECT_EQ(search(true, {4, 4}), without(0b01101)) << "joint 1 is lost still";
}

TEST(Recovery, a_service_of_the_device_needs_the_lease_and_a_machine_at_rest) {
  ControlCell cell(kLostArm);
  cell.make_ready();
  const std::uint32_t foreign = ++cell.last_id;
  cell.cycle({Command{foreign, LeaseToken{.client = 99, .epoch = 1}, Service{}}});
  EXPECT_EQ(cell.end_of(foreign)->kind, Kind::kRefused);
  const std::uint32_t nudge = cell.give(Nudge{0, from_deg(2)});
  const std::uint32_t meanwhile = cell.give(Service{});
  EXPECT_EQ(cell.end_of(meanwhile)->error.code, ErrorCode::kWrongState);
  ASSERT_TRUE(cell.run_until([&] { return cell.end_of(nudge).has_value(); }, 5s));
  const std::uint32_t id = cell.give(Service{DeviceService::kShutDown});
  ASSERT_TRUE(cell.run_until([&] { return cell.end_of(id).has_value(); }, 1s));
  EXPECT_EQ(cell.end_of(id)->kind, Kind::kDone);
  EXPECT_EQ(cell.driver.services, std::vector{DeviceService::kShutDown});
}

TEST(Recovery, nothing_moves_an_arm_that_was_freed_and_the_next_motion_begins_where_it_was_led) {
  ControlCell cell(kLostArm);
  cell.make_ready();
  const auto done = [&](const CommandWhat& what) {
    const std::uint32_t id = cell.give(what);
    EXPECT_TRUE(cell.run_until([&] { return cell.end_of(id).has_value(); }, 1s));
    return *cell.end_of(id);
  };
  EXPECT_EQ(done(Service{DeviceService::kFree}).kind, Kind::kDone);
  EXPECT_TRUE(cell.controller.free_drive());
  const double led = cell.robot.joints[0].home + 0.3;
  cell.driver.set(0, {PositionQuality::kMeasured, led, led, led});
  cell.run(50ms);
  EXPECT_EQ(cell.controller.reference().value()[0], led);
  MotionSource& motion = cell.whole_move_to(cell.by(0.1));
  const CommandWhat moves[] = {Begin{.motion = &motion}, Home{}, Nudge{0, 0.01}};
  for (const CommandWhat& what : moves) {
    const ControlEvent end = done(what);
    EXPECT_EQ(end.kind, Kind::kRefused) << what.index();
    EXPECT_EQ(end.error.code, ErrorCode::kFreeDrive) << what.index();
  }
  EXPECT_TRUE(cell.driver.pieces.empty());
  EXPECT_EQ(cell.controller.state(), MachineState::kReady);
  const double held = led + 0.01;
  cell.driver.set(0, {PositionQuality::kMeasured, held, held, held});
  EXPECT_EQ(done(Service{DeviceService::kHold}).kind, Kind::kDone);
  EXPECT_FALSE(cell.controller.free_drive());
  EXPECT_EQ(cell.controller.reference().value()[0], held);
  EXPECT_EQ(done(Begin{.motion = &cell.whole_move_to(cell.by(0.1), 500ms)}).kind, Kind::kDone);
}

TEST(Recovery, what_is_no_small_step_of_one_joint_is_refused_and_nothing_moves) {
  ControlCell cell(kLostArm);
  cell.driver.lose(0);
  cell.make_ready();
  for (const double way : {0.0, from_deg(2.1), from_deg(-180), std::nan(""),
                           std::numeric_limits<double>::infinity()}) {
    const std::uint32_t id = cell.give(Nudge{0, way});
    ASSERT_TRUE(cell.end_of(id)) << way;
    EXPECT_EQ(cell.end_of(id)->error.code, ErrorCode::kNudgeRange) << way;
  }
  const std::uint32_t nobody = cell.give(Nudge{5, 0.01});
  EXPECT_EQ(cell.end_of(nobody)->error.code, ErrorCode::kMoveInput);
  cell.driver.set(1, {PositionQuality::kUncertain, cell.robot.joints[1].upper - 0.001, 0, 2});
  const std::uint32_t beyond = cell.give(Nudge{1, from_deg(1)});
  EXPECT_EQ(cell.end_of(beyond)->error.code, ErrorCode::kJointLimit);
  const std::uint32_t foreign = ++cell.last_id;
  cell.cycle({Command{foreign, LeaseToken{.client = 99, .epoch = 1}, Nudge{0, 0.01}}});
  EXPECT_EQ(cell.end_of(foreign)->kind, Kind::kRefused);
  EXPECT_TRUE(cell.driver.nudges.empty());
  const std::uint32_t fine = cell.give(Nudge{0, from_deg(1)});
  const std::uint32_t second = cell.give(Nudge{1, from_deg(-1)});
  EXPECT_EQ(cell.end_of(second)->error.code, ErrorCode::kWrongState);
  ASSERT_TRUE(cell.run_until([&] { return cell.end_of(fine).has_value(); }, 5s));
  EXPECT_EQ(cell.driver.nudges.size(), 1U);
}

TEST(Recovery, a_step_that_ends_where_a_probe_touches_is_slow_and_the_machine_goes_on_from_there) {
  ControlCell cell(kLostArm);
  cell.make_ready();
  cell.driver.probe_fault = Error{ErrorCode::kProbeClosed};
  const std::uint32_t closed = cell.give(Nudge{0, from_deg(1), true});
  ASSERT_TRUE(cell.end_of(closed));
  EXPECT_EQ(cell.end_of(closed)->kind, Kind::kRefused);
  EXPECT_EQ(cell.end_of(closed)->error.code, ErrorCode::kProbeClosed);
  EXPECT_EQ(cell.controller.state(), MachineState::kReady);
  EXPECT_TRUE(cell.driver.nudges.empty());
  cell.driver.probe_fault.reset();
  const double before = (*cell.controller.reference())[0];
  const std::uint32_t id = cell.give(Nudge{0, from_deg(1), true});
  ASSERT_TRUE(cell.run_until([&] { return cell.end_of(id).has_value(); }, 30s));
  EXPECT_EQ(cell.end_of(id)->kind, Kind::kDone);
  ASSERT_EQ(cell.driver.probe_durations.size(), 1U);
  const double slow = from_deg(1) / (Controller::kProbeShare * cell.robot.joints[0].velocity_max);
  EXPECT_NEAR(to_seconds(cell.driver.probe_durations[0]), slow, 1e-6);
  EXPECT_DOUBLE_EQ((*cell.controller.reference())[0], before + from_deg(0.5));
}

TEST(Recovery, a_device_that_moves_to_places_only_takes_no_small_steps) {
  ControlCell cell("learm");
  cell.driver.lose(0);
  cell.make_ready();
  const std::uint32_t id = cell.give(Nudge{0, 0.001});
  EXPECT_EQ(cell.end_of(id)->error.code, ErrorCode::kTaskNotSupported);
}

TEST(Recovery, a_known_machine_goes_on_from_where_a_small_step_led) {
  ControlCell cell(kLostArm);
  cell.make_ready();
  const double before = (*cell.controller.reference())[0];
  const std::uint32_t id = cell.give(Nudge{0, from_deg(1)});
  ASSERT_TRUE(cell.run_until([&] { return cell.end_of(id).has_value(); }, 5s));
  ASSERT_TRUE(cell.controller.reference());
  EXPECT_DOUBLE_EQ((*cell.controller.reference())[0], before + from_deg(1));
  const std::uint32_t move = cell.give(Begin{&cell.whole_move_to(cell.by(0.1))});
  ASSERT_TRUE(cell.run_until([&] { return cell.end_of(move).has_value(); }));
  EXPECT_EQ(cell.end_of(move)->kind, Kind::kDone);
}

TEST(Recovery, what_is_declared_after_it_is_recorded_and_planned_from) {
  ControlCell cell(kLostArm, true);
  for (std::size_t j = 0; j < 5; ++j) cell.driver.lose(j);
  cell.make_ready();
  cell.run(300ms);
  const std::uint32_t id = cell.give(standing(cell.robot));
  EXPECT_EQ(cell.end_of(id)->kind, Kind::kDone);
  EXPECT_EQ(cell.records.back().kind, JournalKind::kDeclared);
  EXPECT_TRUE(cell.controller.reference());
}

TEST(Recovery, a_declaration_against_what_is_measured_or_held_in_an_interval_needs_a_hand) {
  ControlCell cell(kLostArm, true);
  cell.make_ready();
  cell.run(300ms);
  const double home = cell.robot.joints[3].home;
  for (const PositionQuality known : {PositionQuality::kMeasured, PositionQuality::kUncertain}) {
    cell.driver.set(3, {known, home + 0.2, home + 0.19, home + 0.21});
    const std::uint32_t refused = cell.give(standing(cell.robot));
    EXPECT_EQ(cell.end_of(refused)->error.code, ErrorCode::kDeclaredElsewhere);
    EXPECT_EQ(cell.end_of(refused)->error.index, 3);
    EXPECT_EQ(cell.end_of(refused)->error.limit, home + 0.19);
    EXPECT_NE(cell.records.back().kind, JournalKind::kDeclared);
    EXPECT_EQ(cell.driver.positions()[3].q, home + 0.2);
    Declare where = standing(cell.robot);
    where.positions[3] = standing(cell.robot, 0.2).positions[3];
    const std::uint32_t inside = cell.give(where);
    EXPECT_EQ(cell.end_of(inside)->kind, Kind::kDone);
    cell.driver.set(3, {known, home + 0.2, home + 0.19, home + 0.21});
    Declare moved = standing(cell.robot);
    moved.moved = true;
    const std::uint32_t told = cell.give(moved);
    EXPECT_EQ(cell.end_of(told)->kind, Kind::kDone);
    EXPECT_EQ(cell.driver.positions()[3].q, home);
  }
}

TEST(Recovery, a_declaration_against_what_the_device_was_told_needs_a_hand_beyond_its_resolution) {
  ControlCell cell(kLostArm, true);
  cell.make_ready();
  cell.run(300ms);
  const double home = cell.robot.joints[3].home;
  const double step = cell.robot.device.settings->resolution(3);
  cell.driver.set(3, {PositionQuality::kCommanded, home + 0.2, home + 0.2, home + 0.2});
  const std::uint32_t refused = cell.give(standing(cell.robot));
  EXPECT_EQ(cell.end_of(refused)->error.code, ErrorCode::kDeclaredElsewhere);
  EXPECT_EQ(cell.end_of(refused)->error.index, 3);
  EXPECT_EQ(cell.driver.positions()[3].q, home + 0.2);
  const double near = home + 0.9 * step;
  cell.driver.set(3, {PositionQuality::kCommanded, near, near, near});
  const std::uint32_t same = cell.give(standing(cell.robot));
  EXPECT_EQ(cell.end_of(same)->kind, Kind::kDone);
  const double beyond = home + 1.1 * step;
  cell.driver.set(3, {PositionQuality::kCommanded, beyond, beyond, beyond});
  const std::uint32_t off = cell.give(standing(cell.robot));
  EXPECT_EQ(cell.end_of(off)->error.code, ErrorCode::kDeclaredElsewhere);
  Declare moved = standing(cell.robot);
  moved.moved = true;
  const std::uint32_t told = cell.give(moved);
  EXPECT_EQ(cell.end_of(told)->kind, Kind::kDone);
  EXPECT_EQ(cell.driver.positions()[3].q, home);
}

TEST(Recovery, a_declaration_against_the_devices_count_is_refused_with_both_numbers) {
  ControlCell cell(kLostArm, true);
  cell.make_ready();
  cell.run(300ms);
  const double home = cell.robot.joints[2].home;
  cell.driver.lose(2);
  cell.driver.counts[2] = JointInterval{home - 1.03, home - 1.01};
  const std::uint32_t refused = cell.give(standing(cell.robot));
  const Error error = cell.end_of(refused)->error;
  EXPECT_EQ(error.code, ErrorCode::kCountedElsewhere);
  EXPECT_EQ(error.index, 2);
  EXPECT_EQ(error.measured, home);
  EXPECT_NEAR(error.limit, home - 1.02, 1e-12);
  EXPECT_FALSE(cell.controller.reference());
  EXPECT_NE(cell.records.back().kind, JournalKind::kDeclared);
  // Said where it counts it, or with a hand that moved it, it counts.
  Declare where = standing(cell.robot);
  where.positions[2] = {PositionQuality::kCommanded, home - 1.02, home - 1.02, home - 1.02};
  const std::uint32_t there = cell.give(where);
  EXPECT_EQ(cell.end_of(there)->kind, Kind::kDone);
  cell.driver.lose(2);
  Declare moved = standing(cell.robot);
  moved.moved = true;
  const std::uint32_t told = cell.give(moved);
  EXPECT_EQ(cell.end_of(told)->kind, Kind::kDone);
}

TEST(Recovery, a_statement_that_the_device_does_not_keep_is_refused_and_not_recorded) {
  ControlCell cell(kLostArm, true);
  for (std::size_t j = 0; j < 5; ++j) cell.driver.lose(j);
  cell.driver.declarable = false;
  cell.make_ready();
  cell.run(300ms);
  const std::uint32_t id = cell.give(standing(cell.robot));
  EXPECT_EQ(cell.end_of(id)->kind, Kind::kRefused);
  EXPECT_EQ(cell.end_of(id)->error, (Error{ErrorCode::kNotHomed, 0}));
  const std::string told = sentence_of(cell.end_of(id)->error, cell.robot);
  EXPECT_NE(told.find("sinew commission --procedure home"), std::string::npos) << told;
  EXPECT_NE(cell.records.back().kind, JournalKind::kDeclared);
  // Also where a hand has moved it, and its own boards say where it is.
  for (std::size_t j = 0; j < 5; ++j) {
    const double q = cell.robot.joints[j].home + 0.2;
    cell.driver.set(j, {PositionQuality::kMeasured, q, q, q});
  }
  Declare moved = standing(cell.robot);
  moved.moved = true;
  const std::uint32_t again = cell.give(moved);
  EXPECT_EQ(cell.end_of(again)->error, (Error{ErrorCode::kNotHomed, 0}));
}

TEST(Recovery, a_place_a_little_beyond_a_limit_can_be_said) {
  ControlCell cell(kLostArm, true);
  for (std::size_t j = 0; j < 5; ++j) cell.driver.lose(j);
  cell.make_ready();
  cell.run(300ms);
  Declare where = standing(cell.robot);
  const auto said = [&](double beyond) {
    const double q = cell.robot.joints[1].upper + beyond;
    where.positions[1] = {PositionQuality::kCommanded, q, q, q};
    const std::uint32_t id = cell.give(where);
    return cell.end_of(id)->kind;
  };
  EXPECT_EQ(said(from_deg(11)), Kind::kRefused) << "no joint turns so far";
  EXPECT_EQ(said(from_deg(4)), Kind::kDone);
  EXPECT_TRUE(cell.controller.reference());
}

}  // namespace
}  // namespace sinew::control::test
