#include <gtest/gtest.h>

#include <csignal>
#include <cstdlib>
#include <memory>

#include "cli/process.h"
#include "support/scratch_folder.h"

/// One machine that several position journals are named for: what is said of its position is true.
namespace sinew::test {
namespace {

/// An arm whose board can lose its power, behind a link, and those who use it.
class OneMachine : public ::testing::Test {
 protected:
  OneMachine() {
    setenv("XDG_STATE_HOME", folder_.at("xdg").c_str(), 1);
    power_on();
  }
  ~OneMachine() override { unsetenv("XDG_STATE_HOME"); }

  void power_on() {
    sim_ = std::make_unique<Process>(Arguments{"sim", "bigrobotarm", "--json", "--time-scale", "20",
                                               "--state", folder_.at("state"), "--link", link_});
    const std::string first = sim_->line_after(0);
    told_ = first.size() + 1;
    port_ = Json::parse(first).at("port");
  }
  void power_cycle() {
    sim_->signal(SIGKILL);
    sim_->end();
    power_on();
  }
  double truth() {
    sim_->signal(SIGUSR1);
    const std::string line = sim_->line_after(told_);
    told_ += line.size() + 1;
    return Json::parse(line).at("truth").at("joints").at(0).at("q_deg");
  }
  /// @param journal  empty: none is named
  Ended run(const std::string& journal, const std::string& program,
            const std::string& standing_at = "", const std::string& port = "") {
    Arguments words{"run",    folder_.file("p.sinew", program), "--robot", "bigrobotarm",
                    "--port", port.empty() ? link_ : port,      "--json",  "--record",
                    "none"};
    if (!journal.empty()) words.insert(words.end(), {"--journal", journal});
    if (!standing_at.empty()) words.insert(words.end(), {"--standing-at", standing_at});
    return sinew(words);
  }
  static std::string found(const Ended& ended) { return ended.json()["position_journal"]["found"]; }
  /// That the base is known, and where.
  void expect_known(const Ended& ended) {
    EXPECT_EQ(ended.exit, 0) << ended.err;
    const Json base = ended.json()["positions"][0];
    ASSERT_NE(base["quality"], "lost") << ended.out;
    EXPECT_LE(base["lower_deg"].get<double>(), truth() + 0.05);
    EXPECT_GE(base["upper_deg"].get<double>(), truth() - 0.05);
  }

  ScratchFolder folder_;
  std::string link_ = folder_.at("arm");
  std::string port_;
  std::unique_ptr<Process> sim_;
  std::size_t told_ = 0;
};

constexpr const char* kLook = "wait 0.01s\n";

TEST_F(OneMachine, journal_that_was_not_there_continues_from_the_one_that_was) {
  EXPECT_EQ(run("bigrobotarm", "joint base=40deg\n", "home").exit, 0);
  power_cycle();
  const Ended other = run("big", "joint base=80deg\n", "40deg,0deg,0deg,0deg,0deg");
  EXPECT_EQ(other.exit, 0) << other.err;
  EXPECT_NE(found(other).find("'bigrobotarm' followed the machine"), std::string::npos);
  EXPECT_NEAR(truth(), 80, 1);
  const Ended back = run("bigrobotarm", kLook);
  expect_known(back);
  EXPECT_NE(found(back).find("'big' followed the machine on " + link_ +
                             " last; 'bigrobotarm' "
                             "continues from it"),
            std::string::npos)
      << found(back);
  // From then on it is the one.
  EXPECT_EQ(found(run("bigrobotarm", kLook)), "the last run ended in order");
  expect_known(run("big", "joint base=20deg\n", "", port_));
}

TEST_F(OneMachine, run_without_a_journal_takes_what_one_says_away) {
  EXPECT_EQ(run("arm", "joint base=30deg\n", "home").exit, 0);
  // Nothing moves: the journal still knows.
  EXPECT_EQ(run("", kLook, "30deg,0deg,0deg,0deg,0deg", port_).exit, 0);
  expect_known(run("arm", "joint base=31deg\n"));
  EXPECT_EQ(run("", "joint base=50deg\n", "31deg,0deg,0deg,0deg,0deg", port_).exit, 0);
  const Ended lost = run("arm", "joint base=0deg\n");
  EXPECT_EQ(lost.exit, 1);
  EXPECT_NE(lost.err.find("a run without --journal moved the machine"), std::string::npos)
      << lost.err;
  EXPECT_NE(lost.err.find("--standing-at"), std::string::npos) << lost.err;
  EXPECT_NEAR(truth(), 50, 1);
  EXPECT_EQ(run("arm", "joint base=0deg\n", "50deg,0deg,0deg,0deg,0deg").exit, 0);
}

TEST_F(OneMachine, cell_and_run_agree) {
  EXPECT_EQ(run("bigrobotarm", "joint base=10deg\n", "home").exit, 0);
  const std::string cell =
      folder_.file("cell.toml",
                   "title = \"One\"\n[[robot]]\nname = \"big\"\nrobot = \"bigrobotarm\"\njournal = "
                   "\"big\"\nport = \"" +
                       link_ + "\"\n");
  const std::string socket = folder_.at("s");
  {
    Process serve({"serve", cell, "--socket", socket});
    serve.wait_for_err("answers on");
    serve.wait_for_err("'big' continues from it");
    const Ended moved = sinew({"move", "big", "joint", "base=25deg", "--socket", socket});
    EXPECT_EQ(moved.exit, 0) << moved.err;
    const Ended held = run("bigrobotarm", kLook);
    EXPECT_EQ(held.exit, 1);
    EXPECT_NE(held.err.find(link_), std::string::npos) << held.err;
    serve.signal(SIGINT);
    EXPECT_EQ(serve.end().exit, 0);
  }
  const Ended back = run("bigrobotarm", kLook);
  expect_known(back);
  EXPECT_NEAR(back.json()["positions"][0]["q_deg"].get<double>(), 25, 0.1);
}

}  // namespace
}  // namespace sinew::test
