#include "sinew/devices/lsc/lsc_driver.h"

#include <gtest/gtest.h>

#include <cmath>
#include <iostream>
#include <limits>
#include <map>

#include "sinew/core/error_code.h"
#include "sinew/devices/lsc/lsc_test_cell.h"
#include "support/allocation_guard.h"
#include "support/property.h"

namespace sinew {
namespace {

using namespace test;
using Kind = DriverEvent::Kind;
using Quality = PositionQuality;
using Fault = LscLine::Fault;

constexpr LscPose kThere{-0.5, 0.6, 0.5, 0.3, 0.4};

TEST(LscDriver, open_stops_groups_waits_for_a_sign_of_life_and_tells_the_quality_honestly) {
  const std::map<LscProfile, std::pair<std::vector<std::uint8_t>, Quality>> expected{
      {LscProfile::kLsc6, {{7, 15, 21, 21, 21}, Quality::kLost}},
      {LscProfile::kBus, {{7, 15, 21, 21}, Quality::kMeasured}},
      // Just switched on it says 1500 everywhere, which is no position.
      {LscProfile::kEsp32, {{7, 1, 13, 13}, Quality::kLost}}};
  for (const LscProfile profile : kLscProfiles) {
    LscCell cell(profile);
    EXPECT_EQ(cell.driver.state(), DriverState::kClosed);
    cell.run_for(2s);  // a limp arm sinks until something holds it
    cell.driver.open(cell.now);
    cell.run_for(800ms);
    EXPECT_EQ(cell.driver.state(), DriverState::kReady);
    EXPECT_EQ(cell.events.size(), 1U);
    std::vector<std::uint8_t> commands;
    lsc::FrameDecoder decoder;
    for (const std::uint8_t byte : cell.to_board.history) {
      if (const auto frame = decoder.push(byte)) commands.push_back(frame->command);
    }
    EXPECT_EQ(commands, expected.at(profile).first);
    for (const JointPosition& joint : cell.driver.positions()) {
      EXPECT_EQ(joint.quality, expected.at(profile).second);
    }
  }
}

TEST(LscDriver, the_same_damage_in_two_answers_is_no_position_where_no_servo_can_stand_there) {
  LscCell clean(LscProfile::kBus);
  clean.run_for(2s);  // a limp arm sinks first
  clean.driver.open(clean.now);
  clean.run_for(600ms);
  LscCell damaged(LscProfile::kBus);
  const auto& heard = clean.to_host.history;
  int answers = 0;
  for (std::size_t i = 0; i + 7 < heard.size(); ++i) {
    if (heard[i] != 0x55 || heard[i + 1] != 0x55 || heard[i + 3] != 21) continue;
    damaged.to_host.hit(i + 7, LscLine::Fault::kFlip, 0x40);  // high byte of the first servo
    ++answers;
  }
  ASSERT_EQ(answers, 2);
  damaged.run_for(2s);
  damaged.driver.open(damaged.now);
  damaged.run_for(2s);
  EXPECT_EQ(damaged.driver.state(), DriverState::kReady);
  EXPECT_EQ(damaged.driver.health().unexpected, 2U);
  for (std::size_t i = 0; i < 5; ++i) {
    EXPECT_NEAR(damaged.driver.positions()[i].q, damaged.machine.truth().joints[i].q, 0.05);
  }
}

TEST(LscDriver, an_esp32_that_has_kept_its_power_tells_where_it_was_sent) {
  LscCell cell(LscProfile::kEsp32);
  cell.start(kLscHere);
  cell.driver.close(cell.now);
  cell.driver.open(cell.now);
  cell.run_for(1s);
  for (std::size_t i = 0; i < 5; ++i) {
    EXPECT_EQ(cell.driver.positions()[i].quality, Quality::kCommanded);
    EXPECT_NEAR(cell.driver.positions()[i].q, kLscHere[i], 1e-3);
  }
}

TEST(LscDriver, a_lost_arm_moves_slowly_or_not_at_all) {
  LscCell cell(LscProfile::kLsc6);
  cell.driver.open(cell.now);
  cell.run_for(800ms);
  const auto sent = cell.to_board.count();
  for (const Duration duration : {80ms, 100ms, 1999ms}) {
    const auto refused = cell.driver.move(cell.to(kLscHere, duration), cell.now);
    ASSERT_FALSE(refused);
    EXPECT_EQ(refused.error().code, ErrorCode::kPositionUnknown);
    EXPECT_EQ(refused.error().limit, 2);
  }
  EXPECT_EQ(refusal(cell.driver.move(cell.to(kLscHere, 31s), cell.now)), ErrorCode::kSegmentTime);
  EXPECT_EQ(cell.to_board.count(), sent);
  ASSERT_TRUE(cell.driver.move(cell.to(kLscHere, 2s), cell.now));
  cell.run_for(1900ms);
  EXPECT_EQ(cell.driver.positions()[1].quality, Quality::kLost);
  EXPECT_EQ(cell.driver.state(), DriverState::kMoving);
  cell.run_for(300ms);
  EXPECT_EQ(cell.count(Kind::kDone), 1U);
  EXPECT_EQ(cell.driver.positions()[1].quality, Quality::kCommanded);
  EXPECT_LT(cell.worst(kLscHere), kLscSag);
}

TEST(LscDriver, a_streamed_motion_follows_its_path_and_ends_each_command_once) {
  for (const LscProfile profile : kLscProfiles) {
    LscCell cell(profile);
    cell.start(kLscHere);
    const Instant begun = cell.now;
    double lag = 0;
    cell.stream(kThere, 1600ms, [&](int segment) {
      // What was planned two segments ago has been reached by the servo by now.
      if (segment > 2) lag = std::max(lag, cell.worst(cell.planned));
      return true;
    });
    EXPECT_LT(lag, 0.25) << "rad";
    EXPECT_EQ(cell.count(Kind::kDone), 20U);
    EXPECT_EQ(cell.ends(), cell.commands);
    EXPECT_LT(cell.worst(kThere), kLscSag);
    EXPECT_LT(cell.now - begun, 3s);
    const Quality quality = profile == LscProfile::kBus ? Quality::kMeasured : Quality::kCommanded;
    for (std::size_t i = 0; i < 5; ++i) {
      EXPECT_EQ(cell.driver.positions()[i].quality, quality);
      EXPECT_NEAR(cell.driver.positions()[i].q, kThere[i], kLscSag);
    }
  }
}

TEST(LscDriver, the_next_segment_arrives_when_the_last_one_ends) {
  LscCell cell(LscProfile::kLsc6);
  cell.start(kLscHere);
  // The board's interpolation never rests between two segments of an even motion.
  std::vector<double> steps;
  double before = cell.machine.board().commanded(6);
  const auto sample = [&] {
    const double units = cell.machine.board().commanded(6);
    steps.push_back(units - before);
    before = units;
  };
  double q = kLscHere[0];
  for (int k = 1; k <= 10; ++k) {
    while (!cell.driver.wants_move(cell.now)) {
      cell.run_for(5ms);
      sample();
    }
    q += 0.1;
    LscPose pose = kLscHere;
    pose[0] = q;
    ASSERT_TRUE(cell.driver.move(cell.to(pose, 80ms, k < 10 ? 1.25 : 0), cell.now));
  }
  // 0.1 rad in 80 ms are 0.796 units a ms, 4 in 5 ms.
  for (std::size_t i = 8; i + 1 < steps.size(); ++i) EXPECT_NEAR(steps[i], 3.98, 0.4) << i;
}

TEST(LscDriver, what_must_not_be_sent_is_refused_before_a_byte_leaves) {
  LscCell cell(LscProfile::kLsc6);
  cell.start(kLscHere);
  cell.run_for(950ms);
  const auto refused = [&](LscPose q, Duration duration, ErrorCode code, int joint) {
    const auto sent = cell.to_board.count();
    const auto result = cell.driver.move(cell.to(q, duration), cell.now);
    ASSERT_FALSE(result);
    EXPECT_EQ(result.error().code, code);
    EXPECT_EQ(result.error().index, joint);
    EXPECT_EQ(cell.to_board.count(), sent);
    EXPECT_EQ(cell.driver.state(), DriverState::kReady);
  };
  LscPose far = kLscHere;
  far[2] = 1.6;
  refused(far, 100ms, ErrorCode::kJointLimit, 2);
  far[2] = std::numeric_limits<double>::quiet_NaN();
  refused(far, 100ms, ErrorCode::kJointLimit, 2);
  refused(kLscHere, 101ms, ErrorCode::kSegmentTime, -1);
  refused(kLscHere, 5s, ErrorCode::kSegmentTime, -1);
  refused(kLscHere, 19ms, ErrorCode::kSegmentTime, -1);
  refused(kLscHere, 0ms, ErrorCode::kSegmentTime, -1);
  refused(kLscHere, -5s, ErrorCode::kSegmentTime, -1);
  LscPose fast = kLscHere;
  fast[4] = 0.5;  // 5 rad/s
  refused(fast, 100ms, ErrorCode::kSegmentTime, 4);
  EXPECT_EQ(refusal(cell.driver.tool(JawsTo{-0.001}, cell.now)), ErrorCode::kGripperRange);
  EXPECT_EQ(refusal(cell.driver.tool(JawsTo{0.061}, cell.now)), ErrorCode::kGripperRange);
  EXPECT_EQ(refusal(cell.driver.tool(Suction{}, cell.now)), ErrorCode::kToolNotFitted);
  EXPECT_EQ(refusal(cell.driver.home(cell.now)), ErrorCode::kTaskNotSupported);
  EXPECT_TRUE(cell.events.empty());
}

TEST(LscDriver, a_servo_whose_range_is_narrower_than_its_joint_refuses_by_pulse) {
  RobotModel model = learm(LscProfile::kLsc6);
  auto device = lsc_settings(LscProfile::kLsc6);
  device.servos[1].trim = 30;
  const LscUnits units(device, model.joints, std::nullopt);
  EXPECT_EQ(units.of_joint(1, 0).value(), 1530);
  EXPECT_EQ(units.of_joint(1, kPi / 2).error().code, ErrorCode::kPulseRange);
  EXPECT_EQ(units.of_joint(2, 0.1).value(), 1436);
  EXPECT_NEAR(units.q_of(2, 1436), 0.1, units.resolution(2) / 2);
  EXPECT_EQ(units.of_width(0.03).error().code, ErrorCode::kToolNotFitted);
}

TEST(LscDriver, jaws_go_to_their_width_and_stop_at_a_thing_between_them) {
  for (const LscProfile profile : kLscProfiles) {
    LscCell cell(profile);
    cell.start(kLscHere);
    ASSERT_TRUE(cell.driver.tool(JawsTo{0.05}, cell.now));
    cell.run_for(4s);
    EXPECT_EQ(cell.count(Kind::kDone), 1U);
    EXPECT_NEAR(cell.machine.truth().tool, 0.05, 2e-3);
    cell.machine.disturb({sim::Disturbance::Kind::kBlock, 5, 0.024});
    ASSERT_TRUE(cell.driver.tool(JawsTo{0.02}, cell.now));
    EXPECT_EQ(refusal(cell.driver.tool(JawsTo{0.02}, cell.now)), ErrorCode::kBusy);
    cell.run_for(2s);
    EXPECT_EQ(cell.count(Kind::kDone), 2U);
    EXPECT_NEAR(cell.machine.truth().tool, 0.024, 1e-4);
    EXPECT_LT(cell.worst(kLscHere), kLscSag) << "the arm stays where it was";
    const auto width = cell.driver.health().jaws_width;
    EXPECT_EQ(width.has_value(), profile == LscProfile::kBus) << "who can measure says so";
    if (width) {
      EXPECT_NEAR(*width, 0.024, 1e-3);
      ASSERT_TRUE(cell.driver.tool(JawsTo{0.05}, cell.now));
      EXPECT_FALSE(cell.driver.health().jaws_width) << "not while they move";
    }
  }
}

TEST(LscDriver, stop_in_a_stream_stands_within_72_ms_and_knows_where) {
  for (const LscProfile profile : kLscProfiles) {
    Duration slowest{};
    for (int at = 0; at < 16; ++at) {
      LscCell cell(profile);
      cell.start(kLscHere);
      cell.stream(kThere, 1600ms, [&](int k) { return k < 8; });
      LscPose onwards = cell.planned;
      for (double& q : onwards) q += 0.05;
      ASSERT_TRUE(cell.driver.move(cell.to(onwards, 80ms, 1), cell.now));
      ++cell.commands;
      cell.run_for(at * 5ms);
      cell.driver.stop(cell.now);
      const Instant asked = cell.now;
      Instant moved = asked;
      for (int i = 0; i < 200; ++i) {
        const double before = cell.machine.board().commanded(6);
        cell.run_for(1ms);
        if (cell.machine.board().commanded(6) != before) moved = cell.now;
      }
      slowest = std::max(slowest, moved - asked);
      cell.run_for(1s);
      EXPECT_EQ(cell.ends(), cell.commands) << "each command ends once";
      EXPECT_GE(cell.count(Kind::kStopped), 1U);
      EXPECT_EQ(cell.driver.state(), DriverState::kReady);
      for (std::size_t i = 0; i < 5; ++i) {
        EXPECT_NEAR(cell.driver.positions()[i].q, cell.machine.truth().joints[i].q, kLscSag);
      }
      const auto sent = cell.to_board.count();
      cell.run_for(300ms);
      EXPECT_LE(cell.to_board.count(), sent + 4 + 22) << "a question, and the place said again";
    }
    EXPECT_LE(slowest, 73ms);
    std::cout << "  slowest stop " << to_seconds(slowest) * 1e3 << " ms\n";
  }
}

TEST(LscDriver, stop_is_answered_in_every_state) {
  LscCell cell(LscProfile::kLsc6);
  const auto stopped = [&] {
    cell.events.clear();
    cell.driver.stop(cell.now);
    return cell.run_until(Kind::kStopped) && cell.ends() == 1;
  };
  EXPECT_TRUE(stopped()) << "closed";
  cell.driver.open(cell.now);
  EXPECT_TRUE(stopped()) << "quiet";
  cell.run_for(65ms);
  EXPECT_EQ(cell.driver.state(), DriverState::kOpening);
  EXPECT_TRUE(stopped()) << "asking";
  cell.run_for(500ms);
  EXPECT_TRUE(stopped()) << "ready";
  cell.start(kLscHere);
  ASSERT_TRUE(cell.driver.move(cell.to(kLscHere, 100ms), cell.now));
  cell.run_for(140ms);
  EXPECT_EQ(cell.driver.state(), DriverState::kMoving);
  EXPECT_TRUE(stopped()) << "confirming";
  ASSERT_TRUE(cell.driver.tool(JawsTo{0.05}, cell.now));
  cell.run_for(200ms);
  EXPECT_TRUE(stopped()) << "jaws";
  EXPECT_EQ(cell.driver.positions()[0].quality, Quality::kCommanded) << "only the jaws are lost";
  cell.machine.disturb({sim::Disturbance::Kind::kSupply, -1, 4.8});
  cell.run_for(3s);
  EXPECT_EQ(cell.driver.state(), DriverState::kFault);
  EXPECT_TRUE(stopped()) << "fault";
}

TEST(LscDriver, stop_of_a_first_move_slows_it_to_a_creep_and_leaves_the_arm_lost) {
  LscCell cell(LscProfile::kLsc6);
  cell.driver.open(cell.now);
  cell.run_for(800ms);
  ASSERT_TRUE(cell.driver.move(cell.to({1.5, 0.3, 0.2, 0.1, 0}, 2s), cell.now));
  cell.run_for(700ms);
  cell.driver.stop(cell.now);
  cell.run_for(200ms);
  EXPECT_EQ(cell.count(Kind::kStopped), 1U);
  EXPECT_EQ(cell.driver.positions()[0].quality, Quality::kLost);
  const double before = cell.machine.truth().joints[0].q;
  cell.run_for(1s);
  EXPECT_LT(std::abs(cell.machine.truth().joints[0].q - before), 3 * kPi / 180);
}

TEST(LscDriver, stop_of_a_first_move_on_a_board_that_can_be_asked_stands) {
  LscCell cell(LscProfile::kEsp32);
  cell.driver.open(cell.now);
  cell.run_for(800ms);
  ASSERT_TRUE(cell.driver.move(cell.to({1.5, 0.3, 0.2, 0.1, 0}, 2s), cell.now));
  cell.run_for(700ms);
  cell.driver.stop(cell.now);
  cell.run_for(400ms);
  EXPECT_EQ(cell.count(Kind::kStopped), 1U);
  EXPECT_EQ(cell.driver.positions()[0].quality, Quality::kLost);
  const double before = cell.machine.truth().joints[0].q;
  cell.run_for(1s);
  EXPECT_NEAR(cell.machine.truth().joints[0].q, before, 1e-3);
}

TEST(LscDriver, a_lost_end_of_a_motion_is_mended_by_its_two_repeats) {
  for (const LscProfile profile : kLscProfiles) {
    for (const Fault fault : {Fault::kDrop, Fault::kDouble, Fault::kFlip, Fault::kDelay}) {
      for (std::uint64_t byte = 0; byte < 22; ++byte) {
        LscCell cell(profile);
        cell.start(kLscHere);
        cell.stream(kThere, 1600ms, [&](int k) {
          if (k == 20) cell.to_board.hit(byte, fault, 4);
          return true;
        });
        EXPECT_LT(cell.worst(kThere), kLscSag) << byte;
        EXPECT_EQ(cell.ends(), cell.commands) << byte;
      }
    }
  }
}

TEST(LscDriver, silence_ends_commands_with_failure_and_an_answer_brings_it_back_lost) {
  for (const LscProfile profile : kLscProfiles) {
    LscCell cell(profile);
    cell.start(kLscHere);
    cell.to_board.cut = cell.to_host.cut = true;
    cell.stream(kThere, 8s);
    EXPECT_EQ(cell.failure(), ErrorCode::kDeviceSilent);
    EXPECT_EQ(cell.ends(), cell.commands);
    EXPECT_EQ(cell.driver.state(), DriverState::kOpening);
    EXPECT_EQ(cell.driver.positions()[0].quality, Quality::kLost);
    cell.to_board.cut = cell.to_host.cut = false;
    EXPECT_TRUE(cell.run_until(Kind::kReady));
  }
}

TEST(LscDriver, an_opening_without_a_device_fails_once_and_goes_on_asking) {
  LscCell cell(LscProfile::kBus);
  cell.to_host.cut = true;
  cell.driver.open(cell.now);
  cell.run_for(10s);
  EXPECT_EQ(cell.count(Kind::kFailed), 1U);
  cell.to_host.cut = false;
  EXPECT_TRUE(cell.run_until(Kind::kReady));
}

TEST(LscDriver, the_run_button_makes_the_position_lost_and_its_group_is_stopped) {
  LscCell cell(LscProfile::kLsc6);
  const lsc::Move action{1000, {{6, 1700}}};
  using Step = lsc::GroupStep;
  for (const Step& step : {Step{Step::Kind::kBegin, LscBoard::kButtonGroup, 0, 0, {}},
                           Step{Step::Kind::kAction, 0, 0, 0, action}}) {
    cell.machine.receive(lsc::encode(lsc::Request{step}), cell.now);
  }
  cell.start(kLscHere);
  cell.machine.board().press_run(true, cell.now);
  cell.run_for(1s);
  EXPECT_FALSE(cell.machine.board().groups().running());
  EXPECT_EQ(cell.count(Kind::kNotice), 1U);
  EXPECT_EQ(cell.count(Kind::kReady), 1U);
  EXPECT_EQ(cell.driver.positions()[0].quality, Quality::kLost);
}

TEST(LscDriver, a_low_supply_is_told_once_and_an_empty_one_is_a_fault_until_it_is_back) {
  LscCell cell(LscProfile::kLsc6);
  cell.start(kLscHere);
  cell.machine.disturb({sim::Disturbance::Kind::kSupply, -1, 6.2});
  cell.run_for(5s);
  EXPECT_EQ(cell.count(Kind::kNotice), 1U);
  EXPECT_NEAR(cell.driver.health().supply_volts.value(), 6.2, 0.2);
  EXPECT_EQ(cell.driver.state(), DriverState::kReady);
  cell.machine.disturb({sim::Disturbance::Kind::kSupply, -1, 4.9});
  cell.run_for(3s);
  EXPECT_EQ(cell.driver.state(), DriverState::kFault);
  EXPECT_EQ(cell.driver.fault()->code, ErrorCode::kSupplyLow);
  EXPECT_EQ(cell.driver.positions()[0].quality, Quality::kLost);
  EXPECT_EQ(refusal(cell.driver.move(cell.to(kLscHere, 2s), cell.now)), ErrorCode::kSupplyLow);
  EXPECT_EQ(refusal(cell.driver.clear_fault(cell.now)), ErrorCode::kSupplyLow);
  cell.machine.disturb({sim::Disturbance::Kind::kSupply, -1, 7.4});
  cell.run_for(2s);
  EXPECT_TRUE(cell.driver.clear_fault(cell.now));
  EXPECT_TRUE(cell.run_until(Kind::kReady));
}

TEST(LscDriver, a_blocked_bus_joint_is_reported_with_where_it_really_is) {
  LscCell cell(LscProfile::kBus);
  cell.start(kLscHere);
  cell.machine.disturb({sim::Disturbance::Kind::kBlock, 0, -0.1});
  cell.stream(kThere, 1600ms);
  EXPECT_EQ(cell.failure(), ErrorCode::kMissedTarget);
  EXPECT_EQ(cell.driver.positions()[0].quality, Quality::kMeasured);
  EXPECT_NEAR(cell.driver.positions()[0].q, -0.1, 0.01);
  EXPECT_EQ(cell.ends(), cell.commands);
}

TEST(LscDriver, an_esp32_that_restarts_is_noticed_by_its_boot_text) {
  LscCell cell(LscProfile::kEsp32);
  cell.start(kLscHere);
  cell.machine.disturb({sim::Disturbance::Kind::kSupply, -1, 2});
  cell.run_for(50ms);
  EXPECT_FALSE(cell.machine.powered());
  cell.machine.disturb({sim::Disturbance::Kind::kSupply, -1, 7.4});
  cell.run_for(1s);
  EXPECT_EQ(cell.count(Kind::kNotice), 1U);
  EXPECT_EQ(cell.count(Kind::kReady), 1U);
  EXPECT_EQ(cell.driver.positions()[0].quality, Quality::kLost);
}

TEST(LscDriver, closing_in_motion_leaves_an_interval_that_contains_the_truth) {
  for (int breaks = 2; breaks < 20; ++breaks) {
    LscCell cell(LscProfile::kLsc6);
    cell.start(kLscHere);
    cell.stream(kThere, 1600ms, [&](int k) { return k < breaks; });
    cell.driver.close(cell.now);
    cell.run_for(500ms);
    EXPECT_EQ(cell.ends(), cell.commands);
    EXPECT_EQ(cell.failure(), ErrorCode::kPortClosed);
    for (std::size_t i = 0; i < 5; ++i) {
      const JointPosition& joint = cell.driver.positions()[i];
      ASSERT_EQ(joint.quality, Quality::kUncertain);
      EXPECT_GE(cell.machine.truth().joints[i].q, joint.lower) << i;
      EXPECT_LE(cell.machine.truth().joints[i].q, joint.upper) << i;
    }
    EXPECT_EQ(refusal(cell.driver.move(cell.to(kLscHere, 2s), cell.now)), ErrorCode::kPortClosed);
  }
}

TEST(LscDriver, a_declared_position_is_taken_by_the_board_that_cannot_be_asked) {
  LscCell cell(LscProfile::kLsc6);
  cell.start(kLscHere);
  const std::vector<JointPosition> known(cell.driver.positions().begin(),
                                         cell.driver.positions().end());
  cell.driver.close(cell.now);
  cell.driver.declare_positions(known);
  cell.driver.open(cell.now);
  cell.run_for(1s);
  EXPECT_EQ(cell.driver.positions()[1].quality, Quality::kCommanded);
  cell.events.clear();
  cell.commands = 0;
  cell.stream(kThere, 1600ms);
  EXPECT_EQ(cell.count(Kind::kDone), 20U);
  EXPECT_LT(cell.worst(kThere), kLscSag);
  cell.driver.close(cell.now);
  cell.driver.open(cell.now);
  cell.run_for(1s);
  EXPECT_EQ(cell.driver.positions()[1].quality, Quality::kLost) << "a declaration counts once";
}

/// How far and how long a joint was away from the path that the same motion takes undamaged.
struct Excursion {
  double farthest = 0;  ///< rad
  Duration longest{};   ///< in one piece, beyond kLscSag
};

TEST(LscDriver, one_flipped_bit_bends_the_path_by_a_bounded_angle_for_a_bounded_time) {
  Excursion worst;
  for_random_cases(150, [&](Random& random) {
    const auto segment = static_cast<int>(random.integer(1, 20));
    const auto byte = static_cast<std::uint64_t>(random.integer(0, 21));
    const auto bits = static_cast<std::uint8_t>(1 << random.integer(0, 7));
    LscCell clean(LscProfile::kLsc6);
    LscCell hit(LscProfile::kLsc6);
    for (LscCell* cell : {&clean, &hit}) cell->start(kLscHere);
    std::array<Duration, 5> away{};
    const auto compare = [&](Duration step) {
      const sim::Truth a = clean.machine.truth();
      const sim::Truth b = hit.machine.truth();
      for (std::size_t i = 0; i < 5; ++i) {
        const double off = std::abs(a.joints[i].q - b.joints[i].q);
        worst.farthest = std::max(worst.farthest, off);
        away[i] = off > kLscSag ? away[i] + step : Duration{};
        worst.longest = std::max(worst.longest, away[i]);
      }
    };
    for (int k = 1; k <= 20; ++k) {
      while (!clean.driver.wants_move(clean.now) || !hit.driver.wants_move(hit.now)) {
        for (LscCell* cell : {&clean, &hit}) cell->run_for(2ms);
        compare(2ms);
      }
      if (k == segment) hit.to_board.hit(byte, Fault::kFlip, bits);
      LscPose at{};
      const double s = k / 20.0;
      for (std::size_t i = 0; i < 5; ++i) {
        at[i] = kLscHere[i] + (kThere[i] - kLscHere[i]) * s * s * (3 - 2 * s);
      }
      for (LscCell* cell : {&clean, &hit}) {
        ASSERT_TRUE(cell->driver.move(cell->to(at, 80ms, k < 20 ? 1 : 0), cell->now));
      }
    }
    for (int i = 0; i < 300; ++i) {
      for (LscCell* cell : {&clean, &hit}) cell->run_for(2ms);
      compare(2ms);
    }
    EXPECT_LT(hit.worst(kThere), kLscSag) << "the final pose is right";
    EXPECT_EQ(hit.ends(), 20U);
  });
  std::cout << "  at most " << worst.farthest << " rad off, " << to_seconds(worst.longest) * 1e3
            << " ms long\n";
  EXPECT_LT(worst.farthest, 0.8);
  EXPECT_LE(worst.longest, 350ms);
}

TEST(LscDriver, random_faults_never_make_a_claimed_position_wrong) {
  int claims = 0;
  for_random_cases(150, [&](Random& random) {
    const LscProfile profile = kLscProfiles[static_cast<std::size_t>(random.integer(0, 2))];
    LscCell cell(profile, random.bits());
    cell.start(kLscHere);
    // At most one fault in four frames: more is a broken cable, which the silence tells.
    for (int k = 0; k < 6; ++k) {
      LscLine& line = random.chance(0.7) ? cell.to_board : cell.to_host;
      line.hit(static_cast<std::uint64_t>(std::int64_t{k} * 88 + random.integer(0, 40)),
               static_cast<Fault>(random.integer(0, 3)),
               static_cast<std::uint8_t>(1 << random.integer(0, 7)));
    }
    LscPose target{};
    for (double& q : target) q = random.uniform(-0.8, 0.8);
    const int stop_at = static_cast<int>(random.integer(5, 60));
    bool stopped = false;
    cell.stream(target, 2s, [&](int k) {
      stopped = k == stop_at;
      return !stopped;
    });
    if (stopped) cell.driver.stop(cell.now);
    cell.run_for(3s);
    EXPECT_EQ(cell.ends(), cell.commands + (stopped && cell.commands == 0 ? 1 : 0));
    const sim::Truth truth = cell.machine.truth();
    for (std::size_t i = 0; i < 5; ++i) {
      const JointPosition& joint = cell.driver.positions()[i];
      if (joint.quality == Quality::kLost) continue;
      ++claims;
      EXPECT_GE(truth.joints[i].q, joint.lower - kLscSag) << "joint " << i;
      EXPECT_LE(truth.joints[i].q, joint.upper + kLscSag) << "joint " << i;
    }
  });
  std::cout << "  " << claims << " of 750 joints claimed a place\n";
  EXPECT_GT(claims, 375) << "a driver that knows nothing says nothing wrong";
}

TEST(LscDriver, a_damaged_first_move_is_mended_while_it_is_under_way) {
  for_random_cases(60, [](Random& random) {
    LscCell cell(LscProfile::kLsc6, random.bits());
    cell.driver.open(cell.now);
    cell.run_for(800ms);
    cell.to_board.hit(static_cast<std::uint64_t>(random.integer(0, 21)),
                      static_cast<Fault>(random.integer(0, 2)),
                      static_cast<std::uint8_t>(1 << random.integer(0, 7)));
    ASSERT_TRUE(cell.driver.move(cell.to(kThere, 2s), cell.now));
    cell.run_for(3s);
    EXPECT_EQ(cell.ends(), 1U);
    EXPECT_LT(cell.worst(kThere), kLscSag);
  });
}

TEST(LscDriver, a_damaged_last_repeat_is_mended_behind_the_next_sign_of_life) {
  int wrong = 0;
  for_random_cases(120, [&](Random& random) {
    LscCell cell(LscProfile::kLsc6, random.bits());
    cell.start(kLscHere);
    cell.stream(kThere, 1600ms, [&](int k) { return k < 20; });
    LscCell clean = cell;
    ASSERT_TRUE(clean.driver.move(clean.to(kThere, 80ms), clean.now));
    while (clean.count(Kind::kDone) < 20) clean.run_for(1ms);
    const std::uint64_t last_repeat = clean.to_board.count() - cell.to_board.count() - 22;
    cell.to_board.hit(last_repeat + static_cast<std::uint64_t>(random.integer(4, 21)), Fault::kFlip,
                      static_cast<std::uint8_t>(1 << random.integer(0, 7)));
    ASSERT_TRUE(cell.driver.move(cell.to(kThere, 80ms), cell.now));
    double worst = 0;
    for (int i = 0; i < 150; ++i) {
      cell.run_for(10ms);
      if (i > 30) worst = std::max(worst, cell.worst(kThere));
    }
    wrong += worst > 0.1 ? 1 : 0;
    EXPECT_EQ(cell.driver.state(), DriverState::kReady);
    EXPECT_LT(cell.worst(kThere), kLscSag);
  });
  EXPECT_GT(wrong, 2) << "of the flips, those that nothing else mends";
}

TEST(LscDriver, a_servo_that_stands_wrong_at_rest_goes_back_slowly) {
  int wrong = 0;
  for_random_cases(120, [&](Random& random) {
    LscCell cell(LscProfile::kLsc6, random.bits());
    cell.start(kLscHere);
    // In a frame of the end of a motion, or in one at rest: neither way may anything leap.
    cell.stream(kThere, 1600ms);
    cell.run_for(300ms);
    const auto frame = cell.to_board.count();
    cell.run_for(1100ms);
    ASSERT_GE(cell.to_board.count(), frame + 26) << "a question of 4 bytes, a frame of 22";
    LscCell clean = cell;
    clean.run_for(1100ms);
    ASSERT_GE(clean.to_board.count() - cell.to_board.count(), 26U);
    // A flipped position: behind 55 55 LEN 03 n and the time, each servo has id, low and high byte.
    const auto servo = static_cast<std::uint64_t>(random.integer(0, 4));
    const auto bits = static_cast<std::uint8_t>(random.chance(0.5) ? 0x80 : 0x01);
    cell.to_board.hit(4 + 7 + 3 * servo + (bits == 0x80 ? 1 : 2), Fault::kFlip, bits);
    double worst = 0;
    double fastest = 0;
    for (int i = 0; i < 350; ++i) {
      cell.run_for(10ms);
      worst = std::max(worst, cell.worst(kThere));
      const sim::Truth truth = cell.machine.truth();
      for (std::size_t k = 0; k < 5; ++k) fastest = std::max(fastest, std::abs(truth.joints[k].qd));
    }
    wrong += worst > 0.1 ? 1 : 0;
    EXPECT_LT(fastest, worst / 0.9 * 1.5 + 0.1) << "on a way of " << worst;
    EXPECT_LT(cell.worst(kThere), kLscSag);
  });
  EXPECT_GT(wrong, 60) << "the flips reach the servos";
}

TEST(LscDriver, targets_are_said_again_at_rest_only_while_they_are_known_and_only_where_unread) {
  for (const LscProfile profile : kLscProfiles) {
    LscCell cell(profile);
    const auto frames = [&](Duration duration) {
      const std::size_t from = cell.to_board.history.size();
      cell.run_for(duration);
      lsc::FrameDecoder decoder;
      int moves = 0;
      for (std::size_t i = from; i < cell.to_board.history.size(); ++i) {
        const auto frame = decoder.push(cell.to_board.history[i]);
        moves += frame && frame->command == 3 ? 1 : 0;
      }
      return moves;
    };
    cell.driver.open(cell.now);
    EXPECT_EQ(frames(5s), 0) << "before the first move";
    cell.events.clear();
    cell.start(kLscHere);
    EXPECT_NEAR(frames(10s), profile == LscProfile::kLsc6 ? 10 : 0, profile == LscProfile::kLsc6);
    EXPECT_LT(cell.worst(kLscHere), kLscSag);
    cell.to_host.cut = true;
    cell.run_for(5s);
    EXPECT_EQ(frames(5s), 0) << "a board that says nothing";
    cell.to_host.cut = false;
    ASSERT_TRUE(cell.run_until(Kind::kReady));
    EXPECT_EQ(frames(3s), 0) << "lost";
  }
}

TEST(LscDriver, a_claimed_interval_contains_a_servo_that_rests_in_its_dead_band) {
  for (const LscProfile profile : {LscProfile::kLsc6, LscProfile::kEsp32}) {
    double farthest = 0;
    for (const double side : {-1.0, 1.0}) {
      LscCell cell(profile);
      cell.start({});
      LscPose there = kThere;
      for (double& q : there) q *= side;
      cell.stream(there, 1600ms);
      const sim::Truth truth = cell.machine.truth();
      for (std::size_t i = 0; i < 5; ++i) {
        const JointPosition& joint = cell.driver.positions()[i];
        ASSERT_EQ(joint.quality, Quality::kCommanded);
        EXPECT_GE(truth.joints[i].q, joint.lower) << i;
        EXPECT_LE(truth.joints[i].q, joint.upper) << i;
        EXPECT_LT(joint.upper - joint.lower, 0.13);
        // Nothing pulls at the base, which turns about the vertical.
        if (i == 0) farthest = std::max(farthest, std::abs(truth.joints[i].q - joint.q));
      }
    }
    EXPECT_GT(farthest, kPi / 2000 / 2) << "a servo is not as exact as its wire";
  }
}

TEST(LscDriver, an_esp32_that_hears_go_home_in_a_damaged_question_is_called_back) {
  LscCell cell(LscProfile::kEsp32);
  cell.start(kLscHere);
  const auto before = cell.driver.health().timeouts;
  cell.stream(kThere, 1600ms, [&](int k) {
    // Behind the last segment and its two repeats of 22 bytes: 55 55 02 0D, and 0D becomes 0C.
    if (k == 20) cell.to_board.hit(3 * 22 + 3, Fault::kFlip, 1);
    return true;
  });
  EXPECT_EQ(cell.driver.health().timeouts, before + 1);
  lsc::FrameDecoder decoder;
  int questions = 0;
  for (const std::uint8_t byte : cell.to_board.history) {
    const auto frame = decoder.push(byte);
    questions += frame && frame->command == 13 ? 1 : 0;
  }
  EXPECT_GE(questions, 7) << "two at open, two behind the first move, one damaged, two more";
  EXPECT_EQ(cell.count(Kind::kDone), 20U);
  EXPECT_LT(cell.worst(kThere), kLscSag);
}

TEST(LscDriver, a_port_that_takes_no_bytes_is_a_silent_device) {
  RobotModel model = learm(LscProfile::kLsc6);
  LscDriver driver(model.device.settings.get<LscDevice>(), model.joints, std::nullopt);
  driver.open(Instant{});
  int failed = 0;
  for (Instant now{}; now < Instant{} + 5s; now += 10ms) {
    driver.poll(now);
    while (const auto event = driver.take_event()) {
      EXPECT_EQ(event->kind, Kind::kFailed);
      EXPECT_EQ(event->error.code, ErrorCode::kDeviceSilent);
      ++failed;
    }
  }
  EXPECT_EQ(failed, 1);
  EXPECT_EQ(driver.state(), DriverState::kOpening);
}

TEST(LscDriver, noise_that_never_ends_is_asked_into_after_two_seconds) {
  LscCell cell(LscProfile::kLsc6);
  cell.driver.open(cell.now);
  const std::uint8_t noise = 0x0A;
  for (int i = 0; i < 95; ++i) {
    cell.driver.receive({&noise, 1}, cell.now);
    cell.run_for(20ms);
  }
  EXPECT_EQ(cell.to_board.count(), 0U);
  for (int i = 0; i < 50; ++i) {
    cell.driver.receive({&noise, 1}, cell.now);
    cell.run_for(20ms);
  }
  EXPECT_EQ(cell.count(Kind::kReady), 1U);
  EXPECT_GT(cell.driver.health().unexpected, 90U);
}

TEST(LscDriver, driving_does_not_allocate) {
  RobotModel model = learm(LscProfile::kEsp32);
  LscDriver driver(model.device.settings.get<LscDevice>(), model.joints,
                   std::get<SerialGeometry>(model.geometry).gripper);
  LscBoard board(LscProfile::kEsp32, Instant{});
  JointMove move;
  for (int i = 0; i < 5; ++i) move.q.push_back(0.1);
  move.qd.resize(5);
  move.duration = 2s;
  int done = 0;
  const AllocationCounter allocations;
  driver.open(Instant{});
  for (Instant now{}; now < Instant{} + 5s; now += 1ms) {
    std::array<std::uint8_t, 64> piece{};
    if (const auto count = driver.take_output(piece)) board.receive({piece.data(), count}, now);
    board.advance(now);
    if (const auto count = board.take_output(piece)) driver.receive({piece.data(), count}, now);
    driver.poll(now);
    if (now == Instant{} + 1s) {
      EXPECT_TRUE(driver.move(move, now));
    }
    while (const auto event = driver.take_event()) done += event->kind == Kind::kDone ? 1 : 0;
  }
  driver.stop(Instant{} + 5s);
  EXPECT_EQ(allocations.count(), 0U);
  EXPECT_EQ(done, 1);
}

}  // namespace
}  // namespace sinew
