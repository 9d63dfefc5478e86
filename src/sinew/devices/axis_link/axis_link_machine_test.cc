#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <iostream>
#include <optional>
#include <string>
#include <vector>

#include "sinew/devices/axis/axis_machine.h"
#include "sinew/devices/axis_link/axis_link_driver.h"
#include "sinew/devices/axis_link/axis_link_settings.h"
#include "sinew/devices/axis_registers/axis_registers_settings.h"
#include "support/property.h"
#include "support/robots.h"

// AxisLinkDriver against the whole simulated arm: motors, gears, encoders and controllers.

namespace sinew {
namespace {

using namespace std::chrono_literals;
using Kind = DriverEvent::Kind;

/// Close to the end stops, so that homing is short.
JointVector near_home(const RobotModel& model) {
  JointVector q;
  for (std::size_t i = 0; i < model.joints.size(); ++i) {
    const Joint& joint = model.joints[i];
    const bool upper = boards_of(model.device)[i].homing_direction > 0;
    q.push_back(upper ? joint.upper - from_deg(4) : joint.lower + from_deg(4));
  }
  return q;
}

struct ArmCell {
  explicit ArmCell(std::uint64_t seed = 5, const RobotModel& robot = test::robot("robot-arm-2"))
      : model(robot),
        arm(model, {.wire = sim::AxisWire::kLink, .seed = seed, .start = near_home(model)},
            Instant{}) {
    device.boards = model.device.settings.get<AxisRegistersDevice>().boards;
    driver.emplace(device, model.joints);
  }

