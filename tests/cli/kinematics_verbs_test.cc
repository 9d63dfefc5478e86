#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <sstream>
#include <tuple>
#include <utility>

#include "cli/process.h"
#include "support/scratch_folder.h"

/// `sinew robots`, `fk` and `ik`: documented numbers of all robots, and the shapes of the JSON.
namespace sinew::test {
namespace {

constexpr double kMm = 0.001;

void expect_at(const Json& answer, double x_mm, double y_mm, double z_mm, double tolerance = kMm) {
  const Json& pose = answer["pose"];
  EXPECT_NEAR(pose["x_mm"].get<double>(), x_mm, tolerance);
  EXPECT_NEAR(pose["y_mm"].get<double>(), y_mm, tolerance);
  EXPECT_NEAR(pose["z_mm"].get<double>(), z_mm, tolerance);
  double square = 0;
  ASSERT_EQ(pose["quaternion_wxyz"].size(), 4U);
  for (const double part : pose["quaternion_wxyz"]) square += part * part;
  EXPECT_NEAR(square, 1, 1e-12);
}

Json fk(const std::string& robot, const std::string& joints) {
  return answer({"fk", robot, "--joints-deg", joints});
}

void expect_numbers(const Json& numbers, const std::vector<double>& expected, double tolerance) {
  ASSERT_EQ(numbers.size(), expected.size());
  for (std::size_t i = 0; i < expected.size(); ++i) {
    EXPECT_NEAR(numbers[i].get<double>(), expected[i], tolerance) << "number " << i + 1;
  }
}

TEST(ForwardVerb, learm_stands_where_its_document_says) {
  const Json level = fk("learm", "0,90,0,0,0");
  expect_at(level, 353, 0, 95);
  EXPECT_EQ(level["robot"], "learm");
  expect_numbers(level["joints_deg"], {0, 90, 0, 0, 0}, 1e-9);
  EXPECT_EQ(level["within_limits"], true);
  EXPECT_TRUE(level["violations"].empty());
  const Json up = fk("learm", "0,0,0,0,0");
  expect_at(up, 0, 0, 448);
  expect_numbers(up["pose"]["quaternion_wxyz"], {1, 0, 0, 0}, 1e-12);
}

TEST(InverseVerb, bigrobotarm_points_out_of_its_plane_by_rolling_the_forearm) {
  const Json ways =
      answer({"ik", "bigrobotarm", "--point-mm", "300,100,100", "--approach", "1,0.5,-2"});
  ASSERT_EQ(ways["solutions"].size(), 8U);
  const Json& joints = ways["solutions"][0]["joints_deg"];
  EXPECT_GT(std::abs(joints[3].get<double>()), 1);
  std::string list;
  for (const double joint : joints) list += (list.empty() ? "" : ",") + std::to_string(joint);
  const Json pose = fk("bigrobotarm", list);
  expect_at(pose, 300, 100, 100);
  // The tool's z axis is the third column of the rotation.
  const auto q = pose["pose"]["quaternion_wxyz"].get<std::array<double, 4>>();
  const double length = std::sqrt(1 + 0.25 + 4);
  EXPECT_NEAR(2 * (q[1] * q[3] + q[0] * q[2]), 1 / length, 1e-6);
  EXPECT_NEAR(2 * (q[2] * q[3] - q[0] * q[1]), 0.5 / length, 1e-6);
}

TEST(ForwardVerb, bigrobotarm_is_568_mm_tall) {
  expect_at(fk("bigrobotarm", "0,0,0,0,0"), 0, 0, 568.009);
}

TEST(ForwardVerb, robot_arm_2_meets_its_reference_poses) {
  const Json zero = fk("robot-arm-2", "0,0,0,0,0,0");
  expect_at(zero, 365, 0, 620, 1e-6);
  expect_at(fk("robot-arm-2", "30,-45,60,20,40,-10"), 466.022046, 243.672288, 672.963154, 1e-6);
  expect_at(fk("robot-arm-2", "10,20,30,40,50,60"), 32.673004, -44.238868, 874.891108, 1e-6);
  expect_at(fk("robot-arm-2", "-120,30,-60,100,-70,200"), 14.005756, -160.824634, 436.299587, 1e-6);
}

TEST(ForwardVerb, maxarm_meets_the_vectors_of_its_firmware) {
  expect_at(fk("maxarm", "120,90.0278,0.3321"), 0, -163, 212, 0.01);
  expect_at(fk("maxarm", "86.3099,133.7099,41.9294"), 120, -180, 85, 0.01);
  expect_at(fk("maxarm", "153.6901,133.7099,41.9294"), -120, -180, 85, 0.01);
  expect_at(fk("maxarm", "30,88.9526,5.3131"), 160, 0, 200, 0.01);
}

TEST(ForwardVerb, puma_meets_its_textbook) {
  expect_at(fk("puma560", "0,0,0,0,0,0"), 452.1, -150.05, 431.8);
}

TEST(ForwardVerb, hexapod_finds_its_home_from_its_legs) {
  const Json home =
      answer({"fk", "hexapod", "--legs-mm", "268.363,268.363,268.363,268.363,268.363,268.363"});
  expect_at(home, 0, 0, 250, 0.01);
  EXPECT_EQ(home["legs_mm"].size(), 6U);
  EXPECT_GE(home["condition"].get<double>(), 1);
  EXPECT_EQ(home["within_limits"], true);
  const Json near = answer({"fk", "hexapod", "--legs-mm", "270,265,270,265,270,265",
                            "--near-pose-mm-deg", "0,0,250,0,0,5"});
  EXPECT_GT(near["pose"]["z_mm"].get<double>(), 200);
}

TEST(ForwardVerb, numbers_may_be_negative_and_carry_units) {
  expect_at(fk("learm", "-30,45,0,0,0"), 216.1675, -124.8043, 344.6087);
  expect_at(answer({"fk", "learm", "--joints-deg=-30,45,0,0,0"}), 216.1675, -124.8043, 344.6087);
  expect_at(fk("learm", "90deg,1.5707963267948966rad, +0 , 0,-0"), 0, 353, 95);
  expect_at(fk("learm", "-.5,45,0,0,0"), 249.599, -2.178, 344.609);
  const Json inches =
      answer({"fk", "hexapod", "--legs-mm", "10.5in,266.7,0.2667m,26.67cm,10.5 in,266.7mm"});
  expect_numbers(inches["legs_mm"], std::vector<double>(6, 266.7), 1e-9);
}

TEST(ForwardVerb, joints_outside_their_limits_are_answered_with_a_warning) {
  const Json far = fk("learm", "0,90,0,0,400");
  EXPECT_EQ(far["within_limits"], false);
  ASSERT_EQ(far["violations"].size(), 1U);
  EXPECT_EQ(far["violations"][0]["code"], "joint_limit");
  EXPECT_GT(far["violations"][0]["excess_deg"].get<double>(), 100);
}

TEST(ForwardVerb, frames_list_every_link_and_multiply_to_the_pose) {
  const Json json = answer({"fk", "learm", "--joints-deg", "10,20,30,40,50", "--frames"});
  EXPECT_EQ(json["dh"].size(), 5U);
  const Json& frames = json["frames_mm"];
  for (const char* name :
       {"X_01", "X_12", "X_23", "X_34", "X_45", "X_02", "X_05", "X_03 inverse", "X_35", "X_0T"}) {
    ASSERT_TRUE(frames.contains(name)) << name;
    ASSERT_EQ(frames[name].size(), 4U) << name;
  }
  std::array<double, 3> p{};
  for (std::size_t row = 0; row < 3; ++row) {
    for (std::size_t k = 0; k < 4; ++k) {
      p[row] += frames["X_05"][row][k].get<double>() *
                frames["X_FT (tool on the flange)"][k][3].get<double>();
    }
  }
  expect_at(json, p[0], p[1], p[2], 1e-9);
  const Ended text = sinew({"fk", "robot-arm-2", "--frames"});
  EXPECT_EQ(text.exit, 0);
  EXPECT_NE(text.out.find("alpha deg"), std::string::npos);
  EXPECT_NE(text.out.find("X_56"), std::string::npos);
}

/// Every solution of `ik` that it calls good brings `fk` back to the point.
void expect_fk_returns(const std::string& robot, const Json& solutions, const Json& wanted) {
  std::size_t good = 0;
  for (const Json& solution : solutions) {
    EXPECT_TRUE(solution["within_limits"].is_boolean());
    EXPECT_TRUE(solution["violations"].is_array());
    EXPECT_EQ(solution["within_limits"], solution["violations"].empty());
    if (!solution["within_limits"]) continue;
    ++good;
    std::string joints;
    for (const double joint : solution["joints_deg"]) {
      joints += (joints.empty() ? "" : ",") + std::to_string(joint);
    }
    expect_at(fk(robot, joints), wanted[0], wanted[1], wanted[2], 0.01);
  }
  EXPECT_GE(good, 1U);
}

TEST(InverseVerb, every_serial_arm_comes_back_to_its_point) {
  const std::vector<std::pair<std::string, std::string>> cases{
      {"learm", "10,40,30,20,15"},
      {"bigrobotarm", "10,-20,60,0,30"},
      {"robot-arm-2", "30,-45,60,20,40,-10"},
      {"puma560", "10,20,-30,40,50,60"}};
  for (const auto& [robot, joints] : cases) {
    SCOPED_TRACE(robot);
    const Ended forward = sinew({"fk", robot, "--joints-deg", joints});
    // People copy the line that fk offers.
    const std::string key = "--pose-mm-deg ";
    const std::size_t at = forward.out.find(key);
    ASSERT_NE(at, std::string::npos);
    const std::size_t begin = at + key.size();
    const std::string pose = forward.out.substr(begin, forward.out.find('\n', begin) - begin);
    const Ended inverse = sinew({"ik", robot, "--pose-mm-deg", pose, "--json"});
    ASSERT_EQ(inverse.exit, 0) << inverse.err;
    const Json X = fk(robot, joints)["pose"];
    expect_fk_returns(robot, inverse.json()["solutions"], {X["x_mm"], X["y_mm"], X["z_mm"]});
  }
}

TEST(InverseVerb, point_alone_chooses_a_pitch_and_says_which) {
  const Json json = answer({"ik", "learm", "--point-mm", "200,0,20"});
  EXPECT_TRUE(json["pitch_deg"].is_number());
  expect_fk_returns("learm", json["solutions"], {200, 0, 20});
  const Json X = fk("learm", "10,40,30,20,15")["pose"];
  const std::string point = X["x_mm"].dump() + "," + X["y_mm"].dump() + "," + X["z_mm"].dump();
  const Json pitched = answer({"ik", "learm", "--point-mm", point, "--pitch-deg", "90"});
  expect_fk_returns("learm", pitched["solutions"], {X["x_mm"], X["y_mm"], X["z_mm"]});
}

TEST(InverseVerb, maxarm_meets_the_vectors_of_its_firmware) {
  const auto joints = [](const std::string& point) {
    const Json json = answer({"ik", "maxarm", "--point-mm", point});
    EXPECT_EQ(json["solutions"].size(), 1U);
    return json["solutions"][0]["joints_deg"];
  };
  expect_numbers(joints("0,-163,212"), {120, 90.0278, 0.3321}, 1e-4);
  expect_numbers(joints("120,-180,85"), {86.3099, 133.7099, 41.9294}, 1e-4);
  expect_numbers(joints("-120,-180,85"), {153.6901, 133.7099, 41.9294}, 1e-4);
  expect_numbers(joints("0,-280,75"), {120, 164.8336, 18.1520}, 1e-4);
  expect_numbers(joints("160,0,200"), {30, 88.9526, 5.3131}, 1e-4);
  expect_numbers(joints("150,-35,90"), {43.134, 112.7352, 54.8414}, 1e-4);
  expect_numbers(joints("0,-200,120"), {120, 118.2898, 34.1481}, 1e-4);
}

TEST(InverseVerb, hexapod_answers_with_legs) {
  const Json json = answer({"ik", "hexapod", "--pose-mm-deg", "0,0,250,0,0,0"});
  expect_numbers(json["legs_mm"], std::vector<double>(6, 268.363), 0.001);
  ASSERT_EQ(json["solutions"].size(), 1U);
  EXPECT_EQ(json["solutions"][0]["within_limits"], true);
  const Json metres = answer(
      {"ik", "hexapod", "--pose-mm-deg", "0,0,0.25m,0,0,0", "--near-pose-mm-deg", "0,0,250,0,0,0"});
  EXPECT_EQ(metres["legs_mm"], json["legs_mm"]);
}

TEST(InverseVerb, refusal_is_json_on_stdout_a_sentence_on_stderr_and_exit_1) {
  const std::vector<std::tuple<Arguments, std::string, std::string>> cases{
      {{"learm", "--point-mm", "900,0,20"}, "out_of_reach", "out of reach by 550.1 mm"},
      {{"maxarm", "--point-mm", "0,-100,240"}, "joint_limit", "forearm would need -17.0579 deg"},
      {{"maxarm", "--point-mm", "100,100,100"}, "joint_limit", "base would need -15 deg"},
      {{"hexapod", "--pose-mm-deg", "0,0,500,0,0,0"}, "leg_length", "leg1"},
      {{"puma560", "--pose-mm-deg", "3000,0,0,0,0,0"}, "out_of_reach", "out of reach by"},
      {{"robot-arm-2", "--point-mm", "300,0,300"}, "task_not_supported", "--pose-mm-deg"},
  };
  for (auto [arguments, code, sentence] : cases) {
    arguments.insert(arguments.begin(), "ik");
    arguments.emplace_back("--json");
    const Ended ended = sinew(arguments);
    SCOPED_TRACE(arguments[1] + " " + arguments[3]);
    EXPECT_EQ(ended.exit, 1);
    EXPECT_EQ(ended.json()["refusal"]["code"], code);
    EXPECT_TRUE(ended.json()["solutions"].is_array());
    EXPECT_NE(ended.err.find(sentence), std::string::npos) << ended.err;
  }
}

TEST(RobotsVerb, lists_the_six_and_shows_each) {
  const Json list = answer({"robots"});
  std::vector<std::string> ids;
  for (const Json& robot : list["robots"]) ids.push_back(robot["id"]);
  EXPECT_EQ(ids,
            (Arguments{"bigrobotarm", "hexapod", "learm", "maxarm", "puma560", "robot-arm-2"}));
  for (const std::string& id : ids) {
    const Json robot = answer({"robots", id});
    EXPECT_EQ(robot["id"], id);
    EXPECT_EQ(robot["limits"].size(), robot["joints"].size());
    EXPECT_FALSE(robot["sources"].empty());
    const Ended text = sinew({"robots", id});
    EXPECT_EQ(text.exit, 0);
    EXPECT_NE(text.out.find("where it comes from"), std::string::npos);
  }
}

TEST(RobotsVerb, file_of_ones_own_is_a_robot_too) {
  const ScratchFolder folder;
  const std::string path =
      folder.file("mine.toml", text_of(std::string(SINEW_SOURCE_DIR) + "/robots/learm.toml"));
  EXPECT_EQ(answer({"robots", path})["id"], "learm");
  expect_at(fk(path, "0,90,0,0,0"), 353, 0, 95);
}

TEST(Help, every_verb_has_an_example_that_works) {
  for (const std::string verb : {"robots", "fk", "ik"}) {
    const Ended help = sinew({verb, "--help"});
    EXPECT_EQ(help.exit, 0);
    const std::size_t at = help.out.find("sinew " + verb + " ", help.out.find("Example:"));
    ASSERT_NE(at, std::string::npos) << help.out;
    const std::string line = help.out.substr(at, help.out.find('\n', at) - at);
    Arguments arguments;
    std::stringstream words(line);
    for (std::string word; words >> word;) arguments.push_back(word);
    arguments.erase(arguments.begin());
    EXPECT_EQ(sinew(arguments).exit, 0) << line;
  }
  EXPECT_EQ(sinew({"--help", "--json"}).json()["help"].get<std::string>().substr(0, 5), "Sinew");
  EXPECT_EQ(sinew({"--version"}).out, "0.1.0\n");
}

TEST(Json, flag_may_stand_before_the_verb) {
  EXPECT_EQ(sinew({"--json", "robots", "learm"}).json()["id"], "learm");
}

}  // namespace
}  // namespace sinew::test
