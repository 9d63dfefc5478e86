#include "sinew/devices/arm_link/arm_link_file.h"

#include <gtest/gtest.h>

#include <fstream>
#include <iterator>
#include <regex>
#include <string>

#include "sinew/config/robot_file.h"
#include "sinew/devices/arm_link/arm_link_settings.h"

namespace sinew {
namespace {

/// The BigRobotArm's own file, with another table [device].
std::string file(int deadline_ms, int gripper_max, const std::string& more = {}) {
  std::ifstream stream(SINEW_ROBOTS_DIR "/bigrobotarm.toml");
  std::string text(std::istreambuf_iterator<char>(stream), {});
  text = std::regex_replace(text, std::regex("\\n  multiplier_boot[^\\n]*"), "");
  const auto begin = text.find("protocol = \"bigrobotarm\"");
  const auto end = text.find("source = { baud");
  return text.substr(0, begin) +
         "protocol = \"arm_link\"\nmotion = \"stream\"\nfeedback = \"commanded\"\nbaud = 250000\n"
         "segment_ms = 20\n" +
         "deadline_ms = " + std::to_string(deadline_ms) +
         "\ngripper_max = " + std::to_string(gripper_max) + "\nnudge_deg_max = 2\n" + more +
         text.substr(end);
}

TEST(ArmLinkFile, reads_what_the_board_is_told) {
  const auto model = read_robot(file(300, 120), "x.toml");
  ASSERT_TRUE(model) << to_text(model.error()[0]);
  const auto& device = model->device.settings.get<ArmLinkDevice>();
  EXPECT_EQ(device.deadline, std::chrono::milliseconds(300));
  EXPECT_EQ(device.arm.gripper_max, 120);
  EXPECT_NEAR(device.arm.joints[0].steps_per_rad, 26000 / (2 * kPi), 1e-6);
  EXPECT_EQ(device.arm.joints[1].steps_per_motor_rev, 400);
  EXPECT_EQ(model->device.capability.motion, MotionKind::kStream);
  EXPECT_EQ(model->device.capability.segment, std::chrono::milliseconds(20));
}

TEST(ArmLinkFile, complains_about_what_the_board_cannot_be_told) {
  EXPECT_TRUE(read_robot(file(20, 180), "x.toml"));
  EXPECT_FALSE(read_robot(file(19, 180), "x.toml"));
  EXPECT_FALSE(read_robot(file(501, 180), "x.toml"));
  EXPECT_FALSE(read_robot(file(200, 181), "x.toml"));
  EXPECT_FALSE(read_robot(file(200, 180, "multiplier_max = 300\n"), "x.toml"));
  // The board's slices are 1 ms, and its port carries a segment each 10 ms.
  for (const auto& [segment, fine] : {std::pair("9", false), std::pair("10", true)}) {
    const std::string text = std::regex_replace(file(200, 180), std::regex("segment_ms = 20"),
                                                "segment_ms = " + std::string(segment));
    EXPECT_EQ(read_robot(text, "x.toml").has_value(), fine) << segment;
  }
}

}  // namespace
}  // namespace sinew
