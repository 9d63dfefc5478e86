#include "firmware/emulation/emulated_arm.h"

#include <gtest/gtest.h>

#include <cmath>

#include "sinew/devices/axis_link/axis_link_driver.h"
#include "sinew/devices/axis_link/axis_link_settings.h"
#include "sinew/devices/axis_registers/axis_registers_settings.h"
#include "support/robots.h"

// The host's driver against six boards that run the image.

namespace sinew::emulation {
namespace {

using namespace std::chrono_literals;
using Kind = DriverEvent::Kind;

struct ArmCell {
  explicit ArmCell(Stm32Chip chip)
      : model(test::robot("robot-arm-2")), arm(chip, model, near_home(model), 5) {
    AxisLinkDevice device;
    device.boards = model.device.settings.get<AxisRegistersDevice>().boards;
    driver.emplace(device, model.joints);
  }
  /// Close to the end stops, so that homing is short.
  static JointVector near_home(const RobotModel& model) {
    JointVector q;
    for (std::size_t i = 0; i < model.joints.size(); ++i) {
      const Joint& joint = model.joints[i];
      const bool upper = boards_of(model.device)[i].homing_direction > 0;
      q.push_back(upper ? joint.upper - from_deg(3) : joint.lower + from_deg(3));
    }
    return q;
  }
  bool run_to(Kind kind, Duration limit) {
    for (const Instant end = now + limit; now < end && !arm.broken();) {
      if (const auto transfer = driver->take_transfer(now)) {
        const auto miso = arm.exchange(*transfer, now);
        now += 50us + spi::wire_time(*transfer);
        driver->exchanged(miso, now);
      } else {
        now = std::max(now + 10us, driver->next_deadline().value_or(end));
        arm.advance(now);
        driver->poll(now);
      }
      while (const auto event = driver->take_event()) {
        last = *event;
        if (event->kind == kind) return true;
        if (event->kind == Kind::kFailed) return false;
      }
    }
    return false;
  }

  const RobotModel& model;
  EmulatedArm arm;
  std::optional<AxisLinkDriver> driver;
  Instant now{};
  DriverEvent last;
};

TEST(EmulatedArm, is_homed_moved_and_stopped_by_the_driver) {
  ArmCell cell(Stm32Chip::kF401);
  cell.arm.advance(cell.now += 100ms);
  cell.driver->open(cell.now);
  ASSERT_TRUE(cell.run_to(Kind::kReady, 1s)) << describe(cell.last.error);
  ASSERT_TRUE(cell.driver->home(cell.now));
  ASSERT_TRUE(cell.run_to(Kind::kDone, 300s))
      << describe(cell.last.error) << cell.arm.broken().value_or("");
  JointMove move{.q = {}, .qd = {}, .duration = 4s};
  const sim::Truth home = cell.arm.truth();
  for (std::size_t i = 0; i < 6; ++i) {
    const JointPosition& claim = cell.driver->positions()[i];
    EXPECT_EQ(claim.quality, PositionQuality::kMeasured);
    EXPECT_GE(home.joints[i].q, claim.lower) << i;
    EXPECT_LE(home.joints[i].q, claim.upper) << i;
    move.q.push_back(claim.q + from_deg(5));
    move.qd.push_back(0);
  }
  ASSERT_TRUE(cell.driver->move(move, cell.now));
  ASSERT_TRUE(cell.run_to(Kind::kDone, 8s)) << describe(cell.last.error);
  const sim::Truth there = cell.arm.truth();
  for (std::size_t i = 0; i < 6; ++i) {
    EXPECT_NEAR(to_deg(there.joints[i].q - home.joints[i].q), 5, 0.3) << i;
    EXPECT_FALSE(there.joints[i].lost_steps) << i;
    move.q[i] += from_deg(5);
  }
  ASSERT_TRUE(cell.driver->move(move, cell.now));
  EXPECT_FALSE(cell.run_to(Kind::kDone, 2s));
  cell.driver->stop(cell.now);
  ASSERT_TRUE(cell.run_to(Kind::kStopped, 8s));
  const sim::Truth stopped = cell.arm.truth();
  EXPECT_FALSE(cell.run_to(Kind::kDone, 500ms));
  for (std::size_t i = 0; i < 6; ++i) {
    EXPECT_NEAR(to_deg(cell.arm.truth().joints[i].q - stopped.joints[i].q), 0, 0.1) << i;
  }
  EXPECT_EQ(cell.driver->state(), DriverState::kReady);
  std::printf("  %.1f s\n", to_seconds(cell.now - Instant{}));
}

}  // namespace
}  // namespace sinew::emulation
