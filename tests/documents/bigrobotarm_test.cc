#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "sinew/core/units.h"
#include "sinew/devices/bigrobotarm/bigrobotarm_driver_multipliers.h"
#include "sinew/devices/bigrobotarm/bigrobotarm_settings.h"
#include "sinew/devices/bigrobotarm/bigrobotarm_test_cell.h"
#include "sinew/devices/bigrobotarm/bigrobotarm_wire_byte.h"
#include "sinew/devices/bigrobotarm/bigrobotarm_wire_text.h"
#include "sinew/model/joint_lookup.h"
#include "sinew/program/formats/text_forms.h"
#include "sinew/program/plans/row_planner.h"
#include "support/golden.h"
#include "support/robots.h"

// The BigRobotArm's document: its numbers and its words, typed as they stand there. Its requests
// and replies are in tests/golden/bigrobotarm_*.txt, its firmware's ways and measured times in
// devices/bigrobotarm, its lengths in config/builtin_geometry_test.cc.

namespace sinew {
namespace {

using bigrobotarm::byte::sendable;

const BigRobotArmDevice& board() {
  return test::robot("bigrobotarm").device.settings.get<BigRobotArmDevice>();
}

TEST(BigRobotArmDocument, each_joint_has_the_steps_range_and_speed_of_its_table) {
  struct Row {
    const char* name;
    double steps_per_90, steps_per_rev, range_deg, boot_deg_s;
    int sign;
  };
  const std::array rows{
      Row{"base", 6500, 3200, 90, 88.6, 1}, Row{"shoulder", 2500, 400, 90, 14.4, -1},
      Row{"elbow", 10000, 3200, 126, 28.8, -1}, Row{"wrist_rotate", 2000, 3200, 90, 144, -1},
      Row{"wrist", 3000, 3200, 90, 96, 1}};
  const RobotModel& robot = test::robot("bigrobotarm");
  for (std::size_t i = 0; i < rows.size(); ++i) {
    const BigRobotArmJoint& motor = board().joints[i];
    EXPECT_EQ(robot.joints[i].name, rows[i].name);
    EXPECT_NEAR(motor.steps_per_rad * from_deg(90), rows[i].sign * rows[i].steps_per_90, 1e-6);
    EXPECT_EQ(motor.steps_per_motor_rev, rows[i].steps_per_rev);
    EXPECT_NEAR(to_deg(robot.joints[i].upper), rows[i].range_deg, 1e-9);
    EXPECT_NEAR(to_deg(robot.joints[i].velocity_max), rows[i].boot_deg_s, 1e-6);
    // "By default each motor has 100": the base boots with 200.
    EXPECT_EQ(motor.multiplier_boot, i == 0 ? 200 : 100);
  }
}

TEST(BigRobotArmDocument, its_example_sequence_is_a_program_of_ten_moves) {
  const std::string text =
      "BEGIN I5\nG0 B100 S200 E300 WR400 W300\nG0 B0 S50 E5000 WR1500 W0\nEND\n";
  const RobotModel& robot = test::robot("bigrobotarm");
  const auto program = program::read_form(*program::text_form("sequence"), text, "s.txt", robot);
  ASSERT_TRUE(program);
  // Without S1 the firmware's joints arrive each in its own time, ours together: a note says so.
  EXPECT_EQ(program->notes.size(), 1U);
  const auto plan = program::make_plan(*program, robot, home_joints(robot));
  ASSERT_TRUE(plan);
  ASSERT_EQ(plan->orders.size(), 10U);
  const std::array<std::array<double, 5>, 2> steps{
      {{100, 200, 300, 400, 300}, {0, 50, 5000, 1500, 0}}};
  for (std::size_t k = 0; k < 10; ++k) {
    const auto& q = std::get<program::MoveOrder>(plan->orders[k].what).q;
    for (std::size_t i = 0; i < 5; ++i) {
      EXPECT_NEAR(q[i] * board().joints[i].steps_per_rad, steps[k % 2][i], 1e-3) << k << " " << i;
    }
  }
}

TEST(BigRobotArmDocument, the_text_wire_takes_G00_as_it_takes_G0) {
  const auto line = bigrobotarm::text::decode_line("G00 X5");
  ASSERT_TRUE(line);
  EXPECT_EQ(line->command, bigrobotarm::text::decode_line("G0 B5")->command);
}

TEST(BigRobotArmDocument, every_speed_and_acceleration_from_1_to_300_can_be_asked_for) {
  const RobotModel& robot = test::robot("bigrobotarm");
  for (const char* command : {"M203", "M201"}) {
    for (int m = 0; m <= 301; ++m) {
      std::string text = "S1\n" + std::string(command);
      for (const char* joint : {" B", " S", " E", " WR", " W"}) text += joint + std::to_string(m);
      const auto program =
          program::read_form(*program::text_form("sequence"), text + "\nG0 B650\n", "s.txt", robot);
      EXPECT_EQ(program.has_value(), m >= 1 && m <= 300) << command << " " << m;
    }
  }
  // 13 and 269 are inside that range and have the byte 0D, which cuts a request of the byte wire
  // (269 sets the real arm off for good): the value below is sent there.
  std::vector<int> cut;
  for (int m = 1; m <= 300; ++m) {
    if (!sendable(m)) cut.push_back(m);
  }
  EXPECT_EQ(cut, (std::vector<int>{13, 269}));
}

/// s that a row takes the arm whose profile is the document's, and the largest multiplier sent.
struct Ride {
  double seconds = 0;
  std::int32_t fastest = 0;
};
Ride ride(const std::string& rows) {
  test::BigRobotArmCell cell(test::robot("bigrobotarm"), BigRobotArmProfile::kDocument);
  cell.make_ready();
  const auto program = program::parse(rows, "p", cell.robot);
  EXPECT_TRUE(program) << rows;
  program::RowPlanner planner(cell.robot);
  const auto motion = planner.plan(home_joints(cell.robot), {}, program->steps);
  EXPECT_TRUE(motion && motion->pieces.size() == 1);
  const Instant begun = cell.now;
  EXPECT_TRUE(cell.driver.move(motion->pieces[0], cell.now));
  cell.run_until(DriverState::kReady);
  Ride out{to_seconds(cell.now - begun), 0};
  EXPECT_NEAR(out.seconds, motion->duration, 0.03 * motion->duration + 0.05) << rows;
  bigrobotarm::byte::RequestDecoder decoder;
  for (const std::uint8_t byte : cell.to_device) {
    const auto request = decoder.push(byte);
    if (!request || !*request) continue;
    if (const auto* speeds = std::get_if<bigrobotarm::SetSpeeds>(&**request)) {
      out.fastest = std::ranges::max(speeds->speeds);
    }
  }
  return out;
}

TEST(BigRobotArmDocument, a_program_that_asks_for_300_is_quicker_than_one_that_asks_for_nothing) {
  const Ride usual = ride("joint elbow=90deg");
  const Ride quick = ride("velocity elbow=300%\nacceleration elbow=300%\njoint elbow=90deg");
  EXPECT_LT(quick.seconds, 0.6 * usual.seconds);
  EXPECT_LE(usual.fastest, 200);
  EXPECT_GT(quick.fastest, 200);
  EXPECT_LE(quick.fastest, 300);
}

TEST(BigRobotArmDocument, its_example_goto_takes_2_56_s_by_its_ramps) {
  // -2400 600 -5000 800 -1000 from 0; measured 3.405 s, since the processor steps too slowly.
  constexpr std::array<double, 5> kSteps{-2400, 600, -5000, 800, -1000};
  double longest = 0;
  for (std::size_t i = 0; i < 5; ++i) {
    const std::int32_t boot = board().joints[i].multiplier_boot;
    longest = std::max(longest, motion_time(board().joints[i], kSteps[i], boot, boot));
  }
  EXPECT_NEAR(longest, 2.56, 0.005);
}

TEST(BigRobotArmDocument, of_28001_positions_364_cannot_be_sent) {
  int cut = 0;
  for (int v = -14000; v <= 14000; ++v) cut += sendable(v) ? 0 : 1;
  EXPECT_EQ(cut, 364);
  for (int v = 3328; v <= 3583; ++v) EXPECT_FALSE(sendable(v)) << v;
}

TEST(BigRobotArmDocument, the_gripper_goes_from_0_to_180) {
  // The device takes and echoes 255; the document's range is what a row may say.
  const RobotModel& robot = test::robot("bigrobotarm");
  for (const auto& [row, fine] : {std::pair{"gripper 0deg", true},
                                  {"gripper 40deg", true},
                                  {"gripper 180deg", true},
                                  {"gripper 181deg", false},
                                  {"gripper -1deg", false}}) {
    const auto program = program::parse(row, "p", robot);
    const bool taken =
        program && program::make_plan(*program, robot, home_joints(robot)).has_value();
    EXPECT_EQ(taken, fine) << row;
  }
}

}  // namespace
}  // namespace sinew
