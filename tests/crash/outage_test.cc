#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <csignal>
#include <cstdlib>
#include <iostream>
#include <map>
#include <memory>

#include "cli/process.h"
#include "sinew/io/scratch_folder_test_support.h"
#include "support/how_many.h"
#include "support/property.h"

/// A host and a machine with a power supply, both real processes, and what befalls them: in motion,
/// in the search for zeros and at rest. The machine is never put back to its start. Whatever the
/// next host says of a position is true, and some command that the program knows brings it back.
namespace sinew::test {
namespace {

using namespace std::chrono_literals;

/// Outages of each robot.
std::int64_t outages() {
  return static_cast<std::int64_t>(how_many("SINEW_OUTAGES", 3, 1));
}

enum class Outage : std::uint8_t {
  kHostKilled,  ///< -9
  kHostEnded,   ///< Ctrl-C
  kPowerCut,    ///< of the machine; the host finds its port gone
  kBothCut,     ///< one plug for both
  kSuspended,   ///< the computer sleeps for a while
  kClockJump,   ///< an hour, at once
  kDiskFull,    ///< of the host
};
constexpr int kOutages = 7;
constexpr std::array<const char*, kOutages> kNames{
    "host killed", "host ended", "power cut", "both cut", "suspended", "clock jump", "disk full"};

struct Arm {
  const char* robot;
  const char* unit;
  const char* motion;               ///< a program that moves for longer than any life lasts
  const char* mend;                 ///< brings it to where `motion` may begin
  bool needs_to_be_told;            ///< where it stands: it has no sensors
  double resolution;                ///< unit; of the wire, and what a motor trails by
  std::chrono::milliseconds start;  ///< from a power-up until the device listens
};

void PrintTo(const Arm& arm, std::ostream* out) {
  *out << arm.robot;
}

struct Known {
  std::string quality;
  double lower = 0, upper = 0;
};

class OutageCell {
 public:
  explicit OutageCell(const Arm& arm) : arm_(arm) {
    setenv("XDG_STATE_HOME", folder_.at("xdg").c_str(), 1);
    motion_ = folder_.file("motion.sinew", arm.motion);
    mend_ = folder_.file("mend.sinew", arm.mend);
    look_ = folder_.file("look.sinew", "wait 0.01s\n");
    power_on();
  }

  bool is_on() const { return sim_ != nullptr; }
  void power_on() {
    sim_ = std::make_unique<Process>(Arguments{"sim", arm_.robot, "--json", "--state",
                                               folder_.at("state"), "--link", folder_.at("port")});
    told_ = sim_->line_after(0).size() + 1;
    sim_->let_run(arm_.start);
  }
  void power_off() {
    sim_->signal(SIGKILL);
    sim_->end();
    sim_.reset();
  }

  std::vector<double> truth() {
    sim_->signal(SIGUSR1);
    const std::string line = sim_->line_after(told_);
    told_ += line.size() + 1;
    std::vector<double> q;
    const Json told = Json::parse(line, nullptr, false);
    for (const Json& joint : told["truth"]["joints"]) {
      q.push_back(joint[std::string("q_") + arm_.unit].get<double>());
    }
    return q;
  }
  /// Until nothing moves: a servo board goes on with what it was told last.
  std::vector<double> truth_at_rest() {
    std::vector<double> before = truth();
    for (int i = 0; i < 200; ++i) {
      sim_->let_run(50ms);
      std::vector<double> now = truth();
      double moved = 0;
      for (std::size_t j = 0; j < now.size(); ++j) {
        moved = std::max(moved, std::abs(now[j] - before[j]));
      }
      before = std::move(now);
      if (moved < 0.1 * arm_.resolution) break;
    }
    return before;
  }

  Arguments words(const std::string& program, const std::string& standing_at = "") const {
    Arguments all{"run",       program, "--robot", arm_.robot, "--port", folder_.at("port"),
                  "--journal", "k",     "--json",  "--record", "none"};
    if (!standing_at.empty()) all.insert(all.end(), {"--standing-at", standing_at});
    return all;
  }
  Ended run(const std::string& program, const std::string& standing_at = "") const {
    Ended ended;
    for (int tries = 1; tries == 1 || (ended.was_late() && tries <= kTriesWhereLate); ++tries) {
      ended = sinew(words(program, standing_at));
    }
    return ended;
  }
  Ended look() const { return run(look_); }
  Ended mend(const std::string& standing_at) const { return run(mend_, standing_at); }
  const std::string& motion() const { return motion_; }

