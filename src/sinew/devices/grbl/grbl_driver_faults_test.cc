// What goes wrong: power, cables, settings, alarms, a host that dies.
#include <gtest/gtest.h>

#include "sinew/core/error_code.h"
#include "sinew/devices/grbl/grbl_test_cell.h"
#include "support/property.h"

namespace sinew {
namespace {

using namespace std::chrono_literals;
using test::grbl_robot;
using test::GrblCell;
using test::kGrblStep;
using Kind = DriverEvent::Kind;

/// What a journal has of it, for the next run.
std::vector<JointPosition> left_by(const GrblDriver& driver) {
  return {driver.positions().begin(), driver.positions().end()};
}

/// The next run of the host, on the machine as it is.
void open_anew(GrblCell& cell, const std::vector<JointPosition>& left) {
  cell.driver = GrblDriver(cell.robot.device.settings.get<GrblDevice>(), cell.robot.joints,
                           cell.robot.device.baud);
  cell.events.clear();
  cell.driver.declare_positions(left);
  cell.driver.open(cell.now);
  EXPECT_TRUE(cell.run_until(DriverState::kReady, 20s));
}

/// Its power goes away and comes back while no host listens.
void cut_power_unheard(GrblCell& cell, Duration away) {
  cell.machine.disturb({sim::Disturbance::Kind::kSupply, -1, 0});
  cell.machine.advance(cell.now += away);
  cell.machine.disturb({sim::Disturbance::Kind::kSupply, -1, 24});
  cell.machine.advance(cell.now += 3s);
  std::array<std::uint8_t, 512> gone{};
  cell.machine.take_output(gone);
}

TEST(GrblFaults, the_next_run_goes_on_where_the_board_counts_on) {
  GrblCell cell;
  auto motion = cell.motion_to({1, -0.5, 0.25}, 1.5);
  cell.run(motion);
  open_anew(cell, left_by(cell.driver));
  EXPECT_EQ(cell.driver.positions()[0].quality, PositionQuality::kCommanded);
  EXPECT_NEAR(cell.driver.positions()[0].q, 1, kGrblStep);
}

TEST(GrblFaults, behind_a_cut_of_its_power_the_next_run_knows_nothing) {
  GrblCell cell;
  auto motion = cell.motion_to({1, -0.5, 0.25}, 1.5);
  cell.run(motion);
  const auto left = left_by(cell.driver);
  cut_power_unheard(cell, 1s);
  open_anew(cell, left);
  EXPECT_EQ(cell.driver.positions()[0].quality, PositionQuality::kLost);
}

TEST(GrblFaults, a_board_that_was_left_at_0_everywhere_is_known_by_its_mark) {
  GrblCell cell;
  open_anew(cell, left_by(cell.driver));
  EXPECT_EQ(cell.driver.positions()[0].quality, PositionQuality::kCommanded);
  // Which goes with its power, and needs a third axis.
  const auto left = left_by(cell.driver);
  cut_power_unheard(cell, 0s);
  open_anew(cell, left);
  EXPECT_EQ(cell.driver.positions()[0].quality, PositionQuality::kLost);
  GrblCell two(grbl_robot(2));
  open_anew(two, left_by(two.driver));
  EXPECT_EQ(two.driver.positions()[0].quality, PositionQuality::kLost);
}

TEST(GrblFaults, a_host_that_dies_in_a_motion_finds_the_machine_again) {
  test::for_random_cases(60, [](test::Random& random) {
    GrblCell cell;
    auto motion = cell.motion_to({1, -0.5, 0.25}, 1.5);
    cell.run(motion, from_seconds(random.uniform(0.05, 1.5)));
    // What a journal reserves: the whole way.
    std::vector<JointPosition> left = left_by(cell.driver);
    for (std::size_t i = 0; i < left.size(); ++i) {
      left[i].quality = PositionQuality::kUncertain;
      left[i].lower = std::min(motion.from[i], motion.to[i]) - 0.01;
      left[i].upper = std::max(motion.from[i], motion.to[i]) + 0.01;
    }
    cell.connected = false;
    for (int i = 0; i < random.integer(0, 3000); ++i) {
      cell.machine.advance(cell.now += 1ms);
      std::array<std::uint8_t, 64> gone{};
      cell.machine.take_output(gone);
    }
    cell.connected = true;
    open_anew(cell, left);
    if (testing::Test::HasFailure()) return;
    // Within half a digit of 0 it might have restarted.
    const bool moved = std::abs(cell.q(0)) > 3 * kGrblStep;
    const auto quality = cell.driver.positions()[0].quality;
    ASSERT_TRUE(!moved || quality == PositionQuality::kCommanded);
    ASSERT_FALSE(cell.machine.truth().moving);
    cell.expect_honest();
  });
}

TEST(GrblFaults, a_closed_port_says_until_when_the_board_goes_on) {
  GrblCell cell;
  auto motion = cell.motion_to({1, -0.5, 0.25}, 1.5);
  cell.run(motion, 600ms);
  cell.driver.close(cell.now);
  cell.run_for(1ms);
  const auto until = cell.driver.goes_on_until();
  ASSERT_TRUE(until);
  EXPECT_LT(*until - cell.now, 800ms);
  while (cell.now < *until + 50ms) cell.machine.advance(cell.now += 1ms);
  EXPECT_FALSE(cell.machine.truth().moving);
}

TEST(GrblFaults, power_that_goes_away_is_silence_then_a_restart_and_everything_is_lost) {
  GrblCell cell;
  auto motion = cell.motion_to({1, -0.5, 0.25}, 1.5);
  cell.run(motion, 700ms);
  const std::size_t accepted = motion.next - 1;
  cell.machine.disturb({sim::Disturbance::Kind::kSupply, -1, 0});
  cell.run_for(3s);
  EXPECT_EQ(cell.driver.state(), DriverState::kOpening);
  EXPECT_EQ(cell.count(Kind::kDone) + cell.count(Kind::kFailed), accepted);
  EXPECT_EQ(cell.events.back().error.code, ErrorCode::kDeviceSilent);
  cell.machine.disturb({sim::Disturbance::Kind::kSupply, -1, 24});
  EXPECT_TRUE(cell.run_until(DriverState::kReady, 5s));
  EXPECT_EQ(cell.driver.positions()[0].quality, PositionQuality::kLost);
}

TEST(GrblFaults, a_restart_at_rest_is_a_notice_and_the_position_is_lost) {
  GrblCell cell;
  auto motion = cell.motion_to({1, -0.5, 0.25}, 1.5);
  cell.run(motion);
  cell.events.clear();
  cell.machine.disturb({sim::Disturbance::Kind::kSupply, -1, 0});
  cell.machine.disturb({sim::Disturbance::Kind::kSupply, -1, 24});
  cell.run_for(2s);
  ASSERT_GE(cell.count(Kind::kNotice), 1U);
  EXPECT_EQ(cell.driver.state(), DriverState::kReady);
  EXPECT_EQ(cell.driver.positions()[0].quality, PositionQuality::kLost);
}

/// The driver believes its file; the board is set up otherwise.
std::optional<Error> fault_with(void (*change)(RobotModel&)) {
  RobotModel file = grbl_robot();
  change(file);
  GrblCell cell(grbl_robot(), {}, false);
  cell.driver = GrblDriver(file.device.settings.get<GrblDevice>(), file.joints, file.device.baud);
  cell.driver.open(cell.now);
  EXPECT_TRUE(cell.run_until(DriverState::kFault, 3s));
  EXPECT_EQ(cell.count(Kind::kFailed), 1U);
  return cell.driver.fault();
}

TEST(GrblFaults, settings_that_do_not_fit_the_file_are_a_fault_by_name) {
  auto fault = fault_with([](RobotModel& file) { file.joints[1].velocity_max *= 1.1; });
  EXPECT_EQ(fault->code, ErrorCode::kBoardVelocity);
  EXPECT_EQ(fault->index, 1);
  EXPECT_NEAR(fault->limit, from_deg(99), 1e-4);
  EXPECT_NEAR(fault->measured, from_deg(90), 1e-4);
  fault = fault_with([](RobotModel& file) { file.joints[2].acceleration_max *= 2; });
  EXPECT_EQ(fault->code, ErrorCode::kBoardAcceleration);
  EXPECT_EQ(fault->index, 2);
  fault = fault_with(
      [](RobotModel& file) { file.device.settings.get<GrblDevice>().axes[0].steps_per_unit *= 2; });
  EXPECT_EQ(fault->code, ErrorCode::kBoardSteps);
}

TEST(GrblFaults, what_is_in_the_way_loses_steps_that_nobody_sees) {
  GrblCell cell;
  cell.honest = false;
  cell.machine.disturb({sim::Disturbance::Kind::kBlock, 0, 0.5});
  auto motion = cell.motion_to({1, -0.5, 0.25}, 1.5);
  cell.run(motion);
  EXPECT_EQ(cell.driver.state(), DriverState::kReady);
  EXPECT_NEAR(cell.driver.positions()[0].q, 1, kGrblStep);
  EXPECT_NEAR(cell.q(0), 0.5, kGrblStep);
  EXPECT_TRUE(cell.machine.truth().joints[0].lost_steps);
}

TEST(GrblFaults, a_switch_that_closes_is_a_fault_that_names_its_joint_and_can_be_cleared) {
  GrblCell cell(grbl_robot(3, true), {}, false);
  cell.honest = false;
  cell.open(false);
  ASSERT_TRUE(cell.driver.home(cell.now, kAllJoints));
  ASSERT_TRUE(cell.run_until(DriverState::kReady, 170s));
  // Steps are lost on the way up: on the way back its switch comes too early.
  cell.machine.disturb({sim::Disturbance::Kind::kBlock, 2, cell.q(2) + 0.5});
  auto out = cell.motion_to({cell.q(0), cell.q(1), cell.q(2) + 1}, 2);
  cell.run(out);
  cell.machine.disturb({sim::Disturbance::Kind::kUnblock, 2, 0});
  cell.events.clear();
  auto back = cell.motion_to({cell.q(0), cell.q(1), -1.48}, 3);
  cell.run(back);
  ASSERT_EQ(cell.driver.state(), DriverState::kFault);
  EXPECT_EQ(cell.driver.fault(), (Error{ErrorCode::kEndStop, 2}));
  EXPECT_EQ(cell.driver.positions()[0].quality, PositionQuality::kLost);
  EXPECT_FALSE(cell.driver.wants_move(cell.now));
  ASSERT_TRUE(cell.driver.clear_fault(cell.now));
  ASSERT_TRUE(cell.run_until(DriverState::kReady, 3s));
  EXPECT_EQ(cell.driver.positions()[0].quality, PositionQuality::kLost);
}

TEST(GrblFaults, a_search_that_finds_no_switch_is_a_fault_on_each_firmware) {
  for (const GrblFirmware firmware : {GrblFirmware::kGrbl, GrblFirmware::kGrblHal}) {
    RobotModel robot = grbl_robot(3, true);
    robot.device.settings.get<GrblDevice>().firmware = firmware;
    GrblCell cell(robot, {}, false);
    cell.honest = false;
    cell.open(false);
    cell.machine.disturb({sim::Disturbance::Kind::kBlock, 0, cell.q(0) - 0.2});
    ASSERT_TRUE(cell.driver.home(cell.now, kAllJoints));
    ASSERT_TRUE(cell.run_until(DriverState::kFault, 170s));
    cell.run_for(3s);
    ASSERT_EQ(cell.driver.state(), DriverState::kFault);
    EXPECT_EQ(cell.driver.fault()->code, ErrorCode::kHomingFailed);
    EXPECT_EQ(cell.count(Kind::kFailed), 1U);
    cell.machine.disturb({sim::Disturbance::Kind::kUnblock, 0, 0});
    ASSERT_TRUE(cell.driver.clear_fault(cell.now));
    ASSERT_TRUE(cell.run_until(DriverState::kReady, 5s));
    ASSERT_TRUE(cell.driver.home(cell.now, kAllJoints));
    EXPECT_TRUE(cell.run_until(DriverState::kReady, 170s));
    EXPECT_EQ(cell.driver.positions()[0].quality, PositionQuality::kCommanded);
  }
}

TEST(GrblFaults, a_nudge_is_stopped_on_each_firmware) {
  for (const GrblFirmware firmware : {GrblFirmware::kGrbl, GrblFirmware::kGrblHal}) {
    RobotModel robot = grbl_robot();
    robot.device.settings.get<GrblDevice>().firmware = firmware;
    GrblCell cell(robot);
    ASSERT_TRUE(cell.driver.nudge(0, 0.08, 2s, cell.now));
    cell.run_for(500ms);
    cell.driver.stop(cell.now);
    ASSERT_TRUE(cell.run_until(DriverState::kReady, 2s));
    EXPECT_EQ(cell.count(Kind::kStopped), 1U);
    EXPECT_GT(cell.q(0), 0.01);
    EXPECT_LT(cell.q(0), 0.04);
    EXPECT_EQ(cell.driver.positions()[0].quality, PositionQuality::kCommanded);
  }
}

RobotModel with_firmware(GrblFirmware firmware, bool homes) {
  RobotModel robot = grbl_robot(3, homes);
  robot.device.settings.get<GrblDevice>().firmware = firmware;
  return robot;
}

TEST(GrblFaults, a_board_that_asks_to_be_homed_first_has_no_fault) {
  for (const GrblFirmware firmware : {GrblFirmware::kGrbl, GrblFirmware::kGrblHal}) {
    GrblCell cell(with_firmware(firmware, true), {}, false);
    cell.honest = false;
    cell.open(false);
    cell.run_for(2s);
    EXPECT_EQ(cell.driver.state(), DriverState::kReady);
    EXPECT_EQ(cell.driver.positions()[0].quality, PositionQuality::kLost);
    if (firmware == GrblFirmware::kGrblHal) {
      // It cannot be unlocked, and a stated place does not do it.
      cell.declare();
      const auto refused = cell.driver.nudge(0, from_deg(1), 500ms, cell.now);
      ASSERT_FALSE(refused);
      EXPECT_EQ(refused.error().code, ErrorCode::kNotHomed);
    }
    ASSERT_TRUE(cell.driver.home(cell.now, kAllJoints));
    EXPECT_TRUE(cell.run_until(DriverState::kReady, 170s));
    EXPECT_EQ(cell.driver.positions()[0].quality, PositionQuality::kCommanded);
  }
}

TEST(GrblFaults, a_search_that_a_host_left_is_said_and_ended_by_the_next_one) {
  GrblCell cell(grbl_robot(3, true), {}, false);
  cell.open(false);
  ASSERT_TRUE(cell.driver.home(cell.now, kAllJoints));
  cell.run_for(1s);
  cell.driver.close(cell.now);
  ASSERT_TRUE(cell.driver.goes_on_until());
  EXPECT_GT(*cell.driver.goes_on_until() - cell.now, 100s);
  EXPECT_TRUE(cell.machine.truth().moving);
  cell.events.clear();
  cell.driver.open(cell.now);
  EXPECT_TRUE(cell.run_until(DriverState::kReady, 5s));
  EXPECT_FALSE(cell.machine.truth().moving);
}

TEST(GrblFaults, power_that_is_cut_between_a_reset_and_its_welcome_is_noticed) {
  test::for_random_cases(80, [](test::Random& random) {
    GrblCell cell;
    auto motion = cell.motion_to({1, -0.5, 0.25}, 1.5);
    cell.run(motion, 700ms);
    cell.driver.stop(cell.now);
    cell.run_for(from_seconds(random.uniform(0.05, 0.6)));
    cell.machine.disturb({sim::Disturbance::Kind::kSupply, -1, 0});
    cell.run_for(from_seconds(random.uniform(0, 1.5)));
    cell.machine.disturb({sim::Disturbance::Kind::kSupply, -1, 24});
    cell.run_for(8s);
    ASSERT_EQ(cell.driver.state(), DriverState::kReady);
    ASSERT_EQ(cell.driver.positions()[0].quality, PositionQuality::kLost);
  });
}

TEST(GrblFaults, the_mark_stays_on_each_firmware_however_often_it_is_opened_and_stopped) {
  for (const GrblFirmware firmware : {GrblFirmware::kGrbl, GrblFirmware::kGrblHal}) {
    GrblCell cell(with_firmware(firmware, false));
    for (int i = 0; i < 4; ++i) {
      open_anew(cell, left_by(cell.driver));
      EXPECT_EQ(cell.driver.positions()[0].quality, PositionQuality::kCommanded) << i;
      ASSERT_TRUE(cell.driver.nudge(1, 0.05, 1s, cell.now));
      cell.run_for(200ms);
      cell.driver.stop(cell.now);
      ASSERT_TRUE(cell.run_until(DriverState::kReady, 3s));
      auto back = cell.motion_to({0, 0, 0}, 1);
      cell.run(back);
    }
  }
}

TEST(GrblFaults, a_nudge_that_nobody_hears_of_goes_on_to_its_end) {
  GrblCell cell;
  ASSERT_TRUE(cell.driver.nudge(0, 0.08, 4s, cell.now));
  cell.run_for(500ms);
  cell.driver.close(cell.now);
  const auto until = cell.driver.goes_on_until();
  ASSERT_TRUE(until);
  while (cell.now < *until - 300ms) cell.machine.advance(cell.now += 1ms);
  EXPECT_TRUE(cell.machine.truth().moving);
  while (cell.now < *until) cell.machine.advance(cell.now += 1ms);
  EXPECT_FALSE(cell.machine.truth().moving);
  cell.expect_honest();
}

TEST(GrblFaults, a_fault_outlives_silence_and_a_restart) {
  GrblCell cell;
  auto motion = cell.motion_to({1, -0.5, 0.25}, 1.5);
  cell.run(motion, 500ms);
  const std::uint8_t hold = '!';
  cell.machine.receive({&hold, 1}, cell.now);
  cell.run(motion);
  ASSERT_TRUE(cell.run_until(DriverState::kFault, 3s));
  cell.machine.disturb({sim::Disturbance::Kind::kSupply, -1, 0});
  cell.run_for(3s);
  cell.machine.disturb({sim::Disturbance::Kind::kSupply, -1, 24});
  cell.run_for(5s);
  EXPECT_EQ(cell.driver.state(), DriverState::kFault);
  EXPECT_FALSE(cell.driver.wants_move(cell.now));
  ASSERT_TRUE(cell.driver.clear_fault(cell.now));
  EXPECT_TRUE(cell.run_until(DriverState::kReady, 3s));
}

TEST(GrblFaults, a_board_of_fewer_axes_or_one_that_sleeps_is_a_fault) {
  GrblCell cell(grbl_robot(3), {}, false);
  const RobotModel six = grbl_robot(6);
  cell.honest = false;
  cell.driver = GrblDriver(six.device.settings.get<GrblDevice>(), six.joints, six.device.baud);
  cell.driver.open(cell.now);
  ASSERT_TRUE(cell.run_until(DriverState::kFault, 5s));
  EXPECT_EQ(cell.driver.fault()->code, ErrorCode::kModelMismatch);

  GrblCell asleep;
  const std::string_view sleeps = "<Sleep|MPos:0.000,0.000,0.000>\n";
  asleep.driver.receive({reinterpret_cast<const std::uint8_t*>(sleeps.data()), sleeps.size()},
                        asleep.now);
  ASSERT_EQ(asleep.driver.state(), DriverState::kFault);
  EXPECT_EQ(asleep.driver.fault()->code, ErrorCode::kBoardRests);
  EXPECT_EQ(asleep.driver.positions()[0].quality, PositionQuality::kLost);
}

TEST(GrblFaults, while_somebody_else_moves_it_nothing_is_sent_and_its_place_is_followed) {
  GrblCell cell;
  cell.honest = false;  // between two statuses
  const std::string_view jog = "$J=G21G91X5.000F300.000\n";
  cell.machine.receive({reinterpret_cast<const std::uint8_t*>(jog.data()), jog.size()}, cell.now);
  cell.run_for(600ms);
  EXPECT_EQ(cell.count(Kind::kNotice), 1U);
  EXPECT_EQ(cell.events.back().error.code, ErrorCode::kForeignMotion);
  EXPECT_FALSE(cell.driver.wants_move(cell.now));
  const auto refused = cell.driver.move({{0, 0, 0}, {0, 0, 0}, 1s, {}}, cell.now);
  EXPECT_EQ(refused.error().code, ErrorCode::kForeignMotion);
  cell.run_for(2s);
  EXPECT_EQ(cell.count(Kind::kNotice), 1U);
  EXPECT_NEAR(cell.driver.positions()[0].q, from_deg(5), kGrblStep);
  auto motion = cell.motion_to({0, 0, 0}, 1);
  cell.run(motion);
  EXPECT_NEAR(cell.q(0), 0, kGrblStep);
}

TEST(GrblFaults, somebody_who_holds_the_motion_is_noticed) {
  GrblCell cell;
  auto motion = cell.motion_to({1, -0.5, 0.25}, 1.5);
  cell.run(motion, 500ms);
  const std::uint8_t hold = '!';
  cell.machine.receive({&hold, 1}, cell.now);
  cell.run(motion);
  EXPECT_TRUE(cell.run_until(DriverState::kFault, 3s));
  EXPECT_EQ(cell.driver.fault()->code, ErrorCode::kForeignMotion);
  cell.expect_honest();
}

TEST(GrblFaults, whatever_the_line_does_each_command_has_one_end_and_no_joint_is_too_fast) {
  test::for_random_cases(150, [](test::Random& random) {
    sim::LinkFaultSpec faults;
    faults.seed = random.bits();
    const double rate = std::pow(10.0, random.uniform(-5, -2.3));
    for (auto& way : faults.bytes) {
      if (random.chance(0.6)) way.flip = rate;
      if (random.chance(0.6)) way.drop = rate;
      if (random.chance(0.3)) way.duplicate = rate;
    }
    GrblCell cell(grbl_robot(), faults, false);
    cell.honest = false;  // for the time of a status a digit may be another
    cell.driver.open(cell.now);
    cell.run_until(DriverState::kReady, 20s);
    std::size_t accepted = 0;
    for (int round = 0; round < 4; ++round) {
      if (cell.driver.state() == DriverState::kFault && cell.driver.clear_fault(cell.now)) {
        ++accepted;
        cell.run_until(DriverState::kReady, 20s);
      }
      if (cell.driver.state() != DriverState::kReady) continue;
      cell.declare();
      auto motion = cell.motion_to({random.uniform(-1, 1), random.uniform(-1, 1), 0.1}, 2);
      cell.refused.reset();
      cell.run(motion, 4s);
      accepted += motion.next - 1;
      if (random.chance(0.3)) cell.driver.stop(cell.now);
      cell.run_for(6s);
    }
    cell.driver.close(cell.now);
    cell.run_for(1ms);
    const std::size_t ends =
        cell.count(Kind::kDone) + cell.count(Kind::kFailed) + cell.count(Kind::kStopped);
    ASSERT_GE(ends, accepted);
    ASSERT_LE(cell.fastest, 1.0 + 1e-9);
  });
}

/// The next host knows where it stands.
TEST(GrblFaults, a_host_that_dies_while_it_probes_finds_the_machine_again) {
  test::for_random_cases(60, [](test::Random& random) {
    GrblCell cell;
    cell.machine.disturb({sim::Disturbance::Kind::kProbe, 1, random.uniform(0.01, 0.1)});
    ASSERT_TRUE(cell.driver.probe(1, 0.08, 1s, cell.now));
    cell.run_for(from_seconds(random.uniform(0, 1.2)));
    auto left = left_by(cell.driver);
    for (JointPosition& joint : left) joint.quality = PositionQuality::kUncertain;
    left[1].lower = -kGrblStep;
    left[1].upper = 0.08 + kGrblStep;
    open_anew(cell, left);
    ASSERT_EQ(cell.driver.positions()[1].quality, PositionQuality::kCommanded);
    cell.expect_honest();
  });
}

TEST(GrblFaults, a_probe_has_one_end_whatever_is_lost_of_its_lines_and_answers) {
  test::for_random_cases(100, [](test::Random& random) {
    sim::LinkFaultSpec faults;
    faults.seed = random.bits();
    GrblCell cell(grbl_robot(), {}, false);
    cell.honest = false;  // for the time of a status a digit may be missing
    cell.open();
    for (auto& way : faults.bytes) {
      if (random.chance(0.7)) way.drop = std::pow(10.0, random.uniform(-3, -1.5));
    }
    cell.link = sim::LinkFaults(faults, cell.now);
    cell.machine.disturb({sim::Disturbance::Kind::kProbe, 1, random.uniform(0.01, 0.1)});
    ASSERT_TRUE(cell.driver.probe(1, 0.08, 1s, cell.now));
    cell.run_for(2s);
    cell.link = sim::LinkFaults({}, cell.now);
    cell.run_for(20s);
    ASSERT_NE(cell.driver.state(), DriverState::kMoving);
    // An opening that finds nothing tells of it besides.
    ASSERT_GE(cell.count(Kind::kDone) + cell.count(Kind::kFailed), 1U);
    cell.expect_honest();
    // Where its line has lost the point it is on a way of a thousand times as much.
    ASSERT_LE(cell.q(1), 0.08 + from_deg(15));
  });
}

}  // namespace
}  // namespace sinew
