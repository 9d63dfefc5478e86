#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <csignal>
#include <cstdlib>
#include <iostream>
#include <optional>

#include "cli/process.h"
#include "support/how_many.h"
#include "support/property.h"
#include "support/scratch_folder.h"

/// kill -9 at random instants of a running program, a real process on a real disk, while the
/// simulated machine goes on: what the next process says about the position is true.
namespace sinew::test {
namespace {

using namespace std::chrono_literals;

constexpr double kReadyAgain = 2;  // s

/// Real kills of each robot.
std::int64_t kills() {
  return static_cast<std::int64_t>(how_many("SINEW_KILLS", 20, 5));
}

struct Machine {
  const char* robot;
  const char* unit;  ///< of its joints
  /// Moves to and fro, for longer than any life lasts.
  const char* program;
  double resolution;  ///< of what the wire says and the motor trails by; unit
};

void PrintTo(const Machine& machine, std::ostream* out) {
  *out << machine.robot;
}

struct Known {
  std::string quality;
  double q = 0, lower = 0, upper = 0;
};

/// A machine, its journal, and the processes that come and go.
class KillCell {
 public:
  explicit KillCell(const Machine& machine) : machine_(machine) {
    setenv("XDG_STATE_HOME", folder_.at("state").c_str(), 1);
    switch_on();
    long_program_ = folder_.file("long.sinew", machine.program);
    look_ = folder_.file("look.sinew", "wait 0.01s\n");
  }

  /// A machine that begins anew, at its home; it was off.
  void switch_on() {
    sim_.reset();
    sim_.emplace(Arguments{"sim", machine_.robot, "--json"});
    const Json first = Json::parse(sim_->line_after(0), nullptr, false);
    port_ = first.at("port").get<std::string>();
    told_ = sim_->out().size();
  }

  /// Where the physics of the simulation has the joints.
  std::vector<double> truth() {
    sim_->signal(SIGUSR1);
    const std::string line = sim_->line_after(told_);
    told_ += line.size() + 1;
    std::vector<double> q;
    const Json told = Json::parse(line, nullptr, false);
    for (const Json& joint : told["truth"]["joints"]) {
      q.push_back(joint[std::string("q_") + machine_.unit].get<double>());
    }
    return q;
  }

  Arguments words(const std::string& program) const {
    return {"run", program, "--robot", machine_.robot, "--port", port_, "--journal", "k", "--json"};
  }

  /// A life that is cut off after so long. @param standing_at  where somebody says it stands
  void live_and_be_killed(std::chrono::milliseconds life, const std::string& standing_at) {
    Arguments all = words(long_program_);
    if (!standing_at.empty()) all.insert(all.end(), {"--standing-at", standing_at});
    Process run(all);
    run.let_run(life);
    run.signal(SIGKILL);
    const Ended ended = run.end();
    EXPECT_EQ(ended.exit, -SIGKILL) << ended.out << ended.err;
  }

  /// A life that is cut off so long after its machine has begun to move.
  void move_and_be_killed(std::chrono::milliseconds life, const std::string& standing_at) {
    const std::vector<double> before = truth();
    Arguments all = words(long_program_);
    if (!standing_at.empty()) all.insert(all.end(), {"--standing-at", standing_at});
    Process run(all);
    for (int looks = 0; looks < 500 && std::abs(truth()[0] - before[0]) < 0.5; ++looks) {
      run.let_run(20ms);
    }
    run.let_run(life);
    run.signal(SIGKILL);
    EXPECT_EQ(run.end().exit, -SIGKILL);
  }

  /// A run that has to be refused. @return  why
  std::string refusal(const std::string& program, const std::string& standing_at) {
    Arguments all = words(folder_.file("refused.sinew", program));
    if (!standing_at.empty()) all.insert(all.end(), {"--standing-at", standing_at});
    const Ended ended = sinew(all);
    EXPECT_NE(ended.exit, 0) << ended.out;
    return ended.err + ended.out;
  }

  /// What the next process says, and how long it took from its start to its end.
  std::vector<Known> look(double* seconds) {
    Ended ended;
    for (int tries = 1; tries == 1 || (ended.was_late() && tries <= kTriesWhereLate); ++tries) {
      if (tries > 1) std::cout << "  too late for each other, again: " << ended.err;
      const auto begin = std::chrono::steady_clock::now();
      ended = sinew(words(look_));
      *seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
    }
    EXPECT_EQ(ended.exit, 0) << ended.err;
    std::vector<Known> known;
    const std::string unit = machine_.unit;
    const Json report = ended.json();
    for (const Json& joint : report["positions"]) {
      Known one{joint["quality"], 0, 0, 0};
      if (one.quality != "lost") {
        one.q = joint["q_" + unit];
        one.lower = joint["lower_" + unit];
        one.upper = joint["upper_" + unit];
      }
      known.push_back(one);
    }
    return known;
  }

