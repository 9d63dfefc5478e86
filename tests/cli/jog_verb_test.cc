#include <gtest/gtest.h>

#include <cmath>

#include "cli/process.h"
#include "support/scratch_folder.h"

namespace sinew::test {
namespace {

const Arguments kSlide{"jog",
                       "robot-arm-2",
                       "--json",
                       "--from-joints",
                       "160,30,-60,0,30,0",
                       "--velocity=-50mm/s,-50mm/s,0",
                       "--time",
                       "10s"};

TEST(JogVerb, tool_slides_where_a_joint_comes_to_its_limit_and_comes_to_rest) {
  const Ended ended = sinew(kSlide);
  ASSERT_EQ(ended.exit, 0) << ended.err;
  const Json jog = ended.json();
  bool at_limit = false;
  for (const Json& stretch : jog["stretches"]) {
    at_limit = at_limit || (stretch["reason"] == "joint_limit" && stretch["joint"] == "base");
  }
  EXPECT_TRUE(at_limit);
  const Json& first = jog["samples"].front();
  const Json& last = jog["samples"].back();
  EXPECT_NEAR(last["joints_deg"][0], 170, 1e-3);
  EXPECT_LT(last["tool_mm"][0].get<double>(), first["tool_mm"][0].get<double>() - 150);
  for (const Json& sample : jog["samples"]) {
    for (int j = 0; j < 6; ++j) {
      EXPECT_LE(std::abs(sample["velocity_deg_s"][j].get<double>()), 29.5 + 1e-6);
    }
    EXPECT_LE(sample["joints_deg"][0].get<double>(), 170 + 1e-6);
  }
  for (const Json& velocity : last["velocity_deg_s"]) EXPECT_NEAR(velocity, 0, 1e-3);
}

TEST(JogVerb, each_robot_can_be_jogged_by_joints_and_by_its_tool) {
  const struct {
    const char* robot;
    const char* joints;
    const char* tool;
  } kCases[] = {
      {"robot-arm-2", "5deg/s,0,0,0,0,0", "10mm/s,0,0,0,0,2deg/s"},
      {"puma560", "5,0,0,0,0,0", "0,0,-10"},
      {"learm", "5,0,0,0,0", "10,0,0,5deg/s,0"},
      {"bigrobotarm", "5,0,0,0,0", "10,0,0"},
      {"maxarm", "5,0,0", "0,10,10"},
      {"hexapod", "0.005mm/s,0,0,0,0,0", "0.002,0,0,0,0,0.001deg/s"},
  };
  for (const auto& c : kCases) {
    for (const bool by_joints : {true, false}) {
      const Ended ended = sinew({"jog", c.robot, "--frame", by_joints ? "joint" : "tool",
                                 std::string("--velocity=") + (by_joints ? c.joints : c.tool),
                                 "--time", "1s", "--json"});
      ASSERT_EQ(ended.exit, 0) << c.robot << ended.err;
      EXPECT_GT(ended.json()["tool_way_mm"], 0) << c.robot;
    }
  }
}

TEST(JogVerb, picture_has_a_box_for_each_joint) {
  const ScratchFolder folder;
  const std::string file = folder.at("jog.svg");
  Arguments words = kSlide;
  words.insert(words.end(), {"--plot", file});
  const Ended ended = sinew(words);
  ASSERT_EQ(ended.exit, 0) << ended.err;
  const std::string svg = text_of(file);
  for (const char* joint : {"base", "shoulder", "elbow", "forearm_roll", "wrist_bend"}) {
    EXPECT_NE(svg.find(joint), std::string::npos) << joint;
  }
}

/// It used to swing on for 10 s, twice as fast as it was let go.
TEST(JogVerb, let_go_near_a_stretched_elbow_the_arm_rests_when_its_joints_can) {
  const Ended ended = sinew({"jog", "robot-arm-2", "--json", "--from-joints", "0,-30,-30,0,30,0",
                             "--velocity", "70mm/s,0,0", "--time", "3s"});
  ASSERT_EQ(ended.exit, 0) << ended.err;
  const Json jog = ended.json();
  EXPECT_EQ(jog["let_go_s"], 3);
  EXPECT_LT(jog["duration_s"], 3 + 4.0);
  EXPECT_LT(jog["tool_way_after_mm"], 150);
  EXPECT_EQ(jog["stretches"].back()["reason"], "no_command");
  EXPECT_NEAR(jog["stretches"].back()["from_s"].get<double>(), 3, 1e-9);
}

TEST(JogVerb, stretches_hold_all_of_the_time_and_stay_few) {
  const Ended ended =
      sinew({"jog", "hexapod", "--velocity", "0,0,20mm/s", "--time", "60s", "--json"});
  ASSERT_EQ(ended.exit, 0) << ended.err;
  EXPECT_LT(ended.out.size(), 2'000'000U);
  const Json jog = ended.json();
  EXPECT_LE(jog["stretches"].size(), 50U);
  double at = 0;
  for (const Json& stretch : jog["stretches"]) {
    EXPECT_NEAR(stretch["from_s"].get<double>(), at, 1e-9);
    at = stretch["to_s"];
  }
  EXPECT_NEAR(at, jog["duration_s"].get<double>(), 1e-9);
}

TEST(JogVerb, start_outside_of_limits_is_told_and_far_outside_only_joints_go) {
  const auto from = [](const char* joints, const char* frame, const char* velocity) {
    return sinew(
        {"jog", "robot-arm-2", "--from-joints", joints, "--frame", frame, "--velocity", velocity});
  };
  const Ended far = from("0,0,0,0,0,362", "base", "20mm/s,0,0");
  EXPECT_NE(far.exit, 0);
  EXPECT_NE(far.err.find("flange_roll"), std::string::npos) << far.err;
  const Ended near = from("0,0,0,0,0,360.5", "base", "20mm/s,0,0");
  EXPECT_EQ(near.exit, 0) << near.err;
  EXPECT_NE(near.out.find("flange_roll"), std::string::npos) << near.out;
  const Ended joint = from("0,0,0,0,0,362", "joint", "0,0,0,0,0,-5deg/s");
  EXPECT_EQ(joint.exit, 0) << joint.err;
  EXPECT_NE(joint.out.find("inwards"), std::string::npos) << joint.out;
}

TEST(JogVerb, robot_that_overlaps_goes_slowly_by_its_joints_and_says_so) {
  const Ended ended = sinew({"jog", "robot-arm-2", "--from-joints=-169,-89,-134,-169,-119,-359",
                             "--frame", "joint", "--velocity", "0,0,20deg/s,0,0,0"});
  ASSERT_EQ(ended.exit, 0) << ended.err;
  EXPECT_NE(ended.out.find("overlaps by"), std::string::npos) << ended.out;
  EXPECT_NE(ended.out.find("slow"), std::string::npos) << ended.out;
}

TEST(JogVerb, no_velocity_at_all_stands_still) {
  const Ended ended = sinew({"jog", "robot-arm-2", "--velocity", "0,0,0"});
  ASSERT_EQ(ended.exit, 0) << ended.err;
  EXPECT_NE(ended.out.find("no velocity is asked for"), std::string::npos) << ended.out;
}

TEST(JogVerb, bad_input_is_told_in_a_sentence) {
  const struct {
    Arguments more;
    const char* says;
  } kCases[] = {
      {{}, "--velocity"},
      {{"--velocity", "1,2"}, "--velocity"},
      {{"--velocity", "a,b,c"}, "--velocity"},
      {{"--velocity", "nan,0,0"}, "--velocity"},
      {{"--velocity", "1e9,0,0"}, "no jog is faster than 100 m/s"},
      {{"--velocity", "1e308,0,0"}, "no jog is faster than 100 m/s"},
      {{"--velocity", "1,0,0", "--frame", "moon"}, "--frame"},
      {{"--velocity", "1,0,0", "--frame", "platform"}, "--frame"},
      {{"--velocity", "1,0,0", "--time", "0"}, "--time"},
      {{"--velocity", "1,0,0", "--time", "1e9"}, "--time"},
      {{"--velocity", "1,0,0", "--from-joints", "1"}, "--from-joints"},
      {{"--velocity", "1,0,0", "--plot", "/nowhere/p.svg"}, "--plot"},
  };
  for (const auto& c : kCases) {
    Arguments words{"jog", "robot-arm-2"};
    words.insert(words.end(), c.more.begin(), c.more.end());
    const Ended ended = sinew(words);
    EXPECT_EQ(ended.exit, 2) << ended.out << ended.err;
    EXPECT_NE(ended.err.find(c.says), std::string::npos) << ended.err;
  }
}

}  // namespace
}  // namespace sinew::test
