#include <gtest/gtest.h>

#include <chrono>
#include <cmath>
#include <csignal>
#include <memory>

#include "cli/process.h"
#include "support/scratch_folder.h"

/// `sinew sim --state FILE`: the end of the process is a power cut, and no more than that.
namespace sinew::test {
namespace {

using namespace std::chrono_literals;

/// A simulation with its file, which can die and come back.
class Powered {
 public:
  Powered(const std::string& robot, const std::string& file, const Arguments& more = {}) {
    Arguments words{"sim", robot, "--json", "--state", file};
    words.insert(words.end(), more.begin(), more.end());
    sim_ = std::make_unique<Process>(words);
    const std::string first = sim_->line_after(0);
    seen_ = first.size() + 1;
    port_ = Json::parse(first).at("port");
  }

  const std::string& port() const { return port_; }
  Json truth() {
    sim_->signal(SIGUSR1);
    const std::string line = sim_->line_after(seen_);
    seen_ += line.size() + 1;
    return Json::parse(line).at("truth");
  }
  /// Of one joint, with its unit: "q_deg".
  double joint(std::size_t index, const std::string& key) {
    return truth().at("joints").at(index).at(key);
  }
  void end(int signal) {
    sim_->signal(signal);
    EXPECT_EQ(sim_->end().exit, signal == SIGKILL ? -SIGKILL : 0);
  }

