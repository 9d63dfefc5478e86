#include "sinew/config/builtin_robots.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <set>

#include "sinew/config/robot_file.h"
#include "sinew/core/units.h"
#include "sinew/devices/bigrobotarm/bigrobotarm_settings.h"
#include "support/robot_promises.h"
#include "support/robots.h"

namespace sinew {
namespace {

using test::broken_promise;
using test::robot;

TEST(BuiltinRobots, six_files_are_carried_sorted_by_id) {
  std::vector<std::string_view> ids;
  for (const BuiltinRobot& builtin : builtin_robots()) ids.push_back(builtin.id);
  EXPECT_EQ(ids, (std::vector<std::string_view>{"bigrobotarm", "hexapod", "learm", "maxarm",
                                                "puma560", "robot-arm-2"}));
}

TEST(BuiltinRobots, every_file_reads_without_complaint_and_keeps_the_promises_of_the_model) {
  for (const BuiltinRobot& builtin : builtin_robots()) {
    const auto model = read_robot(builtin.text, builtin.file_name);
    ASSERT_TRUE(model.has_value()) << to_text(model.error().front());
    EXPECT_EQ(model->id, builtin.id);
    EXPECT_EQ(builtin.file_name, "robots/" + std::string(builtin.id) + ".toml");
    EXPECT_EQ(broken_promise(*model), "") << builtin.id;
  }
}

TEST(BuiltinRobots, every_number_of_every_file_says_where_it_comes_from) {
  for (const BuiltinRobot& builtin : builtin_robots()) {
    const auto file = read_robot_file(builtin.text, builtin.file_name);
    ASSERT_TRUE(file.has_value());
    std::set<std::string> keys;
    for (const Provenance& provenance : file->sources) {
      EXPECT_FALSE(provenance.source.empty()) << provenance.key;
      EXPECT_TRUE(keys.insert(provenance.key).second) << provenance.key << " has two sources";
    }
    for (const Joint& joint : file->model.joints) {
      const std::string unit = joint.kind == JointKind::kRevolute ? "deg" : "mm";
      EXPECT_TRUE(keys.contains("joint." + joint.name + ".upper_" + unit)) << builtin.id;
    }
  }
}

TEST(BuiltinRobots, sources_name_the_doubt_about_the_forearm_of_learm) {
  const BuiltinRobot& learm = builtin_robots()[2];
  const auto file = read_robot_file(learm.text, learm.file_name);
  ASSERT_TRUE(file.has_value());
  const auto found = std::ranges::find(file->sources, "geometry.dh[3].a_mm", &Provenance::key);
  ASSERT_NE(found, file->sources.end());
  EXPECT_EQ(found->source, "the arm's document says 98, others measure 88 to 90");
}

TEST(BuiltinRobots, bigrobotarm_carries_what_its_firmware_counts) {
  const RobotModel& model = robot("bigrobotarm");
  EXPECT_EQ(model.device.protocol, "bigrobotarm");
  EXPECT_EQ(model.device.baud, 250000U);
  EXPECT_EQ(model.device.capability.motion, MotionKind::kPointToPoint);
  EXPECT_EQ(model.device.capability.feedback, PositionFeedback::kCommanded);
  const auto& device = model.device.settings.get<BigRobotArmDevice>();
  EXPECT_EQ(device.wire, BigRobotArmWire::kByte);
  EXPECT_EQ(device.multiplier_max, 300);
  EXPECT_EQ(device.gripper_max, 180);
  constexpr double kStepsPerQuarter[] = {6500, -2500, -10000, -2000, 3000};
  constexpr double kStepsPerRev[] = {3200, 400, 3200, 3200, 3200};
  constexpr double kUserInterfaceSteps[] = {6500, 2500, 14000, 2000, 3000};
  for (std::size_t i = 0; i < kBigRobotArmJoints; ++i) {
    const BigRobotArmJoint& joint = device.joints[i];
    EXPECT_NEAR(joint.steps_per_rad * kPi / 2, kStepsPerQuarter[i], 1e-9);
    EXPECT_EQ(joint.steps_per_motor_rev, kStepsPerRev[i]);
    EXPECT_EQ(joint.multiplier_boot, i == 0 ? 200 : 100);
    EXPECT_NEAR(model.joints[i].upper * std::abs(joint.steps_per_rad), kUserInterfaceSteps[i],
                1e-9);
    const double boot_speed =
        joint.steps_per_motor_rev * joint.multiplier_boot / 100 / std::abs(joint.steps_per_rad);
    EXPECT_LE(model.joints[i].velocity_max, boot_speed * (1 + 1e-12));
    EXPECT_GT(model.joints[i].velocity_max, 0.99 * boot_speed);
  }
}

TEST(BuiltinRobots, learm_and_bigrobotarm_prefer_straight_down) {
  EXPECT_DOUBLE_EQ(std::get<SerialGeometry>(robot("learm").geometry).pitch_preferred, kPi);
  EXPECT_DOUBLE_EQ(std::get<SerialGeometry>(robot("bigrobotarm").geometry).pitch_preferred, kPi);
}

TEST(BuiltinRobots, hexapod_legs_share_what_the_wire_carries) {
  constexpr double kMovesPerSecond = 9600.0 / 10 / 4;  // a microstep is 4 bytes of 10 bits
  constexpr double kMicrostep = 0.7e-3 / 3200;         // m
  const double carried = robot("hexapod").device.capability.shared_velocity;
  EXPECT_NEAR(carried, kMovesPerSecond * kMicrostep, 1e-12);
  EXPECT_TRUE(std::isinf(robot("learm").device.capability.shared_velocity));
  for (const Joint& leg : robot("hexapod").joints) {
    EXPECT_EQ(leg.kind, JointKind::kPrismatic);
    EXPECT_EQ(leg.velocity_max, carried) << "its motor could do more than the wire carries";
    EXPECT_DOUBLE_EQ(leg.lower, 0.195);
    EXPECT_DOUBLE_EQ(leg.upper, 0.345);
  }
}

}  // namespace
}  // namespace sinew