 private:
  Arm arm_;
  ScratchFolder folder_;
  std::unique_ptr<Process> sim_;
  std::size_t told_ = 0;
  std::string motion_;
  std::string mend_;
  std::string look_;
};

std::vector<Known> known_of(const Ended& ended, const std::string& unit) {
  std::vector<Known> known;
  const Json report = Json::parse(ended.out, nullptr, false);
  if (!report.is_object() || !report.contains("positions")) return known;
  for (const Json& joint : report["positions"]) {
    Known one{joint["quality"], 0, 0};
    if (one.quality != "lost") {
      one.lower = joint["lower_" + unit];
      one.upper = joint["upper_" + unit];
    }
    known.push_back(one);
  }
  return known;
}

std::string joined(const std::vector<double>& q, const char* unit) {
  std::string text;
  for (const double one : q) text += (text.empty() ? "" : ",") + std::to_string(one) + unit;
  return text;
}

/// A misfortune that the host brings on itself, so many ms after its start.
void set_misfortune(Outage outage, std::int64_t at_ms) {
  if (outage != Outage::kClockJump && outage != Outage::kDiskFull) return;
  const std::string when = std::to_string(at_ms);
  const std::string what =
      outage == Outage::kDiskFull ? "full@" + when : "jump@" + when + ":3600000";
  setenv("LD_PRELOAD", SINEW_MISFORTUNE_LIBRARY, 1);
  setenv("SINEW_MISFORTUNE", what.c_str(), 1);
}

void forget_misfortune() {
  unsetenv("LD_PRELOAD");
  unsetenv("SINEW_MISFORTUNE");
}

/// A host that works, and what befalls it or its machine.
void live_through(OutageCell& cell, Outage outage, bool at_rest, Random& random) {
  const auto life = std::chrono::milliseconds(random.integer(1, 1500));
  if (!at_rest || outage == Outage::kClockJump || outage == Outage::kDiskFull) {
    set_misfortune(outage, life.count());
    Process host(cell.words(cell.motion()));
    forget_misfortune();
    host.let_run(life);
    switch (outage) {
      case Outage::kHostKilled:
        host.signal(SIGKILL);
        break;
      case Outage::kPowerCut:
        cell.power_off();
        host.let_run(100ms);
        break;
      case Outage::kBothCut:
        host.signal(SIGKILL);
        cell.power_off();
        break;
      case Outage::kSuspended:
        host.signal(SIGSTOP);
        host.let_run(std::chrono::milliseconds(random.integer(10, 2000)));
        host.signal(SIGCONT);
        host.let_run(300ms);
        break;
      case Outage::kClockJump:
      case Outage::kDiskFull:
        host.let_run(1s);
        break;
      case Outage::kHostEnded:
        break;
    }
    host.signal(SIGINT);
    host.end();
  } else if (outage == Outage::kPowerCut || outage == Outage::kBothCut) {
    cell.power_off();
  }
  if (!cell.is_on()) cell.power_on();
}

class Outages : public ::testing::TestWithParam<Arm> {};

TEST_P(Outages, leave_no_position_that_is_wrong_and_no_machine_that_is_stuck) {
  const Arm& arm = GetParam();
  OutageCell cell(arm);
  Random random(seed());
  std::map<std::string, int> qualities;
  const std::int64_t count = outages();
  const auto tell = [&] { return joined(cell.truth_at_rest(), arm.unit); };
  Ended first = cell.mend(arm.needs_to_be_told ? tell() : "");
  ASSERT_EQ(first.exit, 0) << first.err;
  for (std::int64_t n = 0; n < count && !HasFailure(); ++n) {
    const auto outage = static_cast<Outage>(random.integer(0, kOutages - 1));
    const bool at_rest = random.chance(0.25);
    live_through(cell, outage, at_rest, random);
    const std::string what = std::string(kNames[static_cast<std::size_t>(outage)]) +
                             (at_rest ? " at rest" : " in motion") + ", number " +
                             std::to_string(n);
    const Ended looked = cell.look();
    const std::vector<Known> known = known_of(looked, arm.unit);
    const std::vector<double> truth = cell.truth_at_rest();
    bool whole = looked.exit == 0 && known.size() == truth.size();
    for (std::size_t j = 0; j < known.size(); ++j) {
      const Known& one = known[j];
      ++qualities[one.quality];
      whole = whole && (one.quality == "commanded" || one.quality == "measured");
      if (one.quality == "lost") continue;
      EXPECT_GE(truth[j], one.lower - arm.resolution) << what << ": joint " << j + 1;
      EXPECT_LE(truth[j], one.upper + arm.resolution) << what << ": joint " << j + 1;
    }
    // Whoever stands before it says where it is, where nobody else can.
    const Ended mended = cell.mend(!whole && arm.needs_to_be_told ? tell() : "");
    EXPECT_EQ(mended.exit, 0) << what << ": stuck: " << mended.err << "\nbefore: " << looked.err;
  }
  std::cout << "  " << count << " outages; joints";
  for (const auto& [quality, times] : qualities) std::cout << " " << quality << " " << times;
  std::cout << "; seed " << seed() << "\n";
  RecordProperty("cases", std::to_string(count));
}

INSTANTIATE_TEST_SUITE_P(
    Robots, Outages,
    ::testing::Values(
        Arm{"hexapod", "mm",
            "loop 1000\njoint leg1=268.40mm leg4=268.45mm leg5=268.30mm\n"
            "joint leg1=268.36mm leg4=268.36mm leg5=268.36mm\nend\n",
            "wait 0.01s\n", true, 1e-4, 100ms},
        Arm{"bigrobotarm", "deg",
            "loop 1000\njoint base=4deg wrist=-3deg\njoint base=0deg wrist=0deg\nend\n",
            "joint base=0deg wrist=0deg\n", true, 0.3, 1600ms},
        Arm{"learm", "deg",
            "loop 1000\njoint base=20deg wrist=-20deg speed=20%\njoint base=0deg wrist=0deg "
            "speed=20%\nend\n",
            "joint base=0deg shoulder=0deg elbow=0deg wrist=0deg roll=0deg\n", false, 1, 20ms}),
    [](const auto& arm) { return std::string(arm.param.robot); });

}  // namespace
}  // namespace sinew::test