 private:
  std::unique_ptr<Process> sim_;
  std::size_t seen_ = 0;
  std::string port_;
};

struct Arm {
  const char* robot;
  const char* unit;
  std::vector<std::string> said;  ///< what `sinew run` is told of the position
  const char* program;            ///< moves the first joint up, for seconds
  double far_enough;              ///< unit; so far it has come when the power goes
  /// Unit: motion in a few ms, and how far the rotor springs when the current comes back.
  double lost;
};

void PrintTo(const Arm& arm, std::ostream* out) {
  *out << arm.robot;
}

class SimState : public ::testing::TestWithParam<Arm> {};

/// Moves the first joint, ends the process in motion, and looks where the next one has it.
void cut_in_motion(const Arm& arm, int signal) {
  const ScratchFolder folder;
  setenv("XDG_STATE_HOME", folder.at("xdg").c_str(), 1);
  const std::string q = std::string("q_") + arm.unit;
  double cut_at = 0;
  double began_at = 0;
  {
    Powered sim(arm.robot, folder.at("state"));
    Arguments words{"run",       folder.file("up.sinew", arm.program),
                    "--robot",   arm.robot,
                    "--port",    sim.port(),
                    "--journal", "none"};
    words.insert(words.end(), arm.said.begin(), arm.said.end());
    Process run(words);
    began_at = sim.joint(0, q);
    const auto limit = std::chrono::steady_clock::now() + 20s;
    do {
      run.let_run(5ms);
      cut_at = sim.joint(0, q);
      ASSERT_LT(std::chrono::steady_clock::now(), limit) << "it never came so far";
    } while (std::abs(cut_at - began_at) < arm.far_enough);
    sim.end(signal);
    run.signal(SIGKILL);
    run.end();
  }
  Powered again(arm.robot, folder.at("state"));
  const double stands_at = again.joint(0, q);
  // It went on until the process was dead, which a busy computer may delay; it never went back.
  const double direction = cut_at > began_at ? 1 : -1;
  EXPECT_GE(direction * (stands_at - cut_at), -arm.lost)
      << "it was at " << cut_at << " when the power went, and is at " << stands_at;
}

TEST_P(SimState, kill_9_in_motion_is_a_power_cut_where_the_joints_are) {
  cut_in_motion(GetParam(), SIGKILL);
}

TEST_P(SimState, an_orderly_end_in_motion_is_one_too) {
  cut_in_motion(GetParam(), SIGTERM);
}

INSTANTIATE_TEST_SUITE_P(
    Robots, SimState,
    ::testing::Values(
        Arm{"bigrobotarm", "deg", {"--standing-at", "home"}, "joint base=80deg\n", 10, 0.6},
        Arm{"hexapod", "mm", {"--standing-at", "home"}, "joint leg1=268.5mm\n", 0.01, 1e-3},
        Arm{"puma560", "deg", {}, "joint waist=80deg speed=30%\n", 8, 3},
        // Servos without position feedback are told of all joints first.
        Arm{"learm",
            "deg",
            {},
            "joint base=0deg shoulder=0deg elbow=0deg wrist=0deg roll=0deg\n"
            "joint base=80deg speed=10%\njoint base=0deg speed=10%\n",
            4,
            3},
        Arm{"maxarm",
            "deg",
            {},
            "joint base=150deg speed=10%\njoint base=90deg speed=10%\n",
            8,
            1}),
    [](const auto& arm) { return std::string(arm.param.robot); });

TEST(SimState, counters_of_the_big_arm_are_0_where_it_stands) {
  const ScratchFolder folder;
  setenv("XDG_STATE_HOME", folder.at("xdg").c_str(), 1);
  {
    Powered sim("bigrobotarm", folder.at("state"), {"--time-scale", "20"});
    const Ended run =
        sinew({"run", folder.file("up.sinew", "joint base=40deg\n"), "--robot", "bigrobotarm",
               "--port", sim.port(), "--journal", "none", "--standing-at", "home"});
    ASSERT_EQ(run.exit, 0) << run.err;
    EXPECT_NEAR(sim.joint(0, "believed_deg"), 40, 0.1);
    sim.end(SIGKILL);
  }
  Powered again("bigrobotarm", folder.at("state"));
  EXPECT_NEAR(again.joint(0, "q_deg"), 40, 0.6);
  EXPECT_EQ(again.joint(0, "believed_deg"), 0);
}

/// `sinew run` of one row on the simulation, with a journal of its own.
Arguments run_of(const ScratchFolder& folder, const Powered& sim, const std::string& row,
                 const Arguments& more = {}) {
  Arguments words{"run",       folder.file("row.sinew", row + "\n"),
                  "--robot",   "bigrobotarm",
                  "--port",    sim.port(),
                  "--journal", "big"};
  words.insert(words.end(), more.begin(), more.end());
  return words;
}

TEST(SimState, who_says_home_is_held_against_the_count_also_on_a_new_journal) {
  const ScratchFolder folder;
  setenv("XDG_STATE_HOME", folder.at("xdg").c_str(), 1);
  Powered sim("bigrobotarm", folder.at("state"), {"--time-scale", "20"});
  const Ended first =
      sinew(run_of(folder, sim, "joint base=40deg shoulder=10deg", {"--standing-at", "home"}));
  ASSERT_EQ(first.exit, 0) << first.err;
  setenv("XDG_STATE_HOME", folder.at("another").c_str(), 1);
  const std::string row = "joint base=45deg";
  const Ended home = sinew(run_of(folder, sim, row, {"--standing-at", "home"}));
  EXPECT_EQ(home.exit, 1) << home.out;
  EXPECT_NE(home.err.find("base is said to stand at 0 deg, but the device counts 40"),
            std::string::npos)
      << home.err;
  std::string script = "* = yes\nplace = home\n";
  for (const char* joint : {"base", "shoulder", "elbow", "wrist_rotate", "wrist"}) {
    script += std::string("adjust.") + joint + " = done\n";
  }
  const Ended recover =
      sinew({"commission", "bigrobotarm", "--procedure", "recover", "--port", sim.port(),
             "--journal", "big", "--answers", folder.file("answers", script)});
  EXPECT_NE(recover.exit, 0);
  EXPECT_NE(recover.err.find("but the device counts 40"), std::string::npos) << recover.err;
  const Ended true_place =
      sinew(run_of(folder, sim, row, {"--standing-at", "40deg,10deg,0deg,0deg,0deg"}));
  EXPECT_EQ(true_place.exit, 0) << true_place.err;
  const Ended shown = sinew(run_of(folder, sim, row, {"--standing-at", "shown"}));
  EXPECT_EQ(shown.exit, 0) << shown.err;
  // Whoever moved it has to say so.
  const Ended moved = sinew(run_of(folder, sim, "joint base=1deg",
                                   {"--standing-at", "home", "--moved", "turned by hand"}));
  EXPECT_EQ(moved.exit, 0) << moved.err;
  EXPECT_EQ(sinew(run_of(folder, sim, row, {"--moved", "turned by hand"})).exit, 2);
}

TEST(SimState, who_dies_in_a_slow_move_of_the_big_arm_is_followed_by_one_that_waits_for_it) {
  const ScratchFolder folder;
  setenv("XDG_STATE_HOME", folder.at("xdg").c_str(), 1);
  Powered sim("bigrobotarm", folder.at("state"));
  {
    Process run(run_of(folder, sim, "joint base=80deg speed=5%", {"--standing-at", "home"}));
    do {
      run.let_run(20ms);
    } while (sim.joint(0, "q_deg") < 5);
    run.signal(SIGKILL);
    run.end();
  }
  const Ended next = sinew(run_of(folder, sim, "joint base=79deg"));
  EXPECT_EQ(next.exit, 0) << next.err;
  EXPECT_NE(next.err.find("may still be finishing a move of the run before"), std::string::npos)
      << next.err;
  EXPECT_NEAR(sim.joint(0, "q_deg"), 79, 0.6);
}

TEST(SimState, an_arm_of_servos_stays_where_it_sank) {
  const ScratchFolder folder;
  double sank_to = 0;
  {
    Powered sim("learm", folder.at("state"), {"--seed", "3"});
    sim.end(SIGKILL);
  }
  {
    Powered sim("learm", folder.at("state"));
    sank_to = sim.joint(1, "q_deg");
    sim.end(SIGKILL);
  }
  Powered again("learm", folder.at("state"));
  EXPECT_NEAR(again.joint(1, "q_deg"), sank_to, 0.01);
}

TEST(SimState, boards_on_spi_keep_their_pose_and_forget_their_zeros) {
  const ScratchFolder folder;
  std::vector<double> before;
  {
    Powered sim("robot-arm-2", folder.at("state"), {"--seed", "3"});
    sim.end(SIGTERM);
  }
  {
    Powered sim("robot-arm-2", folder.at("state"));
    for (const Json& joint : sim.truth().at("joints")) before.push_back(joint.at("q_deg"));
    sim.end(SIGKILL);
  }
  Powered again("robot-arm-2", folder.at("state"));
  for (std::size_t i = 0; i < before.size(); ++i) {
    EXPECT_NEAR(again.joint(i, "q_deg"), before[i], 0.3) << i;
  }
}

TEST(SimState, a_file_of_another_machine_is_refused_with_a_sentence) {
  const ScratchFolder folder;
  {
    Powered sim("learm", folder.at("state"));
    const Ended second = sinew({"sim", "learm", "--state", folder.at("state")});
    EXPECT_EQ(second.exit, 2);
    EXPECT_NE(second.err.find("in use"), std::string::npos) << second.err;
  }
  const auto refused = [&](const Arguments& words, const std::string& sentence) {
    const Ended ended = sinew(words);
    EXPECT_EQ(ended.exit, 2) << sentence;
    EXPECT_NE(ended.err.find(sentence), std::string::npos) << ended.err;
  };
  refused({"sim", "maxarm", "--state", folder.at("state")}, "the state of learm, not of maxarm");
  refused({"sim", "learm", "--seed", "9", "--state", folder.at("state")}, "--seed 1, not 9");
  refused({"sim", "learm", "--state", folder.file("text", "joint base=1deg\n")}, "damaged");
  refused({"sim", "learm", "--log", folder.at("x"), "--state", folder.at("x")}, "another use");
  EXPECT_EQ(text_of(folder.at("text")), "joint base=1deg\n");
}

}  // namespace
}  // namespace sinew::test
