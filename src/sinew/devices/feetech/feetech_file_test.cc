#include <gtest/gtest.h>

#include <fstream>
#include <iterator>
#include <regex>
#include <string>

#include "sinew/config/robot_file.h"
#include "sinew/devices/feetech/feetech_settings.h"

namespace sinew {
namespace {

std::string example() {
  std::ifstream file(std::string(SINEW_ROBOTS_DIR) + "/examples/so-101-feetech.toml");
  return {std::istreambuf_iterator<char>(file), {}};
}

/// What is wrong with the example where a part of it is another one.
std::string trouble_with(const std::string& from, const std::string& to) {
  std::string text = example();
  const std::size_t at = text.find(from);
  EXPECT_NE(at, std::string::npos) << from;
  text.replace(at, from.size(), to);
  const auto read = read_robot(text, "r.toml");
  if (read) return {};
  std::string all;
  for (const Complaint& one : read.error()) all += one.key + ": " + one.message + "\n";
  return all;
}

TEST(FeetechFile, the_example_is_read) {
  const auto robot = read_robot(example(), "r.toml");
  ASSERT_TRUE(robot);
  const auto& device = robot->device.settings.get<FeetechDevice>();
  EXPECT_EQ(device.series, FeetechSeries::kSts);
  EXPECT_EQ(device.servos[4].id, 5);
  EXPECT_EQ(device.servos[0].sign, -1);
  EXPECT_EQ(device.servos[1].sign, 1);
  EXPECT_EQ(device.gripper.torque_limit, 0.5);
  EXPECT_TRUE(robot->device.capability.free_drive);
  EXPECT_NEAR(device.q_of(0, device.units_of(0, 0.7)), 0.7, 1e-12);
}

TEST(FeetechFile, what_cannot_be_is_told) {
  EXPECT_NE(
      trouble_with("servo_id = 2", "servo_id = 3").find("servo 3 would be elbow's and lift's"),
      std::string::npos);
  EXPECT_NE(trouble_with("servo_id = 2", "servo_id = 6").find("the gripper's"), std::string::npos);
  EXPECT_NE(trouble_with("servo_id = 2", "servo_id = 254").find("servo_id"), std::string::npos);
  EXPECT_NE(trouble_with("servo_id = 5, centre = 2048", "servo_id = 5, centre = 300")
                .find("the range of roll would be"),
            std::string::npos);
  EXPECT_NE(trouble_with("series = \"sts\"", "series = \"scs\"").find("only STS servos"),
            std::string::npos);
  EXPECT_NE(trouble_with("series = \"sts\"", "series = \"sms\"").find("series"), std::string::npos);
  EXPECT_NE(trouble_with("open = 3200", "open = 2030").find("must differ"), std::string::npos);
  EXPECT_NE(trouble_with("torque_limit_percent = 50", "torque_limit_percent = 0")
                .find("torque_limit_percent"),
            std::string::npos);
}

TEST(FeetechFile, an_arm_without_jaws_needs_no_gripper) {
  std::string text = example();
  text = std::regex_replace(text, std::regex("gripper     = .*\n"), "");
  const auto robot = read_robot(text, "r.toml");
  ASSERT_TRUE(robot);
  EXPECT_EQ(robot->device.capability.hand, HandDrive::kNone);
}

}  // namespace
}  // namespace sinew
