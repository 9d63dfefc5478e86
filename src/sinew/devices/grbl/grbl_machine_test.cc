#include "sinew/devices/grbl/grbl_machine.h"

#include <gtest/gtest.h>

#include <string_view>

#include "sinew/devices/grbl/grbl_test_cell.h"

namespace sinew::sim {
namespace {

using namespace std::chrono_literals;

class GrblArm : public ::testing::Test {
 protected:
  void run(Duration duration) { machine.advance(now += duration); }
  void say(std::string_view text) {
    for (const char c : text) {
      const auto byte = static_cast<std::uint8_t>(c);
      machine.receive({&byte, 1}, now);
    }
  }
  double q(std::size_t joint) const { return machine.truth().joints[joint].q; }

  RobotModel robot = test::grbl_robot();
  Instant now{};
  GrblMachine machine{robot, now};
};

TEST_F(GrblArm, its_joints_go_where_the_motors_turn_them) {
  run(1s);
  say("G53G93G1X10.000Y10.000Z0.000F60.000\n");
  run(500ms);
  EXPECT_TRUE(machine.truth().moving);
  run(2s);
  EXPECT_NEAR(q(0), from_deg(10), from_deg(0.01));
  EXPECT_NEAR(q(1), from_deg(-10), from_deg(0.01));
  EXPECT_FALSE(machine.truth().moving);
}

TEST_F(GrblArm, what_blocks_a_joint_costs_it_steps_for_good) {
  run(1s);
  machine.disturb({Disturbance::Kind::kBlock, 0, from_deg(4)});
  say("G53G93G1X10.000Y0.000Z0.000F60.000\n");
  run(3s);
  EXPECT_NEAR(q(0), from_deg(4), 1e-9);
  EXPECT_NEAR(machine.truth().joints[0].believed, from_deg(10), from_deg(0.02));
  machine.disturb({Disturbance::Kind::kUnblock, 0, 0});
  say("G53G93G1X0.000Y0.000Z0.000F60.000\n");
  run(3s);
  EXPECT_NEAR(q(0), from_deg(-6), from_deg(0.02));
}

TEST_F(GrblArm, a_reset_in_a_motion_leaves_it_elsewhere_than_it_counts) {
  run(1s);
  say("G53G93G1X10.000Y0.000Z0.000F60.000\n");
  run(500ms);
  say("\x18");
  run(100ms);
  EXPECT_TRUE(machine.truth().joints[0].lost_steps);
  EXPECT_GT(q(0), machine.truth().joints[0].believed);
}

TEST_F(GrblArm, keeps_its_place_without_power) {
  run(1s);
  say("G53G93G1X10.000Y0.000Z0.000F60.000\n");
  run(3s);
  machine.disturb({Disturbance::Kind::kSupply, -1, 0});
  run(1s);
  EXPECT_TRUE(machine.truth().deaf);
  const LastingState state = machine.lasting_state();
  GrblMachine other(robot, now);
  EXPECT_TRUE(other.restore(state));
  EXPECT_NEAR(other.truth().joints[0].q, from_deg(10), from_deg(0.01));
  EXPECT_FALSE(other.restore({}));
}

}  // namespace
}  // namespace sinew::sim