  bool run_to(Kind kind, Duration limit) {
    for (const Instant end = now + limit; now < end;) {
      if (watch) watch();
      if (const auto transfer = driver->take_transfer(now)) {
        const auto miso = arm.exchange(*transfer, now);
        now += 50us + spi::wire_time(*transfer);
        if (jitter != nullptr) now += from_seconds(jitter->uniform(0, 0.4e-3));
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
  /// Largest distance (rad) between what positions() says and where the joints are.
  double worst_lie() const {
    double worst = 0;
    const sim::Truth truth = arm.truth();
    for (std::size_t i = 0; i < model.joints.size(); ++i) {
      EXPECT_EQ(driver->positions()[i].quality, PositionQuality::kMeasured);
      worst = std::max(worst, std::abs(driver->positions()[i].q - truth.joints[i].q));
    }
    return worst;
  }
  JointMove by(double angle, Duration duration) const {
    JointMove move{.q = {}, .qd = {}, .duration = duration};
    for (const JointPosition& position : driver->positions()) {
      move.q.push_back(position.q + angle);
      move.qd.push_back(0);
    }
    return move;
  }

  const RobotModel& model;
  sim::StepperArm arm;
  AxisLinkDevice device;
  std::optional<AxisLinkDriver> driver;
  Instant now{};
  DriverEvent last;
  std::function<void()> watch;
  test::Random* jitter = nullptr;  ///< a host that is not on time
};

TEST(AxisLinkArm, two_searches_for_a_zero_tell_how_far_they_lie_apart) {
  ArmCell cell;
  cell.driver->open(cell.now);
  ASSERT_TRUE(cell.run_to(Kind::kReady, 1s));
  ASSERT_TRUE(cell.driver->home(cell.now));
  ASSERT_TRUE(cell.run_to(Kind::kDone, 300s)) << describe(cell.last.error);
  for (std::size_t i = 0; i < 6; ++i) EXPECT_FALSE(cell.driver->zero_shift(i)) << "the first";
  ASSERT_TRUE(cell.driver->home(cell.now));
  ASSERT_TRUE(cell.run_to(Kind::kDone, 300s)) << describe(cell.last.error);
  for (std::size_t i = 0; i < 6; ++i) {
    ASSERT_TRUE(cell.driver->zero_shift(i)) << i;
    std::cout << "  joint " << i << ": " << to_deg(*cell.driver->zero_shift(i)) << " deg\n";
    // Nothing has moved the switches: what is left is counts, bounces and the play.
    EXPECT_NEAR(to_deg(*cell.driver->zero_shift(i)), 0, 0.1) << i;
  }
}

TEST(AxisLinkArm, a_board_that_browns_out_in_motion_is_lost_and_the_others_stop) {
  ArmCell cell;
  cell.driver->open(cell.now);
  ASSERT_TRUE(cell.run_to(Kind::kReady, 1s));
  ASSERT_TRUE(cell.driver->home(cell.now));
  ASSERT_TRUE(cell.run_to(Kind::kDone, 300s)) << describe(cell.last.error);
  ASSERT_TRUE(cell.driver->move(cell.by(from_deg(10), 6s), cell.now));
  EXPECT_FALSE(cell.run_to(Kind::kDone, 2s));
  cell.arm.disturb({sim::Disturbance::Kind::kSupply, 2, 5});
  EXPECT_FALSE(cell.run_to(Kind::kDone, 100ms));
  cell.arm.disturb({sim::Disturbance::Kind::kSupply, 2, 24});
  EXPECT_FALSE(cell.run_to(Kind::kDone, 6s));
  EXPECT_EQ(cell.driver->state(), DriverState::kFault);
  EXPECT_EQ(cell.driver->fault()->index, 2);
  EXPECT_EQ(cell.driver->positions()[2].quality, PositionQuality::kLost);
  EXPECT_EQ(cell.driver->positions()[1].quality, PositionQuality::kMeasured);
  const sim::Truth stopped = cell.arm.truth();
  EXPECT_FALSE(cell.run_to(Kind::kDone, 500ms));
  for (std::size_t i = 0; i < 6; ++i) {
    EXPECT_NEAR(to_deg(cell.arm.truth().joints[i].q - stopped.joints[i].q), 0, 0.1) << i;
  }
}

std::string model_joint(const ArmCell& cell, std::size_t joint) {
  return cell.model.joints[joint].name + " at " + std::to_string(to_seconds(cell.now - Instant{}));
}

/// A move of every joint to a place inside its limits, as fast as a cubic may be there.
JointMove random_move(const RobotModel& model, const std::vector<double>& from,
                      test::Random& random) {
  JointMove move;
  double seconds = 0.5;
  for (std::size_t i = 0; i < model.joints.size(); ++i) {
    const Joint& joint = model.joints[i];
    const double way = random.uniform(-from_deg(25), from_deg(25));
    const double q = std::clamp(from[i] + way, joint.lower + from_deg(1), joint.upper);
    // A cubic from rest to rest peaks at 1.5 of its mean speed and begins with 6 of its
    // acceleration; and its jerk jumps, which the axis smooths.
    const double distance = std::abs(q - from[i]);
    seconds = std::max({seconds, 1.6 * distance / joint.velocity_max,
                        1.1 * std::sqrt(6 * distance / joint.acceleration_max)});
    move.q.push_back(q);
    move.qd.push_back(0);
  }
  move.duration = from_seconds(seconds);
  return move;
}

TEST(AxisLinkArm, what_is_measured_holds_the_joint_itself_under_load) {
  double worst = 0;
  test::for_random_cases(3, [&](test::Random& random) {
    ArmCell cell(static_cast<std::uint64_t>(random.integer(1, 1000)));
    cell.jitter = &random;
    cell.arm.disturb({sim::Disturbance::Kind::kPayload, -1, 0.5});
    cell.driver->open(cell.now);
    ASSERT_TRUE(cell.run_to(Kind::kReady, 1s));
    ASSERT_TRUE(cell.driver->home(cell.now));
    ASSERT_TRUE(cell.run_to(Kind::kDone, 300s)) << describe(cell.last.error);
    std::vector<double> from;
    for (const JointPosition& position : cell.driver->positions()) from.push_back(position.q);
    std::vector<double> to = from;
    int looks = 0;
    cell.watch = [&] {
      if (++looks % 20 != 0) return;
      const sim::Truth truth = cell.arm.truth();
      for (std::size_t i = 0; i < truth.joints.size(); ++i) {
        const JointPosition& claim = cell.driver->positions()[i];
        const double q = truth.joints[i].q;
        ASSERT_EQ(claim.quality, PositionQuality::kMeasured);
        ASSERT_GE(q, claim.lower) << model_joint(cell, i);
        ASSERT_LE(q, claim.upper) << model_joint(cell, i);
        worst = std::max(worst, std::abs(q - claim.q));
        // Not past the ends of its way by more than that either, whatever the host's rhythm.
        const double most = claim.upper - claim.q;
        ASSERT_GE(q, std::min(from[i], to[i]) - most) << model_joint(cell, i);
        ASSERT_LE(q, std::max(from[i], to[i]) + most) << model_joint(cell, i);
      }
    };
    for (int i = 0; i < 6; ++i) {
      const JointMove move = random_move(cell.model, from, random);
      for (std::size_t k = 0; k < to.size(); ++k) to[k] = move.q[k];
      ASSERT_TRUE(cell.driver->move(move, cell.now));
      ASSERT_TRUE(cell.run_to(Kind::kDone, move.duration + 2s)) << describe(cell.last.error);
      from = to;
    }
  });
  // More than a count of the joint's encoder by far: play and give are no small print.
  EXPECT_GT(worst, 2 * kPi / 4096);
}

TEST(AxisLinkArm, homes_moves_and_stops_the_simulated_arm) {
  ArmCell cell;
  cell.driver->open(cell.now);
  ASSERT_TRUE(cell.run_to(Kind::kReady, 1s));
  ASSERT_TRUE(cell.driver->home(cell.now));
  ASSERT_TRUE(cell.run_to(Kind::kDone, 300s)) << describe(cell.last.error);
  EXPECT_LT(to_deg(cell.worst_lie()), 0.5);
  const sim::Truth home = cell.arm.truth();
  ASSERT_TRUE(cell.driver->move(cell.by(from_deg(5), 4s), cell.now));
  ASSERT_TRUE(cell.run_to(Kind::kDone, 8s)) << describe(cell.last.error);
  const sim::Truth there = cell.arm.truth();
  for (std::size_t i = 0; i < 6; ++i) {
    EXPECT_NEAR(to_deg(there.joints[i].q - home.joints[i].q), 5, 0.5) << i;
    EXPECT_FALSE(there.joints[i].lost_steps) << i;
  }
  EXPECT_LT(to_deg(cell.worst_lie()), 0.5);
  ASSERT_TRUE(cell.driver->move(cell.by(from_deg(5), 4s), cell.now));
  EXPECT_FALSE(cell.run_to(Kind::kDone, 2s));
  cell.driver->stop(cell.now);
  ASSERT_TRUE(cell.run_to(Kind::kStopped, 8s));
  const sim::Truth stopped = cell.arm.truth();
  EXPECT_FALSE(cell.run_to(Kind::kDone, 500ms));
  for (std::size_t i = 0; i < 6; ++i) {
    // What the windup of the gears gives back; half way, it went at 2 deg/s.
    EXPECT_NEAR(to_deg(cell.arm.truth().joints[i].q - stopped.joints[i].q), 0, 0.1) << i;
  }
  EXPECT_LT(to_deg(cell.worst_lie()), 0.5);
  EXPECT_EQ(cell.driver->state(), DriverState::kReady);
}

/// Some switches at the upper ends, and an order of its own, as the robot's file may say.
TEST(AxisLinkArm, homes_in_the_order_and_to_the_ends_that_its_file_says) {
  RobotModel model = test::robot("robot-arm-2");
  AxisBoards& boards = model.device.settings.get<AxisRegistersDevice>().boards;
  const std::vector<std::size_t> wanted{1, 2, 0, 5, 4, 3};
  for (std::size_t k = 0; k < wanted.size(); ++k) {
    boards[wanted[k]].homing_place = static_cast<std::uint8_t>(k + 1);
  }
  for (const std::size_t joint : {1, 3, 5}) boards[joint].homing_direction = 1;
  ArmCell cell(5, model);
  std::vector<std::size_t> order;
  cell.watch = [&] {
    const auto joint = cell.driver->homing_joint();
    if (joint && (order.empty() || order.back() != *joint)) order.push_back(*joint);
  };
  cell.driver->open(cell.now);
  ASSERT_TRUE(cell.run_to(Kind::kReady, 1s));
  ASSERT_TRUE(cell.driver->home(cell.now));
  ASSERT_TRUE(cell.run_to(Kind::kDone, 300s)) << describe(cell.last.error);
  EXPECT_EQ(order, wanted);
  EXPECT_LT(to_deg(cell.worst_lie()), 0.5);
  for (std::size_t i = 0; i < model.joints.size(); ++i) {
    const double q = cell.arm.truth().joints[i].q;
    const bool upper = boards[i].homing_direction > 0;
    EXPECT_NEAR(to_deg(upper ? model.joints[i].upper - q : q - model.joints[i].lower), 0, 5) << i;
    EXPECT_GE(q, model.joints[i].lower) << i;
    EXPECT_LE(q, model.joints[i].upper) << i;
  }
}

}  // namespace
}  // namespace sinew
