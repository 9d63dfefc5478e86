#include <gtest/gtest.h>

#include <array>

#include "cli/process.h"
#include "support/scratch_folder.h"

/// `sinew torque`: the author's table, what fails first, programs, and whatever people type.
namespace sinew::test {
namespace {

void expect_refused(const Arguments& arguments, int exit, const std::string& sentence) {
  const Ended ended = sinew(arguments);
  EXPECT_EQ(ended.exit, exit) << ended.err;
  EXPECT_EQ(ended.out, "");
  EXPECT_NE(ended.err.find(sentence), std::string::npos) << ended.err;
  Arguments with_json = arguments;
  with_json.emplace_back("--json");
  EXPECT_TRUE(sinew(with_json).json().contains("error"));
}

TEST(TorqueVerb, reproduces_the_table_of_the_author_and_says_where_it_fails_first) {
  const Json answer = test::answer({"torque", "robot-arm-2"});
  constexpr std::array kTable{15.0, 45.0, 30.0, 15.0, 9.5, 4.8};  // Nm
  ASSERT_EQ(answer["joints"].size(), kTable.size());
  for (std::size_t i = 0; i < kTable.size(); ++i) {
    const Json& joint = answer["joints"][i];
    EXPECT_NEAR(joint["holding_nm"].get<double>(), kTable[i], 0.05);
    EXPECT_GT(joint["margin"].get<double>(), 1);
  }
  const Json& closely = answer["closely"];
  EXPECT_EQ(closely["joint"], "shoulder");
  const double fails = answer["joints"][1]["fails_from_kg"];
  for (const Json& row : closely["payloads"]) {
    const bool too_much = row["payload_kg"].get<double>() > fails;
    EXPECT_EQ(row["margin"].get<double>() < 1, too_much);
    EXPECT_EQ(row["fails_from_reach_mm"].is_number(), too_much);
    EXPECT_EQ(row["ratio_that_does"].get<double>() > 17, too_much);
  }
  EXPECT_EQ(answer["assumed_masses"].size(), 6U);
}

TEST(TorqueVerb, payload_is_taken_with_and_without_a_unit) {
  const Json plain = answer({"torque", "maxarm", "--payload-kg", "0.1"});
  const Json grams = answer({"torque", "maxarm", "--payload-kg", "100g"});
  EXPECT_EQ(plain["joints"], grams["joints"]);
  const Json bare = answer({"torque", "maxarm"});
  EXPECT_GT(plain["joints"][1]["weight_nm"].get<double>(),
            bare["joints"][1]["weight_nm"].get<double>());
}

TEST(TorqueVerb, all_five_robots_have_an_answer) {
  for (const char* robot : {"learm", "bigrobotarm", "maxarm", "hexapod"}) {
    const Json answer = test::answer({"torque", robot});
    for (const Json& joint : answer["joints"]) {
      EXPECT_GT(joint["margin"].get<double>(), 0) << robot;
      EXPECT_TRUE(joint.contains(std::string(robot) == "hexapod" ? "demand_n" : "demand_nm"));
    }
    EXPECT_FALSE(answer["closely"]["payloads"].empty());
  }
}

TEST(TorqueVerb, program_tells_peak_and_mean_with_line_and_time) {
  const std::string file = SINEW_SOURCE_DIR "/robots/robot-arm-2/first_moves.sinew";
  const Json answer =
      test::answer({"torque", "robot-arm-2", "--program", file, "--payload-kg", "500g"});
  ASSERT_EQ(answer["program"]["joints"].size(), 6U);
  for (const Json& joint : answer["program"]["joints"]) {
    EXPECT_GE(joint["peak_nm"].get<double>(), joint["rms_nm"].get<double>());
    EXPECT_GE(joint["line"].get<int>(), 1);
    EXPECT_LE(joint["at_s"].get<double>(), answer["program"]["duration_s"].get<double>());
  }
  const Ended text = sinew({"torque", "robot-arm-2", "--program", file, "--axis", "J3"});
  EXPECT_EQ(text.exit, 0);
  EXPECT_NE(text.out.find("J3 elbow: where its 30.0 Nm first fail"), std::string::npos) << text.out;
  EXPECT_NE(text.out.find("6 of 6 masses are assumed"), std::string::npos);
}

TEST(TorqueVerb, bad_input_gets_a_sentence) {
  const ScratchFolder folder;
  const std::string nowhere = folder.at("none.sinew");
  expect_refused({"torque", "robot-arm-3"}, 2, "there is no robot 'robot-arm-3', did you mean");
  expect_refused({"torque", "learm", "--payload-kg", "-1"}, 2, "--payload-kg: -1 kg is outside");
  expect_refused({"torque", "learm", "--payload-kg", "1001"}, 2, "is outside 0..1000 kg");
  for (const char* odd : {"nan", "inf", "", "1mm", "1e999", "kg", "0x10", "one"}) {
    expect_refused({"torque", "learm", "--payload-kg", odd}, 2, "--payload-kg");
  }
  expect_refused({"torque", "learm", "--axis", "sholder"}, 2, "did you mean 'shoulder'?");
  expect_refused({"torque", "learm", "--axis", "J6"}, 2, "has no joint 'J6'");
  expect_refused({"torque", "learm", "--program", nowhere}, 2, nowhere);
  expect_refused({"torque"}, 2, "ROBOT");
}

TEST(TorqueVerb, robot_without_motors_and_masses_says_what_is_missing) {
  const Ended ended = sinew({"torque", "puma560"});
  EXPECT_EQ(ended.exit, 1);
  EXPECT_NE(ended.err.find("no torque can be told for puma560: its file does not say its motors"),
            std::string::npos)
      << ended.err;
  EXPECT_NE(ended.err.find("[link.NAME]"), std::string::npos);
}

TEST(TorqueVerb, program_that_leaves_its_limits_is_refused_with_its_line) {
  const ScratchFolder folder;
  const std::string file = folder.file("far.sinew", "joint base=10deg\njoint base=179deg\n");
  expect_refused({"torque", "robot-arm-2", "--program", file}, 1, "far.sinew:2, at ");
}

}  // namespace
}  // namespace sinew::test
