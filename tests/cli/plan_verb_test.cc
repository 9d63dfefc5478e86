#include <gtest/gtest.h>

#include <cmath>

#include "cli/process.h"
#include "sinew/io/scratch_folder_test_support.h"

namespace sinew::test {
namespace {

const Arguments kLine{"plan",  "robot-arm-2", "--json", "--from-joints", "0,-30,-30,0,30,0",
                      "--to",  "400,150,300", "--to",   "400,-150,300",  "--speed",
                      "80mm/s"};

Arguments with(Arguments words, const Arguments& more) {
  words.insert(words.end(), more.begin(), more.end());
  return words;
}

TEST(PlanVerb, tool_goes_straight_from_point_to_point_inside_all_limits) {
  const Ended ended = sinew(kLine);
  ASSERT_EQ(ended.exit, 0) << ended.err;
  const Json plan = ended.json();
  ASSERT_EQ(plan["stretches"].size(), 2U);
  bool turned = false;
  for (const Json& sample : plan["samples"]) {
    const double x = sample["tool_mm"][0];
    const double y = sample["tool_mm"][1];
    const double z = sample["tool_mm"][2];
    turned = turned || std::hypot(x - 400, y - 150, z - 300) < 0.01;
    if (turned) {
      EXPECT_NEAR(x, 400, 0.01) << sample;
      EXPECT_NEAR(z, 300, 0.01) << sample;
    }
    for (int j = 0; j < 6; ++j) {
      EXPECT_LE(std::abs(sample["velocity_deg_s"][j].get<double>()), 29.5 + 1e-6);
      EXPECT_LE(std::abs(sample["acceleration_deg_s2"][j].get<double>()), 10 + 1e-6);
      EXPECT_LE(std::abs(sample["jerk_deg_s3"][j].get<double>()), 10 + 1e-6);
    }
  }
  EXPECT_TRUE(turned);
  EXPECT_NEAR(plan["samples"].back()["tool_mm"][1], -150, 1e-3);
  EXPECT_NEAR(plan["samples"].back()["t_s"], plan["duration_s"], 1e-9);
}

TEST(PlanVerb, wide_blend_saves_the_stop_in_the_corner) {
  const Ended stopped = sinew(kLine);
  const Ended blended = sinew(with(kLine, {"--blend", "120mm"}));
  ASSERT_EQ(blended.exit, 0) << blended.err;
  EXPECT_EQ(blended.json()["stretches"].size(), 1U);
  EXPECT_LT(blended.json()["duration_s"], stopped.json()["duration_s"]);
}

TEST(PlanVerb, program_is_planned_row_by_row_and_nothing_moves) {
  const ScratchFolder folder;
  const std::string file = folder.file("p.sinew",
                                       "joint J1=0deg J2=20deg J3=-30deg J5=30deg\n"
                                       "wait 0.5s\n"
                                       "loop 2\n"
                                       "line y=40mm z=600mm\n"
                                       "line y=-40mm blend=5mm\n"
                                       "line z=620mm speed=20mm/s\n"
                                       "end\n");
  const Ended ended = sinew({"plan", file, "--robot", "robot-arm-2", "--json"});
  ASSERT_EQ(ended.exit, 0) << ended.err;
  const Json plan = ended.json();
  ASSERT_EQ(plan["stretches"].size(), 3U);
  EXPECT_EQ(plan["stretches"][2]["first_line"], 5);
  EXPECT_EQ(plan["stretches"][2]["last_line"], 6);
  const Json& last = plan["samples"].back();
  EXPECT_NEAR(last["tool_mm"][1], -40, 1e-3);
  EXPECT_NEAR(last["tool_mm"][2], 620, 1e-3);
  EXPECT_NEAR(last["t_s"], plan["duration_s"], 1e-9);
  // The elbow alone moves far here; sinew torque --program tells the same.
  EXPECT_EQ(plan["heaviest_load"]["joint"], "elbow");
  EXPECT_GT(plan["heaviest_load"]["share_of_available"], 0.1);
  EXPECT_LT(plan["heaviest_load"]["share_of_available"], 0.5);
  // Register boards take whole moves, so a way takes them longer.
  EXPECT_GT(plan["stretches"][1]["on_wire_s"], plan["stretches"][1]["duration_s"]);
}

TEST(PlanVerb, program_that_hits_its_own_arm_is_refused_with_line_and_links) {
  const ScratchFolder folder;
  const std::string file = folder.file("p.sinew", "joint J3=-30deg\njoint J3=-100deg\n");
  for (const Arguments& words : {Arguments{"plan", file, "--robot", "robot-arm-2"},
                                 Arguments{"run", file, "--robot", "robot-arm-2"}}) {
    const Ended ended = sinew(words);
    EXPECT_EQ(ended.exit, 1) << ended.out;
    EXPECT_NE(ended.err.find("p.sinew:2, at "), std::string::npos) << ended.err;
    EXPECT_NE(ended.err.find("shoulder and forearm_roll would come within"), std::string::npos)
        << ended.err;
  }
}

TEST(PlanVerb, picture_has_a_box_for_each_joint_and_quantity) {
  const ScratchFolder folder;
  const std::string file = folder.at("plan.svg");
  const Ended ended = sinew(with(kLine, {"--plot", file}));
  ASSERT_EQ(ended.exit, 0) << ended.err;
  const std::string svg = text_of(file);
  std::size_t boxes = 0;
  for (std::size_t at = 0; (at = svg.find("acceleration, deg/s", at)) != std::string::npos; ++at) {
    ++boxes;
  }
  EXPECT_EQ(boxes, 6U);
  EXPECT_NE(svg.find("from above"), std::string::npos);
}

TEST(PlanVerb, what_cannot_be_gone_is_refused_with_move_and_place) {
  const struct {
    Arguments words;
    const char* says;
  } kCases[] = {
      {{"plan", "robot-arm-2", "--to", "900,0,300"}, "move 1, at "},
      {{"plan", "robot-arm-2", "--to", "joints=0,95,0,0,0,0"}, "shoulder"},
      {{"plan", "robot-arm-2", "--to", "joints=0,10,-30,0,30,0", "--to", "2000,0,300"}, "move 2"},
      {{"plan", "maxarm", "--to", "0,-900,100"}, "move 1"},
  };
  for (const auto& c : kCases) {
    const Ended ended = sinew(c.words);
    EXPECT_EQ(ended.exit, 1) << c.words[3] << ended.out;
    EXPECT_NE(ended.err.find(c.says), std::string::npos) << c.words[3] << ": " << ended.err;
  }
}

TEST(PlanVerb, bad_input_is_told_in_a_sentence) {
  const struct {
    Arguments more;
    const char* says;
  } kCases[] = {
      {{}, "--to"},
      {{"--to", "1,2"}, "--to: "},
      {{"--to", "a,b,c"}, "--to: "},
      {{"--to", "nan,0,0"}, "--to: "},
      {{"--to", "joints=1,2"}, "--to: "},
      {{"--to", "300,0,300", "--speed", "-1mm/s"}, "--speed: "},
      {{"--to", "300,0,300", "--speed", "0"}, "--speed: "},
      {{"--to", "300,0,300", "--blend", "3deg"}, "--blend: "},
      {{"--to", "300,0,300", "--from-joints", "1"}, "--from-joints: "},
      {{"--to", "300,0,300", "--plot", "/nowhere/p.svg"}, "--plot: "},
      {{"--to", "300,0,300", "--robot", "learm"}, "--robot: "},
  };
  for (const auto& c : kCases) {
    const Ended ended = sinew(with({"plan", "robot-arm-2"}, c.more));
    EXPECT_EQ(ended.exit, 2) << ended.out << ended.err;
    EXPECT_NE(ended.err.find(c.says), std::string::npos) << ended.err;
  }
}

TEST(PlanVerb, program_needs_its_robot_and_no_moves_beside_it) {
  const ScratchFolder folder;
  const std::string good = folder.file("p.sinew", "line z=600mm\n");
  const std::string bad = folder.file("q.sinew", "line z=600\n");
  const struct {
    Arguments words;
    const char* says;
  } kCases[] = {
      {{"plan", good}, "--robot is missing"},
      {{"plan", good, "--robot", "robot-arm-2", "--to", "1,2,3"}, "--to, --speed, --blend: "},
      {{"plan", folder.at("none.sinew"), "--robot", "robot-arm-2"}, "none.sinew"},
      {{"plan", bad, "--robot", "robot-arm-2"}, "q.sinew:1:6: '600' needs a unit"},
  };
  for (const auto& c : kCases) {
    const Ended ended = sinew(c.words);
    EXPECT_EQ(ended.exit, 2) << ended.out << ended.err;
    EXPECT_NE(ended.err.find(c.says), std::string::npos) << ended.err;
  }
}

}  // namespace
}  // namespace sinew::test
