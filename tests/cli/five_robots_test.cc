#include <gtest/gtest.h>

#include <cmath>
#include <csignal>
#include <iostream>
#include <map>

#include "cli/process.h"
#include "cli/small_arm.h"
#include "support/scratch_folder.h"

/// `sinew run` in one process, `sinew sim` in another, their bytes between them: each robot ends
/// where the program said, as the physics of the simulation has it.
namespace sinew::test {
namespace {

struct RobotRun {
  std::string robot;
  std::vector<std::string> options;  ///< of sim and run alike
  std::string time_scale;            ///< of both; of run only where the boards sit on SPI
  std::string program;
  std::vector<double> target;  ///< deg or mm, every joint, at the end
  double tolerance;            ///< deg or mm: the wire's resolution, backlash, a servo's dead band
  bool on_spi = false;
  bool link = false;  ///< our own boards on it
};

class FiveRobots : public ::testing::TestWithParam<RobotRun> {};

std::string place_of(Process& sim) {
  sim.wait_for_out("\n");
  return sim.out().substr(0, sim.out().find('\n'));
}

TEST_P(FiveRobots, end_where_they_were_sent) {
  const RobotRun& c = GetParam();
  const ScratchFolder folder;
  const std::string program = folder.file("p.sinew", c.program);
  const std::string robot = c.on_spi ? small_robot_arm_2(folder, c.link) : c.robot;
  std::vector<std::string> sim_words{"sim", robot, "--json"};
  std::vector<std::string> run_words{"run", program, "--robot", robot, "--json"};
  // Nobody else begins at home.
  if (c.robot == "bigrobotarm" || c.robot == "hexapod") {
    run_words.insert(run_words.end(), {"--standing-at", "home"});
  }
  if (!c.on_spi) sim_words.insert(sim_words.end(), {"--time-scale", c.time_scale});
  run_words.insert(run_words.end(), {"--time-scale", c.time_scale});
  sim_words.insert(sim_words.end(), c.options.begin(), c.options.end());
  run_words.insert(run_words.end(), c.options.begin(), c.options.end());
  if (c.on_spi) sim_words.insert(sim_words.end(), {"--simwire", "unix:" + folder.at("boards")});

  Ended run, ended;
  for (int tries = 1; tries == 1 || (run.was_late() && tries <= kTriesWhereLate); ++tries) {
    if (tries > 1) std::cout << "  too late for each other, again: " << run.err;
    Process sim(sim_words);
    const Json first = Json::parse(place_of(sim), nullptr, false);
    ASSERT_TRUE(first.is_object()) << sim.out();
    Arguments words = run_words;
    words.insert(words.end(), {"--port", first["port"].get<std::string>()});
    run = sinew(words);
    sim.signal(SIGINT);
    ended = sim.end();
    ASSERT_EQ(ended.exit, 0) << ended.err;
  }
  EXPECT_EQ(run.exit, 0) << run.err << run.out;
  const Json report = run.json();

  const std::string last = ended.out.substr(ended.out.find('\n') + 1);
  const Json truth = Json::parse(last, nullptr, false)["truth"];
  ASSERT_EQ(truth["joints"].size(), c.target.size()) << last;
  for (std::size_t i = 0; i < c.target.size(); ++i) {
    const Json& joint = truth["joints"][i];
    const double q =
        joint.contains("q_deg") ? joint["q_deg"].get<double>() : joint["q_mm"].get<double>();
    EXPECT_NEAR(q, c.target[i], c.tolerance) << joint.dump();
    const Json& known = report["positions"][i];
    EXPECT_TRUE(known["quality"] == "commanded" || known["quality"] == "measured") << known.dump();
  }
}

constexpr const char* kRobotArm2 =
    "home\njoint J1=5deg J2=-3deg J3=4deg J4=0deg J5=2deg J6=-5deg\n";
const std::vector<double> kRobotArm2Target{5, -3, 4, 0, 2, -5};
constexpr const char* kLearm =
    "joint base=0deg shoulder=5deg elbow=10deg wrist=10deg roll=0deg\n"
    "joint base=30deg wrist=20deg\njaws 20mm\n";
const std::vector<double> kLearmTarget{30, 5, 10, 20, 0};

INSTANTIATE_TEST_SUITE_P(
    Robots, FiveRobots,
    ::testing::Values(
        RobotRun{"robot-arm-2",
                 {"--profile", "document"},
                 "40",
                 kRobotArm2,
                 kRobotArm2Target,
                 0.6,
                 true},
        RobotRun{"robot-arm-2", {}, "20", kRobotArm2, kRobotArm2Target, 0.3, true, true},
        RobotRun{"learm", {"--profile", "lsc6"}, "1", kLearm, kLearmTarget, 0.6},
        RobotRun{"learm", {"--profile", "bus"}, "1", kLearm, kLearmTarget, 0.8},
        RobotRun{"learm", {"--profile", "esp32"}, "1", kLearm, kLearmTarget, 0.6},
        RobotRun{"bigrobotarm",
                 {"--profile", "document"},
                 "2",
                 "joint base=30deg shoulder=20deg elbow=-25deg\njoint wrist=40deg\ngripper 60deg\n",
                 {30, 20, -25, 0, 40},
                 0.6},
        RobotRun{"bigrobotarm",
                 {"--profile", "as-built", "--wire", "text2026"},
                 "1",
                 "joint base=30deg shoulder=20deg\n",
                 {30, 20, 0, 0, 0},
                 0.6},
        RobotRun{"bigrobotarm",
                 {"--wire", "framed"},
                 "2",
                 "joint base=30deg shoulder=20deg elbow=-25deg\njoint wrist=40deg\ngripper 60deg\n"
                 "line dz=-20mm blend=5mm\nline dz=20mm\n",
                 {30, 20, -25, 0, 40},
                 0.6},
        RobotRun{"maxarm",
                 {"--profile", "arduino"},
                 "1",
                 "joint base=120deg shoulder=110deg forearm=30deg\njoint base=90deg\nsuction on\n",
                 {90, 110, 30},
                 1.0},
        RobotRun{"maxarm",
                 {"--profile", "micropython"},
                 "1",
                 "joint base=120deg shoulder=110deg forearm=30deg\n",
                 {120, 110, 30},
                 1.0},
        RobotRun{"puma560",
                 {"--seed", "7"},
                 "1",
                 "joint waist=30deg shoulder=20deg elbow=-60deg wrist_bend=40deg\n"
                 "line dx=20mm dz=-10mm\njoint waist=10deg shoulder=15deg elbow=-50deg "
                 "forearm_roll=5deg wrist_bend=30deg flange_roll=0deg\n",
                 {10, 15, -50, 5, 30, 0},
                 0.001},
        RobotRun{"hexapod",
                 {"--profile", "table1"},
                 "1",
                 "joint leg1=268.37mm leg2=268.36mm\njoint leg4=268.355mm\n",
                 {268.37, 268.36, 268.3629, 268.355, 268.3629, 268.3629},
                 0.0005}),
    [](const auto& parameter) {
      std::string name = parameter.param.robot + "_" +
                         (parameter.param.link ? "link" : parameter.param.options.back());
      for (char& c : name) {
        if (c == '-') c = '_';
      }
      return name;
    });

TEST(RunProgram, everything_wrong_is_said_before_a_byte_leaves) {
  const ScratchFolder folder;
  const auto program = [&](const std::string& text) { return folder.file("p.sinew", text); };
  const struct {
    std::string robot;
    std::string text;
    std::vector<std::string> options;
    int exit;
    std::string sentence;
  } kCases[] = {
      {"learm",
       "joint base=91deg",
       {},
       1,
       "base would need 91 deg, limit 90 deg, 1 deg too far; nothing was moved"},
      {"learm", "jont base=1deg", {}, 2, "p.sinew:1:1: unknown step 'jont'; did you mean joint?"},
      {"learm", "# nothing\n", {}, 2, "has no step; a first line could be: joint base=10deg"},
      {"learm", "home", {"--profile", "lsc7"}, 2, "--profile: 'lsc7' is none of lsc6, bus, esp32"},
      {"learm", "home", {"--wire", "text"}, 2, "--wire: 'text' is unknown: learm has but one"},
      {"learm",
       "joint base=1deg\nsuction on",
       {},
       1,
       "p.sinew:2: this robot has no such tool: name it in the robot's file, or remove the row; "
       "nothing was moved"},
      {"learm", "jaws 61mm", {}, 1, "jaws of 61 mm are asked for; they open from 0 to 60 mm"},
      {"maxarm", "nozzle 181deg time=1s", {}, 1, "the tool would need 181 deg, limit 180 deg"},
      {"learm", "wait 1s", {"--seed", "-1"}, 2, "--seed: -1 is negative"},
      {"hexapod", "wait 1s", {"--standing-at", "1,2"}, 2, "--standing-at: 6 numbers are wanted"},
      {"hexapod",
       "wait 1s",
       {"--standing-at", "100,200,200,200,200,200"},
       2,
       "--standing-at: leg1 would need 100 mm, limit 195 mm"},
      {"hexapod", "joint leg1=268mm", {"--port", "/dev/null"}, 1, "/dev/null: not a serial port"},
      {"robot-arm-2", "home", {"--port", "simwire:unix:/nowhere/s"}, 1, "/nowhere/s: no such file"},
      {"robot-arm-2",
       "home",
       {"--port", "/dev/ttyS9"},
       1,
       "this robot hangs on SPI; its port is spidev, simwire:unix:PATH or"},
      {"robot-arm-2", "home", {"--port", "spidev"}, 1, "/dev/spidev0.0: "},
      {"learm",
       "wait 1s",
       {"--port", "simwire:unix:/nowhere/s"},
       1,
       "learm hangs on a serial port, not on SPI; its port is a device as"},
      {"learm",
       "home",
       {"--port", "/dev/nothing", "--time-scale", "2"},
       2,
       "--time-scale: a real port keeps real time"},
  };
  for (const auto& c : kCases) {
    std::vector<std::string> words{"run", program(c.text), "--robot", c.robot};
    words.insert(words.end(), c.options.begin(), c.options.end());
    const Ended ended = sinew(words);
    EXPECT_EQ(ended.exit, c.exit) << c.sentence << "\n" << ended.err;
    EXPECT_NE(ended.err.find(c.sentence), std::string::npos) << c.sentence << "\n" << ended.err;
  }
}

TEST(RunProgram, machine_that_nobody_knows_the_place_of_is_not_moved) {
  const ScratchFolder folder;
  Process sim({"sim", "hexapod", "--json"});
  const Json first = Json::parse(place_of(sim), nullptr, false);
  const Ended run = sinew({"run", folder.file("p.sinew", "joint leg1=268.4mm\n"), "--robot",
                           "hexapod", "--port", first["port"].get<std::string>(), "--json"});
  EXPECT_EQ(run.exit, 1);
  EXPECT_EQ(run.json()["refusal"]["code"], "position_unknown") << run.out;
  EXPECT_EQ(run.json()["orders"].size(), 0U);
}

TEST(DeviceVerb, hexapod_is_read_jogged_waked_and_killed_for_good) {
  Process sim({"sim", "hexapod", "--json"});
  const std::string port = Json::parse(place_of(sim), nullptr, false)["port"].get<std::string>();
  const auto device = [&](std::vector<std::string> words) {
    words.insert(words.begin(), {"device", "hexapod"});
    words.insert(words.end(), {"--port", port, "--json"});
    return sinew(words);
  };
  const Ended status = device({"status"});
  ASSERT_EQ(status.exit, 0) << status.err;
  EXPECT_EQ(status.json()["legs"].size(), 6U);
  EXPECT_EQ(status.json()["legs"][0]["bytes"], "E1 DD FF 6F 00 02 00 00 00 00 00 F8");
  EXPECT_EQ(device({"wake"}).exit, 0);
  EXPECT_EQ(device({"jog", "--leg", "2", "--steps", "-30"}).exit, 0);
  EXPECT_EQ(device({"status"}).json()["legs"][1]["target_units"], -1);
  EXPECT_EQ(device({"jog", "--leg", "7", "--steps", "1"}).exit, 2);
  EXPECT_EQ(device({"jog", "--leg", "1"}).exit, 2);
  EXPECT_EQ(device({"dance"}).exit, 2);
  EXPECT_EQ(device({"kill"}).exit, 0);
  const Ended dead = device({"status"});
  EXPECT_EQ(dead.exit, 1);
  EXPECT_NE(dead.err.find("replies only after it was switched off and on"), std::string::npos)
      << dead.err;
  EXPECT_EQ(dead.err.find("cut its power"), std::string::npos) << "it may be a busy computer";
  sim.signal(SIGINT);
  const std::string out = sim.end().out;
  const Json truth = Json::parse(out.substr(out.find('\n') + 1), nullptr, false)["truth"];
  EXPECT_NEAR(truth["joints"][1]["q_mm"].get<double>(), 268.3629 - 30 * 0.7 / 3200, 5e-4);
}

TEST(Doctor, first_firmware_is_recognised_where_the_robots_file_says_document) {
  const ScratchFolder folder;
  Process sim({"sim", "robot-arm-2", "--profile", "as-built", "--simwire",
               "unix:" + folder.at("boards"), "--json"});
  const std::string port = Json::parse(place_of(sim), nullptr, false)["port"].get<std::string>();
  const std::string advice = "looks like boards with the first firmware; try --profile as-built";
  const Arguments doctor{"doctor", "--robot", "robot-arm-2", "--port", port};
  const Ended asked = sinew(doctor);
  EXPECT_EQ(asked.exit, 1);
  EXPECT_NE(asked.err.find(advice), std::string::npos) << asked.err;
  const Ended run =
      sinew({"run", folder.file("p.sinew", "home\n"), "--robot", "robot-arm-2", "--port", port});
  EXPECT_EQ(run.exit, 1);
  EXPECT_NE(run.err.find(advice), std::string::npos) << run.err;
  // What ended the run is latched in the boards, and says how it is released.
  const Ended released =
      sinew({"device", "robot-arm-2", "release", "--profile", "as-built", "--port", port});
  EXPECT_EQ(released.exit, 0) << released.err;
  Arguments as_built = doctor;
  as_built.insert(as_built.end(), {"--profile", "as-built"});
  const Ended known = sinew(as_built);
  EXPECT_EQ(known.exit, 0) << known.err;
  EXPECT_EQ(known.err.find(advice), std::string::npos) << known.err;
  EXPECT_EQ(sinew({"doctor", "--profile", "as-built"}).exit, 2);
}

TEST(DeviceVerb, boards_of_the_axis_link_are_set_up_for_the_robots_file) {
  const ScratchFolder folder;
  const std::string was = std::string(SINEW_SOURCE_DIR) + "/robots/examples/ar4-axis-link.toml";
  std::string text = text_of(was);
  const std::string fast =
      R"(name = "hand",     lower_deg = -180, upper_deg = 180, velocity_deg_s_max = 60)";
  const std::size_t place = text.find(fast);
  ASSERT_NE(place, std::string::npos);
  text.replace(place + fast.size() - 2, 2, "50");
  const std::string now = folder.file("mine.toml", text);
  Process sim({"sim", was, "--simwire", "unix:" + folder.at("boards"), "--json"});
  const std::string port = Json::parse(place_of(sim), nullptr, false)["port"].get<std::string>();
  const Ended other = sinew({"doctor", "--robot", now, "--port", port});
  EXPECT_EQ(other.exit, 1);
  EXPECT_NE(other.err.find("J6 is set up for another axis or robot"), std::string::npos)
      << other.err;
  const Ended set_up = sinew({"device", now, "setup", "--port", port, "--json"});
  ASSERT_EQ(set_up.exit, 0) << set_up.err;
  const Json boards = set_up.json()["boards"];
  ASSERT_EQ(boards.size(), 6U);
  for (std::size_t i = 0; i < 6; ++i) EXPECT_EQ(boards[i]["written"], i == 5) << boards;
  EXPECT_EQ(sinew({"doctor", "--robot", now, "--port", port}).exit, 0);
  const Ended again = sinew({"device", now, "setup", "--port", port});
  EXPECT_EQ(again.exit, 0) << again.err;
  EXPECT_NE(again.out.find("hand: has this setup already"), std::string::npos) << again.out;
  const Ended registers = sinew({"device", "robot-arm-2", "setup", "--port", port});
  EXPECT_EQ(registers.exit, 1);
  EXPECT_NE(registers.err.find("--wire link"), std::string::npos) << registers.err;
}

TEST(Doctor, silent_boards_are_named_and_a_program_that_needs_them_moves_nothing) {
  for (const std::string wire : {"registers", "link"}) {
    const ScratchFolder folder;
    std::vector<double> bases;
    for (const bool runs : {false, true}) {
      Process sim({"sim", "robot-arm-2", "--wire", wire, "--slaves", "3", "--simwire",
                   "unix:" + folder.at(runs ? "b" : "a"), "--json"});
      const std::string port = Json::parse(place_of(sim), nullptr, false)["port"];
      const std::string names = "3 of 6 boards do not answer: J4, J5, J6";
      const Arguments words{"--robot", "robot-arm-2", "--wire", wire, "--port", port};
      Arguments asks{runs ? "run" : "doctor"};
      if (runs) asks.push_back(folder.file("p.sinew", "home\n"));
      asks.insert(asks.end(), words.begin(), words.end());
      const Ended asked = sinew(asks);
      EXPECT_EQ(asked.exit, 1);
      EXPECT_NE(asked.err.find(names), std::string::npos) << asked.err;
      const bool first = asked.err.find("the board of forearm_roll did not") != std::string::npos;
      EXPECT_EQ(first, runs) << asked.err;
      sim.signal(SIGINT);
      const std::string out = sim.end().out;
      const Json truth = Json::parse(out.substr(out.find('\n') + 1), nullptr, false)["truth"];
      bases.push_back(truth["joints"][0]["q_deg"].get<double>());
    }
    // As it came to rest when its current came on.
    EXPECT_NEAR(bases[1], bases[0], 0.05) << wire;
  }
}

TEST(SimVerb, truth_is_told_on_request) {
  Process sim({"sim", "learm", "--seed", "5"});
  place_of(sim);
  sim.signal(SIGUSR1);
  sim.wait_for_err("truth: base ");
  sim.signal(SIGINT);
  const Ended ended = sim.end();
  EXPECT_EQ(ended.exit, 0);
  EXPECT_NE(ended.err.find("; supply "), std::string::npos) << ended.err;
}

TEST(SimVerb, options_that_make_no_sense_are_refused) {
  const struct {
    std::vector<std::string> words;
    std::string sentence;
  } kCases[] = {
      {{"sim", "learm", "--simwire", "stdio"},
       "--simwire: learm hangs on a serial port, not on SPI"},
      {{"sim", "learm", "--nss", "soft"}, "--nss: learm hangs on a serial port"},
      {{"sim", "robot-arm-2", "--simwire", "tcp:1"}, "'tcp:1' is neither unix:PATH nor stdio"},
      {{"sim", "robot-arm-2", "--slaves", "7"}, "--slaves: 7 is outside 1..6"},
      {{"sim", "robot-arm-2", "--slaves", "0"}, "--slaves: 0 is outside 1..6"},
      {{"sim", "robot-arm-2", "--nss", "none"}, "--nss: 'none' is neither hard nor soft"},
      {{"sim", "robot-arm-2", "--link", "/tmp/x"}, "--link: boards on SPI have no port"},
      {{"sim", "robot-arm-2", "--time-scale", "2"}, "over simwire the time is the host's"},
      {{"sim", "robot-arm-2", "--fault", "delay=0.1:5ms"}, "delay cannot befall SPI"},
      {{"sim", "hexapod", "--fault", "drop=2"}, "--fault: "},
      {{"sim", "hexapod", "--fault", "block=J9@1mm@1s"}, "--fault: "},
      {{"sim", "robot-arm-2", "--fault", "block=J2@20mm@1s"},
       "--fault: block=J2: shoulder is a joint that turns; its place is an angle, as 20deg"},
      {{"sim", "learm", "--fault", "magnet=J1:off@1s"}, "learm has no magnet that could fall off"},
      {{"sim", "hexapod", "--profile", "x"}, "--profile: 'x' is none of table1"},
  };
  for (const auto& c : kCases) {
    const Ended ended = sinew(c.words);
    EXPECT_EQ(ended.exit, 2) << c.sentence << ended.err;
    EXPECT_NE(ended.err.find(c.sentence), std::string::npos) << c.sentence << "\n" << ended.err;
  }
}

}  // namespace
}  // namespace sinew::test
