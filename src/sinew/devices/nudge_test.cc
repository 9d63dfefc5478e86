#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "sinew/core/error_code.h"
#include "sinew/core/units.h"
#include "sinew/devices/bigrobotarm/bigrobotarm_settings.h"
#include "sinew/devices/bigrobotarm/bigrobotarm_test_cell.h"
#include "sinew/devices/icp/icp_test_cell.h"

/// One joint a little, of machines that nobody knows the place of.
namespace sinew {
namespace {

using namespace std::chrono_literals;
using test::BigRobotArmCell;
using test::IcpCell;

TEST(Nudge, a_lost_leg_goes_as_far_as_it_is_told_and_stays_lost) {
  IcpCell cell;
  cell.run_for(100ms);
  cell.driver.open(cell.now);
  cell.settle();
  ASSERT_TRUE(cell.driver.nudge(3, from_mm(0.01), 1ms, cell.now));
  cell.settle();
  const auto units = static_cast<std::int64_t>(std::llround(from_mm(0.01) * test::kIcpUnitsPerM));
  EXPECT_EQ(cell.truth(3), units);
  EXPECT_EQ(cell.truth(2), 0);
  EXPECT_EQ(cell.driver.positions()[3].quality, PositionQuality::kLost);
}

TEST(Nudge, a_leg_takes_at_least_a_unit_and_at_most_a_millimetre) {
  IcpCell cell;
  cell.run_for(100ms);
  cell.driver.open(cell.now);
  cell.settle();
  for (const double way :
       {0.0, 1e-8, -1e-8, 1.1e-3, -5.0, std::nan(""), std::numeric_limits<double>::infinity()}) {
    const auto taken = cell.driver.nudge(1, way, 1s, cell.now);
    ASSERT_FALSE(taken) << way;
    EXPECT_EQ(taken.error().code, ErrorCode::kNudgeRange);
  }
  cell.run_for(1s);
  for (std::size_t leg = 0; leg < kLegs; ++leg) EXPECT_EQ(cell.truth(leg), 0);
}

TEST(Nudge, a_stop_ends_a_leg_on_its_way) {
  IcpCell cell;
  cell.run_for(100ms);
  cell.driver.open(cell.now);
  cell.settle();
  ASSERT_TRUE(cell.driver.nudge(0, from_mm(0.5), 1s, cell.now));
  cell.run_for(500ms);
  cell.driver.stop(cell.now);
  cell.settle();
  const auto made = cell.truth(0);
  EXPECT_GT(made, 0);
  EXPECT_LT(made, 2000);
  cell.run_for(5s);
  EXPECT_EQ(cell.truth(0), made);
}

TEST(Nudge, a_joint_of_a_lost_arm_goes_both_ways_and_the_others_stay) {
  BigRobotArmCell cell(test::big_robot_arm(BigRobotArmWire::kByte, BigRobotArmDialect::k2021),
                       BigRobotArmProfile::kDocument);
  cell.driver.open(cell.now);
  cell.run_until(DriverState::kReady);
  ASSERT_TRUE(cell.driver.wants_declaration());
  const sim::Truth before = cell.machine.truth();
  for (const double way : {from_deg(2), from_deg(-1)}) {
    ASSERT_TRUE(cell.driver.nudge(1, way, 1s, cell.now));
    cell.run(100ms);
    cell.run_until(DriverState::kReady);
  }
  const sim::Truth after = cell.machine.truth();
  EXPECT_NEAR(after.joints[1].q - before.joints[1].q, from_deg(1), from_deg(0.2));
  for (const std::size_t j : {0U, 2U, 3U, 4U}) {
    EXPECT_NEAR(after.joints[j].q, before.joints[j].q, 1e-9);
  }
  EXPECT_EQ(cell.driver.positions()[1].quality, PositionQuality::kLost);
  for (const double way : {0.0, from_deg(6), std::nan("")}) {
    EXPECT_EQ(cell.driver.nudge(1, way, 1s, cell.now).error().code, ErrorCode::kNudgeRange);
  }
}

}  // namespace
}  // namespace sinew
