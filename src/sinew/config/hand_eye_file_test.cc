#include "sinew/config/hand_eye_file.h"

#include <gtest/gtest.h>

#include "sinew/core/rotation.h"
#include "sinew/core/units.h"

namespace sinew {
namespace {

HandEyeFile some_file() {
  HandEyeFile file{.on_arm = true, .robot = "learm", .lens = "arm", .target = "sheet"};
  file.X_MC = {rotation_from_vector({0.1, 1.2, -0.4}), {0.03, -0.05, 0.01}};
  file.X_NB = {rotation_z(1), {0.2, 0, 0}};
  file.joint_zeros = {{"base", from_deg(0.5)}, {"elbow", from_deg(-1.25)}};
  file.views = 12;
  file.reprojection = 0.25;
  file.held_back = 0.0025;
  file.table = 0.00175;
  return file;
}

TEST(HandEyeFile, written_and_read_again_it_is_the_same) {
  HandEyeFile file = some_file();
  for (const bool on_arm : {true, false}) {
    file.on_arm = on_arm;
    const auto again = read_hand_eye(hand_eye_text(file), "hand_eye.toml");
    ASSERT_TRUE(again) << to_text(again.error().front());
    EXPECT_EQ(again->on_arm, on_arm);
    EXPECT_EQ(again->robot, "learm");
    EXPECT_EQ(again->lens, "arm");
    EXPECT_EQ(again->target, "sheet");
    EXPECT_LT(norm(again->X_MC.p - file.X_MC.p), 1e-11);
    EXPECT_LT(angle_between(again->X_MC.R, file.X_MC.R), 1e-7);
    EXPECT_LT(norm(again->X_NB.p - file.X_NB.p), 1e-11);
    ASSERT_EQ(again->joint_zeros.size(), 2U);
    EXPECT_EQ(again->joint_zeros[1].first, "elbow");
    EXPECT_NEAR(again->joint_zeros[1].second, from_deg(-1.25), 1e-9);
    EXPECT_EQ(again->views, 12);
    EXPECT_DOUBLE_EQ(again->held_back, 0.0025);
  }
}

TEST(HandEyeFile, what_is_wrong_is_said_with_its_line) {
  const auto complaint_after = [](const std::string& from, const std::string& to) {
    std::string text = hand_eye_text(some_file());
    text.replace(text.find(from), from.size(), to);
    const auto file = read_hand_eye(text, "hand_eye.toml");
    return file ? std::string() : to_text(file.error().front());
  };
  EXPECT_NE(complaint_after("format = 1", "format = 2").find("sinew camera hand-eye"),
            std::string::npos);
  EXPECT_NE(complaint_after("\"arm\"", "\"leg\"").find("hand_eye.toml:2:"), std::string::npos);
  EXPECT_NE(complaint_after("[camera]", "[lens_pose]").find("camera"), std::string::npos);
  EXPECT_NE(complaint_after("views = 12", "views = many").find("hand_eye.toml:"),
            std::string::npos);
}

}  // namespace
}  // namespace sinew
