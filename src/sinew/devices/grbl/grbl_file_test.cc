#include "sinew/devices/grbl/grbl_file.h"

#include <gtest/gtest.h>

#include <string>

#include "sinew/config/robot_file.h"
#include "sinew/devices/grbl/grbl_settings.h"

namespace sinew {
namespace {

std::string file(const std::string& device, const std::string& joints) {
  return "id = \"x\"\ntitle = \"x\"\nsource = \"x\"\njoint = [\n"
         "  { name = \"a\", lower_deg = -90, upper_deg = 90, velocity_deg_s_max = 60 },\n"
         "  { name = \"b\", lower_deg = -90, upper_deg = 90, velocity_deg_s_max = 60 },\n]\n"
         "[geometry]\nkind = \"serial\"\ndh = [\n"
         "  { theta_offset_deg = 0, d_mm = 100, a_mm = 100, alpha_deg = 0 },\n"
         "  { theta_offset_deg = 0, d_mm = 0, a_mm = 100, alpha_deg = 0 },\n]\n"
         "[device]\nprotocol = \"grbl\"\nmotion = \"stream\"\nfeedback = \"commanded\"\n"
         "baud = 115200\nsegment_ms = 50\n" +
         device + joints;
}

const std::string kJoints =
    "joint.a = { steps_per_deg = 100, machine_zero_deg = 30, homing_end = \"upper\" }\n"
    "joint.b = { steps_per_deg = -100 }\n";

TEST(GrblFile, reads_what_ties_the_board_to_the_joints) {
  const auto model = read_robot(file("homing = \"yes\"\n", kJoints), "x.toml");
  ASSERT_TRUE(model) << to_text(model.error()[0]);
  const auto& device = model->device.settings.get<GrblDevice>();
  EXPECT_TRUE(device.homes);
  EXPECT_NEAR(device.axes[0].zero, from_deg(30), 1e-12);
  EXPECT_FALSE(device.axes[0].homes_down);
  EXPECT_NEAR(device.axes[1].steps_per_unit, -100, 1e-6);
  EXPECT_TRUE(device.searches_zeros());
  EXPECT_FALSE(device.counts_from_power_up());
}

TEST(GrblFile, complains_about_what_is_missing_or_cannot_be) {
  EXPECT_FALSE(read_robot(file("", kJoints), "x.toml"));
  EXPECT_FALSE(read_robot(file("homing = \"perhaps\"\n", kJoints), "x.toml"));
  EXPECT_FALSE(
      read_robot(file("homing = \"no\"\n", "joint.a = { steps_per_deg = 100 }\n"), "x.toml"));
  EXPECT_FALSE(read_robot(file("homing = \"no\"\n",
                               "joint.a = { steps_per_deg = 0.001 }\n"
                               "joint.b = { steps_per_deg = 1 }\n"),
                          "x.toml"));
}

TEST(GrblFile, a_joint_turns_the_other_way_round_by_a_setting) {
  auto model = read_robot(file("homing = \"no\"\n", kJoints), "x.toml");
  ASSERT_TRUE(model);
  auto& settings = *model->device.settings.operator->();
  EXPECT_TRUE(settings.use_setting({"turn", 0, "other"}, model->device));
  EXPECT_LT(model->device.settings.get<GrblDevice>().axes[0].steps_per_unit, 0);
  EXPECT_FALSE(settings.use_setting({"offset", 0, "other"}, model->device));
}

}  // namespace
}  // namespace sinew
