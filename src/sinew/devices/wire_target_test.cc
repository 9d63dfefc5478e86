#include "sinew/driver/wire_target.h"

#include <gtest/gtest.h>

#include <cmath>

#include "sinew/core/error_code.h"
#include "sinew/core/units.h"
#include "sinew/devices/bigrobotarm/bigrobotarm_driver_channel.h"
#include "sinew/devices/bigrobotarm/bigrobotarm_settings.h"
#include "sinew/devices/lsc/lsc_settings.h"
#include "support/property.h"
#include "support/robots.h"

namespace sinew {
namespace {

JointVector home_of(const RobotModel& robot) {
  JointVector q;
  for (const Joint& joint : robot.joints) q.push_back(joint.home);
  return q;
}

std::optional<Error> refusal(const RobotModel& robot, const JointVector& q) {
  return WireTarget(robot).refusal({q.data(), q.size()});
}

TEST(WireTarget, home_of_every_robot_can_be_said) {
  for (const char* id : {"robot-arm-2", "learm", "bigrobotarm", "maxarm", "hexapod", "puma560"}) {
    const RobotModel robot = test::robot(id);
    EXPECT_FALSE(refusal(robot, home_of(robot))) << id;
  }
}

TEST(WireTarget, steps_with_the_terminator_inside_are_refused_on_the_byte_wire_only) {
  RobotModel robot = test::robot("bigrobotarm");
  JointVector q = home_of(robot);
  q[0] = from_deg(48);  // step 3467, 0D8B
  const auto error = refusal(robot, q);
  ASSERT_TRUE(error);
  EXPECT_EQ(error->code, ErrorCode::kUnsendable);
  EXPECT_EQ(error->index, 0);
  EXPECT_EQ(error->measured, 3467);
  const auto near = WireTarget(robot).nearest({q.data(), q.size()});
  ASSERT_TRUE(near);
  const double steps = robot.device.settings.get<BigRobotArmDevice>().joints[0].steps_per_rad;
  // 3329..3582 cannot be said; their ends' neighbours can, and round to what can.
  EXPECT_NEAR((*near)[0] * steps, 3583, 1.5);
  EXPECT_FALSE(refusal(robot, *near));
  for (std::size_t j = 1; j < q.size(); ++j) EXPECT_EQ((*near)[j], q[j]);
  robot.device.settings.get<BigRobotArmDevice>().wire = BigRobotArmWire::kText;
  EXPECT_FALSE(refusal(robot, q));
}

TEST(WireTarget, servo_of_the_maxarm_is_never_sent_to_pulse_zero) {
  const RobotModel robot = test::robot("maxarm");
  int refused = 0;
  for (std::size_t j = 0; j < robot.joints.size(); ++j) {
    for (const double end : {robot.joints[j].lower, robot.joints[j].upper}) {
      JointVector q = home_of(robot);
      q[j] = end;
      const auto error = refusal(robot, q);
      if (!error) continue;
      ++refused;
      EXPECT_EQ(error->code, ErrorCode::kPulseRange);
      EXPECT_EQ(error->index, static_cast<int>(j));
      const auto near = WireTarget(robot).nearest({q.data(), q.size()});
      ASSERT_TRUE(near);
      EXPECT_FALSE(refusal(robot, *near));
      EXPECT_LT(std::abs((*near)[j] - end), from_deg(0.5)) << "two pulses";
      EXPECT_TRUE(within_limits(robot.joints[j], (*near)[j]));
    }
  }
  EXPECT_GE(refused, 1);
}

TEST(WireTarget, pulses_that_a_servo_board_may_not_send_are_refused) {
  RobotModel robot = test::robot("learm");
  auto& servo = robot.device.settings.get<LscDevice>().servos[1];
  servo.upper = static_cast<std::int32_t>(servo.centre + servo.trim) + 100;
  servo.lower = static_cast<std::int32_t>(servo.centre + servo.trim) - 100;
  JointVector q = home_of(robot);
  q[1] = 300 / servo.units_per_rad;
  if (!within_limits(robot.joints[1], q[1])) q[1] = -q[1];
  const auto error = refusal(robot, q);
  ASSERT_TRUE(error);
  EXPECT_EQ(error->code, ErrorCode::kPulseRange);
  EXPECT_EQ(error->index, 1);
  const auto near = WireTarget(robot).nearest({q.data(), q.size()});
  ASSERT_TRUE(near);
  EXPECT_NEAR(std::abs((*near)[1] * servo.units_per_rad), 100, 1);
}

/// What counts as sayable is what the driver then accepts, and nothing is refused beside it.
TEST(WireTarget, says_of_random_places_what_the_driver_says_when_it_is_sent_there) {
  const RobotModel robot = test::robot("bigrobotarm");
  const auto& device = robot.device.settings.get<BigRobotArmDevice>();
  BigRobotArmChannel channel(device);
  channel.open({});
  int refused = 0;
  test::for_random_cases(2000, [&](test::Random& random) {
    JointVector q;
    BigRobotArmAngles angles{};
    for (std::size_t j = 0; j < kBigRobotArmJoints; ++j) {
      q.push_back(random.uniform(robot.joints[j].lower, robot.joints[j].upper));
      angles[j] = q[j];
    }
    const auto asked = channel.move_to(angles, {}, {});
    ASSERT_FALSE(asked) << "it is still opening";
    const auto error = refusal(robot, q);
    refused += error ? 1 : 0;
    // A place that it can say is turned down only for being busy.
    EXPECT_EQ(asked.error().code, error ? error->code : ErrorCode::kBusy);
    if (!error) return;
    const auto near = WireTarget(robot).nearest({q.data(), q.size()});
    ASSERT_TRUE(near);
    EXPECT_FALSE(refusal(robot, *near));
  });
  EXPECT_GE(refused, 20);
}

}  // namespace
}  // namespace sinew