 private:
  Machine machine_;
  ScratchFolder folder_;
  std::optional<Process> sim_;
  std::size_t told_ = 0;
  std::string port_;
  std::string long_program_;
  std::string look_;
};

std::string joined(const std::vector<double>& q, const char* unit) {
  std::string text;
  for (const double one : q) {
    text += (text.empty() ? "" : ",") + std::to_string(one) + unit;
  }
  return text;
}

class Kills : public ::testing::TestWithParam<Machine> {};

TEST_P(Kills, leave_a_position_that_is_true_and_a_machine_that_is_ready_soon) {
  const Machine& machine = GetParam();
  KillCell cell(machine);
  Random random(seed());
  std::string standing_at = "home";
  std::int64_t uncertain = 0, exact = 0, lost = 0;
  std::vector<double> took;
  const std::int64_t lives = kills();
  for (std::int64_t life = 0; life < lives && !HasFailure(); ++life) {
    // From before the first byte to well into the motion.
    const auto length = std::chrono::milliseconds(random.integer(1, 900));
    cell.live_and_be_killed(length, standing_at);
    double seconds = 0;
    const std::vector<Known> known = cell.look(&seconds);
    const std::vector<double> truth = cell.truth();
    took.push_back(seconds);
    ASSERT_EQ(known.size(), truth.size());
    bool whole = true;
    for (std::size_t j = 0; j < known.size(); ++j) {
      const Known& one = known[j];
      lost += one.quality == "lost" ? 1 : 0;
      uncertain += one.quality == "uncertain" ? 1 : 0;
      exact += one.quality == "commanded" || one.quality == "measured" ? 1 : 0;
      whole &= one.quality == "commanded" || one.quality == "measured";
      if (one.quality == "lost") continue;
      const bool true_said =
          truth[j] >= one.lower - machine.resolution && truth[j] <= one.upper + machine.resolution;
      EXPECT_TRUE(true_said) << "life " << life << " of " << length.count()
                             << " ms, told to be at '" << standing_at << "': joint " << j + 1
                             << " is " << one.quality << " at " << one.q << " in " << one.lower
                             << " .. " << one.upper << ", and stands at " << truth[j];
    }
    // Somebody looks and says where it stands, where the journal could not.
    standing_at = whole ? "" : joined(truth, machine.unit);
  }
  std::ranges::sort(took);
  // A busy computer may keep any one of them waiting; half of them it will not.
  EXPECT_LT(took[took.size() / 2], kReadyAgain)
      << "s from a dead process to one that has been ready";
  EXPECT_GT(exact, 0);
  std::cout << "  " << lives << " kills; joints exact " << exact << ", uncertain " << uncertain
            << ", lost " << lost << "; ready again in " << took[took.size() / 2] << " s, "
            << took.back() << " s at most; seed " << seed() << "\n";
  RecordProperty("cases", std::to_string(lives));
}

INSTANTIATE_TEST_SUITE_P(
    Robots, Kills,
    ::testing::Values(Machine{"hexapod", "mm",
                              "loop 1000\njoint leg1=268.40mm leg4=268.45mm leg5=268.30mm\n"
                              "joint leg1=268.36mm leg4=268.36mm leg5=268.36mm\nend\n",
                              1e-4},
                      Machine{"bigrobotarm", "deg",
                              "loop 1000\njoint base=4deg wrist=-3deg\n"
                              "joint base=0deg wrist=0deg\nend\n",
                              0.3}),
    [](const auto& machine) { return machine.param.robot; });

const Machine kWideLoop{"bigrobotarm", "deg",
                        "loop 1000\njoint base=60deg\njoint base=-60deg\nend\n", 0.3};

/// It counts on while nobody listens, and its speeds are those that we gave it.
TEST(Killed, in_a_wide_loop_a_board_that_was_never_off_is_known_without_a_word) {
  KillCell cell(kWideLoop);
  Random random(seed());
  std::string standing_at = "home";
  for (int life = 0; life < 4 && !HasFailure(); ++life) {
    cell.move_and_be_killed(std::chrono::milliseconds(random.integer(1, 2500)), standing_at);
    double seconds = 0;
    const std::vector<Known> known = cell.look(&seconds);
    const std::vector<double> truth = cell.truth();
    ASSERT_EQ(known.size(), truth.size());
    for (std::size_t j = 0; j < known.size(); ++j) {
      EXPECT_EQ(known[j].quality, "commanded") << life;
      // Six full steps, 0.22 deg of the base and 0.72 of the wrist's rotation.
      EXPECT_LT(known[j].upper - known[j].lower, j == 0 ? 1.4 : 4.4);
      EXPECT_GE(truth[j], known[j].lower - kWideLoop.resolution);
      EXPECT_LE(truth[j], known[j].upper + kWideLoop.resolution);
    }
    // Whoever says otherwise is refused with both numbers.
    ASSERT_GT(std::abs(truth[0]), 50);
    const std::string why = cell.refusal("joint base=0deg\n", "home");
    EXPECT_NE(why.find("but the device counts"), std::string::npos) << why;
    standing_at.clear();
  }
}

TEST(Killed, in_a_motion_a_board_that_was_reset_meanwhile_has_to_be_looked_at) {
  KillCell cell(kWideLoop);
  cell.move_and_be_killed(300ms, "home");
  cell.switch_on();
  double seconds = 0;
  const std::vector<Known> known = cell.look(&seconds);
  ASSERT_FALSE(known.empty());
  EXPECT_EQ(known[0].quality, "uncertain");
  EXPECT_GT(known[0].upper - known[0].lower, 50);
  const std::string why = cell.refusal("joint base=10deg\n", "");
  EXPECT_NE(why.find("--standing-at"), std::string::npos) << why;
}

}  // namespace
}  // namespace sinew::test
