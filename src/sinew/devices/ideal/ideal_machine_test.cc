#include "sinew/devices/ideal/ideal_machine.h"

#include <gtest/gtest.h>

#include "sinew/devices/ideal/ideal_test_cell.h"

namespace sinew {
namespace {

TEST(IdealMachine, stands_at_home_and_keeps_its_joints_without_power) {
  RobotModel robot = test::ideal_robot();
  robot.joints[1].home = 0.7;
  sim::IdealMachine machine(robot, Instant{});
  EXPECT_EQ(machine.truth().joints[1].q, 0.7);
  const sim::LastingState before = machine.lasting_state();
  sim::IdealMachine other(test::ideal_robot(), Instant{});
  EXPECT_TRUE(other.restore(before));
  EXPECT_EQ(other.truth().joints[1].q, 0.7);
  sim::LastingState wrong = before;
  wrong.bodies.resize(2);
  EXPECT_FALSE(other.restore(wrong));
}

TEST(IdealMachine, without_power_it_neither_hears_nor_moves) {
  test::IdealCell cell;
  auto motion = cell.motion_to({1, 0, 0});
  cell.run(motion, std::chrono::milliseconds(300));
  cell.machine.disturb({sim::Disturbance::Kind::kSupply, -1, 3});
  const double there = cell.machine.truth().joints[0].q;
  cell.run_for(std::chrono::seconds(1));
  EXPECT_EQ(cell.machine.truth().joints[0].q, there);
  EXPECT_FALSE(cell.machine.truth().moving);
  EXPECT_EQ(cell.driver.state(), DriverState::kOpening);
}

}  // namespace
}  // namespace sinew
