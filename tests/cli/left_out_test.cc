#include <gtest/gtest.h>

#include <csignal>
#include <cstdlib>

#include "cli/process.h"
#include "cli/small_arm.h"
#include "support/scratch_folder.h"

/// Robot Arm 2 with a board missing: the others by choice, the missing axis unknown.
namespace sinew::test {
namespace {

constexpr const char* kOfFiveAxes =
    "home\n"
    "joint base=2deg shoulder=-2deg elbow=1deg wrist_bend=3deg\n"
    "joint base=0deg\n";

TEST(LeftOut, arm_whose_last_board_is_missing_homes_and_runs_without_it_on_both_wires) {
  for (const bool link : {false, true}) {
    const ScratchFolder folder;
    const std::string robot = small_robot_arm_2(folder, link);
    Process sim({"sim", robot, "--slaves", "5", "--simwire", "unix:" + folder.at("s"), "--json"});
    const std::string port = Json::parse(sim.line_after(0), nullptr, false)["port"];
    const auto run = [&](const std::string& program, const Arguments& more) {
      Arguments words{
          "run", folder.file("p.sinew", program), "--robot", robot, "--port", port, "--time-scale",
          "10"};
      words.insert(words.end(), more.begin(), more.end());
      return sinew(words);
    };
    const Ended rest = run(kOfFiveAxes, {"--without", "J6"});
    ASSERT_EQ(rest.exit, 0) << rest.err << rest.out;
    for (const char* row : {"line dx=1mm\n", "move x=300mm\n", "joint flange_roll=1deg\n"}) {
      const Ended refused = run(row, {"--without", "J6"});
      EXPECT_NE(refused.exit, 0) << row;
      EXPECT_NE(refused.err.find("flange_roll (J6) is left out, its position is unknown; use "
                                 "joint moves that do not name flange_roll"),
                std::string::npos)
          << refused.err;
    }
    const Ended all = run(kOfFiveAxes, {});
    EXPECT_EQ(all.exit, 1);
    EXPECT_NE(all.err.find("1 of 6 boards does not answer: J6; to use the others: --without J6"),
              std::string::npos)
        << all.err;
    sim.signal(SIGINT);
    const std::string out = sim.end().out;
    const Json truth = Json::parse(out.substr(out.find('\n') + 1), nullptr, false)["truth"];
    const double expected[] = {0, -2, 1, 0, 3};
    for (std::size_t j = 0; j < 5; ++j) {
      EXPECT_NEAR(truth["joints"][j]["q_deg"].get<double>(), expected[j], 0.3) << j;
    }
  }
}

TEST(SelfTest, each_board_of_either_wire_tests_itself_and_one_that_is_missing_is_named) {
  for (const bool link : {false, true}) {
    const ScratchFolder folder;
    const std::string robot = small_robot_arm_2(folder, link);
    Process sim({"sim", robot, "--slaves", "5", "--simwire", "unix:" + folder.at("s"), "--json"});
    const std::string port = Json::parse(sim.line_after(0), nullptr, false)["port"];
    const Arguments test{"device",    robot, "test",         "--port", port,
                         "--without", "J6",  "--time-scale", "10"};
    const Ended limp = sinew(test);
    ASSERT_EQ(limp.exit, 0) << limp.err;
    EXPECT_NE(limp.out.find("base: passed; a motor turns only where its joint is known"),
              std::string::npos)
        << limp.out;
    EXPECT_NE(limp.out.find("flange_roll: left out"), std::string::npos) << limp.out;
    const Ended all = sinew({"device", robot, "test", "--port", port});
    EXPECT_EQ(all.exit, 1);
    EXPECT_NE(all.err.find("flange_roll"), std::string::npos) << all.err;
    const Ended homed = sinew({"run", folder.file("p.sinew", "home\n"), "--robot", robot, "--port",
                               port, "--without", "J6", "--time-scale", "10"});
    ASSERT_EQ(homed.exit, 0) << homed.err;
    const Ended turned = sinew(test);
    ASSERT_EQ(turned.exit, 0) << turned.err;
    EXPECT_NE(turned.out.find("wrist_bend: passed; its motor turned a full step and back"),
              std::string::npos)
        << turned.out;
    const Ended doctor = sinew({"doctor", "--robot", robot, "--port", port, "--without", "J6"});
    EXPECT_EQ(doctor.exit, 0) << doctor.err;
  }
}

TEST(LeftOut, a_person_says_where_the_others_stand_to_boards_that_tell_nothing) {
  const ScratchFolder folder;
  const std::string robot = small_robot_arm_2(folder, false);
  Process sim({"sim", robot, "--slaves", "5", "--profile", "as-built", "--simwire",
               "unix:" + folder.at("s"), "--json"});
  const std::string port = Json::parse(sim.line_after(0), nullptr, false)["port"];
  const Arguments words{
      "run",           folder.file("p.sinew", "joint base=2deg\njoint base=0deg\n"),
      "--robot",       robot,
      "--port",        port,
      "--profile",     "as-built",
      "--without",     "J6",
      "--standing-at", "home",
      "--journal",     "k",
      "--time-scale",  "10"};
  setenv("XDG_STATE_HOME", folder.at("state").c_str(), 1);
  const Ended told = sinew(words);
  unsetenv("XDG_STATE_HOME");
  EXPECT_EQ(told.exit, 0) << told.err << told.out;
}

TEST(LeftOut, arm_of_a_cell_without_its_elbow_homes_and_moves_and_tells_what_is_unknown) {
  const ScratchFolder folder;
  setenv("XDG_STATE_HOME", folder.at("state").c_str(), 1);
  small_robot_arm_2(folder, true);
  Process serve({"serve",
                 folder.file("cell.toml",
                             "title = \"One board missing\"\ntime_scale = 40\n"
                             "[[robot]]\nname = \"arm\"\nrobot = \"small.toml\"\n"
                             "without = [\"J3\"]\n"),
                 "--socket", folder.at("s")});
  unsetenv("XDG_STATE_HOME");
  serve.wait_for_err("answers on");
  const auto ask = [&](Arguments words) {
    words.insert(words.end(), {"--socket", folder.at("s")});
    return sinew(words);
  };
  const Ended home = ask({"home", "arm"});
  EXPECT_EQ(home.exit, 0) << home.err;
  const Ended moved = ask({"move", "arm", "joint base=3deg wrist_bend=-2deg"});
  EXPECT_EQ(moved.exit, 0) << moved.err;
  const Json status = ask({"status", "arm", "--json"}).json()["robots"][0];
  for (std::size_t j = 0; j < 6; ++j) {
    EXPECT_EQ(status["joints"][j]["quality"] == "lost", j == 2) << status.dump();
  }
  EXPECT_NEAR(status["joints"][0]["position_rad"].get<double>(), 0.0524, 0.01);
  for (const char* row : {"line dx=1mm", "joint elbow=1deg", "joint d.elbow=1deg"}) {
    const Ended refused = ask({"move", "arm", row});
    EXPECT_EQ(refused.exit, 1) << row;
    EXPECT_NE(refused.err.find("elbow (J3) is left out"), std::string::npos) << refused.err;
  }
}

TEST(LeftOut, choice_that_cannot_be_made_is_refused_in_a_sentence) {
  const ScratchFolder folder;
  const std::string program = folder.file("p.sinew", "joint base=1deg\n");
  const auto says = [&](const Arguments& words, const char* what) {
    const Ended ended = sinew(words);
    EXPECT_EQ(ended.exit, 2) << ended.err;
    EXPECT_NE(ended.err.find(what), std::string::npos) << ended.err;
  };
  says({"check", program, "--robot", "robot-arm-2", "--without", "J9"}, "is no joint");
  says({"plan", program, "--robot", "learm", "--without", "J3"}, "has one controller for all");
  says({"run", program, "--robot", "robot-arm-2", "--without", "J1,J2,J3,J4,J5,J6"},
       "at least one must stay");
  says({"serve", folder.file("cell.toml",
                             "title = \"x\"\n[[robot]]\nname = \"arm\"\n"
                             "robot = \"learm\"\nwithout = [\"J3\"]\n")},
       "has one controller for all");
  const Ended fine = sinew({"check", program, "--robot", "robot-arm-2", "--without", "J6"});
  EXPECT_EQ(fine.exit, 0) << fine.err;
}

}  // namespace
}  // namespace sinew::test
