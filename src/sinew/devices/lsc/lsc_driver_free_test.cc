#include <gtest/gtest.h>

#include "sinew/core/error_code.h"
#include "sinew/devices/lsc/lsc_test_cell.h"

namespace sinew::test {
namespace {

using Kind = DriverEvent::Kind;

TEST(LscFreeDrive, a_bus_arm_is_led_by_hand_and_held_where_it_was_left) {
  LscCell cell(LscProfile::kBus);
  cell.start({0.2, 0, 0, 0, 0});
  ASSERT_TRUE(cell.driver.service(DeviceService::kFree, cell.now));
  ASSERT_TRUE(cell.run_until(Kind::kDone));
  EXPECT_TRUE(cell.driver.free());
  cell.machine.disturb({sim::Disturbance::Kind::kLoad, 0, 0.2});
  for (int i = 0; i < 200; ++i) {
    cell.run_for(5ms);
    const auto truth = cell.machine.truth();
    for (std::size_t j = 0; j < 5; ++j) {
      const JointPosition& claim = cell.driver.positions()[j];
      ASSERT_GE(truth.joints[j].q, claim.lower - 1e-9) << j << " at " << i;
      ASSERT_LE(truth.joints[j].q, claim.upper + 1e-9) << j << " at " << i;
    }
  }
  EXPECT_GT(cell.machine.truth().joints[0].q, 0.4) << "pushed";
  cell.machine.disturb({sim::Disturbance::Kind::kLoad, 0, 0});
  cell.run_for(500ms);
  std::array<double, 5> there{};
  for (std::size_t j = 0; j < 5; ++j) {
    there[j] = cell.machine.truth().joints[j].q;
    EXPECT_EQ(cell.driver.positions()[j].quality, PositionQuality::kMeasured);
    EXPECT_NEAR(cell.driver.positions()[j].q, there[j], 0.01);
  }
  cell.events.clear();
  ASSERT_TRUE(cell.driver.service(DeviceService::kHold, cell.now));
  ASSERT_TRUE(cell.run_until(Kind::kDone));
  EXPECT_FALSE(cell.driver.free());
  cell.run_for(1s);
  EXPECT_LT(cell.worst(there), kLscSag);
}

TEST(LscFreeDrive, a_motion_ends_it_and_a_stop_of_nothing_leaves_it) {
  LscCell cell(LscProfile::kBus);
  cell.start(kLscHere);
  ASSERT_TRUE(cell.driver.service(DeviceService::kFree, cell.now));
  ASSERT_TRUE(cell.run_until(Kind::kDone));
  cell.run_for(1s);
  cell.driver.stop(cell.now);
  EXPECT_TRUE(cell.run_until(Kind::kStopped));
  EXPECT_TRUE(cell.driver.free());
  cell.stream({0.1, 0.1, 0.1, 0.1, 0}, 4s);
  EXPECT_FALSE(cell.driver.free());
  EXPECT_LT(cell.worst({0.1, 0.1, 0.1, 0.1, 0}), kLscSag);
}

TEST(LscFreeDrive, jaws_and_a_port_that_comes_back_leave_it_free_and_hold_takes_it_where_it_is) {
  for (const bool reopens : {false, true}) {
    LscCell cell(LscProfile::kBus);
    cell.start({0.2, 0, 0, 0, 0});
    ASSERT_TRUE(cell.driver.service(DeviceService::kFree, cell.now));
    ASSERT_TRUE(cell.run_until(Kind::kDone));
    cell.events.clear();
    if (reopens) {
      cell.driver.close(cell.now);
      cell.driver.open(cell.now);
      ASSERT_TRUE(cell.run_until(Kind::kReady));
    } else {
      ASSERT_TRUE(cell.driver.tool(JawsTo{0.03}, cell.now));
      ASSERT_TRUE(cell.run_until(Kind::kDone));
    }
    EXPECT_TRUE(cell.driver.free());
    cell.machine.disturb({sim::Disturbance::Kind::kLoad, 0, 0.2});
    cell.run_for(1s);
    cell.machine.disturb({sim::Disturbance::Kind::kLoad, 0, 0});
    cell.run_for(500ms);
    const double led = cell.machine.truth().joints[0].q;
    EXPECT_GT(led, 1);
    EXPECT_NEAR(cell.driver.positions()[0].q, led, 0.01);
    cell.events.clear();
    ASSERT_TRUE(cell.driver.service(DeviceService::kHold, cell.now));
    ASSERT_TRUE(cell.run_until(Kind::kDone));
    EXPECT_NEAR(cell.machine.truth().joints[0].q, led, kLscSag);
  }
}

TEST(LscFreeDrive, claims_hold_while_jaws_move_and_a_stopped_hold_leaves_it_free) {
  for (int k = 0; k < 20; ++k) {
    LscCell cell(LscProfile::kBus);
    cell.start({0.2, 0, 0, 0, 0});
    ASSERT_TRUE(cell.driver.service(DeviceService::kFree, cell.now));
    ASSERT_TRUE(cell.run_until(Kind::kDone));
    cell.run_for(std::chrono::milliseconds(7 * k));
    cell.events.clear();
    if (k % 2 == 0) {
      ASSERT_TRUE(cell.driver.tool(JawsTo{0.03}, cell.now));
    } else if (cell.driver.service(DeviceService::kHold, cell.now)) {
      cell.driver.stop(cell.now);
    }
    cell.run_for(20ms);
    if (!cell.driver.free()) continue;  // its frame had left
    cell.machine.disturb({sim::Disturbance::Kind::kLoad, 0, 0.2});
    for (int i = 0; i < 300; ++i) {
      cell.run_for(5ms);
      const JointPosition& claim = cell.driver.positions()[0];
      ASSERT_GE(cell.machine.truth().joints[0].q, claim.lower - 1e-9) << k << " at " << i;
      ASSERT_LE(cell.machine.truth().joints[0].q, claim.upper + 1e-9) << k << " at " << i;
    }
  }
}

TEST(LscFreeDrive, boards_that_measure_nothing_have_none) {
  for (const LscProfile profile : {LscProfile::kLsc6, LscProfile::kEsp32}) {
    LscCell cell(profile);
    cell.start();
    const auto refused = cell.driver.service(DeviceService::kFree, cell.now);
    EXPECT_EQ(refusal(refused), ErrorCode::kNoSuchService);
  }
}

}  // namespace
}  // namespace sinew::test
