#include <gtest/gtest.h>

#include <cmath>

#include "cli/process.h"
#include "support/scratch_folder.h"

/// `sinew axis`: figures of the control loops, and their picture.
namespace sinew::test {
namespace {

const std::vector<std::string> kArmOut{"--joints-deg", "0,-45,45,0,40,0", "--payload-kg", "0.5"};

std::vector<std::string> axis_words(const std::vector<std::string>& more) {
  std::vector<std::string> words{"axis", "robot-arm-2"};
  words.insert(words.end(), kArmOut.begin(), kArmOut.end());
  words.insert(words.end(), more.begin(), more.end());
  return words;
}

TEST(AxisVerb, tells_of_every_axis_how_it_settles_and_follows) {
  const Json all = answer(axis_words({}));
  ASSERT_EQ(all["axes"].size(), 6U);
  for (const Json& axis : all["axes"]) {
    for (const char* step : {"step_up", "step_down"}) {
      EXPECT_FALSE(axis[step]["loses_steps"].get<bool>()) << axis["axis"];
      EXPECT_GT(axis[step]["rise_s"].get<double>(), 0.05);
      EXPECT_LT(axis[step]["settling_s"].get<double>(), 0.9);
      EXPECT_LT(axis[step]["steady_error_deg"].get<double>(), 0.17);
    }
    const double follows = axis["tracking"]["error_max_deg"].get<double>();
    EXPECT_LT(follows, 0.2);
    EXPECT_GT(axis["tracking_without_feed_forward"]["error_max_deg"].get<double>(), 4 * follows);
  }
  EXPECT_NEAR(all["axes"][1]["load_nm"].get<double>(), -18.4, 0.2);
}

TEST(AxisVerb, a_jump_that_the_motor_cannot_follow_is_called_one) {
  const Json answered = answer(axis_words({"--axis", "J1", "--step", "10deg"}));
  ASSERT_EQ(answered["axes"].size(), 1U);
  EXPECT_TRUE(answered["axes"][0]["step_up"]["loses_steps"].get<bool>());
}

TEST(AxisVerb, draws_what_it_tells) {
  const ScratchFolder folder;
  const std::string path = folder.at("axis.svg");
  const Json answered = answer(axis_words({"--axis", "wrist_bend", "--plot", path}));
  EXPECT_EQ(answered["plot"], path);
  const std::string picture = text_of(path);
  EXPECT_EQ(picture.rfind("<svg ", 0), 0U);
  EXPECT_NE(picture.find("J5 wrist_bend: jump of the reference"), std::string::npos);
  EXPECT_NE(picture.find("without feed-forward"), std::string::npos);
}

TEST(AxisVerb, what_cannot_be_tried_is_refused_with_the_way_out) {
  const auto refused = [](std::vector<std::string> words, const std::string& sentence,
                          int exit = 2) {
    words.insert(words.begin(), "axis");
    const Ended ended = sinew(words);
    EXPECT_EQ(ended.exit, exit);
    EXPECT_NE(ended.err.find(sentence), std::string::npos) << ended.err;
  };
  refused({"learm"}, "no arm with a stepper on each joint", 1);
  refused({"hexapod"}, "no arm with a stepper on each joint", 1);
  refused({"bigrobotarm"}, "its motors run open loop", 1);
  refused({"robot-arm-2", "--axis", "J7"}, "no axis 'J7'");
  refused({"robot-arm-2", "--axis", "J2", "--track", "120deg"}, "its limits are -90 and 90 deg");
  refused({"robot-arm-2", "--step", "0"}, "must be above 0");
  refused({"robot-arm-2", "--payload-kg", "-1kg"}, "--payload-kg");
  refused({"robot-arm-2", "--payload-kg", "900"}, "must be 0 to 50 kg");
  refused({"robot-arm-2", "--plot", "/nowhere/x.svg"}, "--plot: ");
}

}  // namespace
}  // namespace sinew::test
