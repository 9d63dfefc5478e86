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
#include "cli/small_arm.h"
#include "support/how_many.h"
#include "support/property.h"
#include "support/scratch_folder.h"

/// The table of ends x robots x next command: a host and a machine with a power supply, both real
/// processes, and how the host's run ends: in motion, while it searches its zeros, and at rest. The
/// machine is never put back to its start. What the next host says of a position is true, and a
/// command that the program names brings the machine back.
namespace sinew::test {
namespace {

using namespace std::chrono_literals;

/// Ends of each robot; so many as the table has rows play each of them once.
std::int64_t outages() {
  return static_cast<std::int64_t>(how_many("SINEW_OUTAGES", 2, 1));
}

enum class End : std::uint8_t {
  kDone,
  kRefused,      ///< a row that cannot be, before anything moves
  kSecondHost,   ///< another one wants the same machine meanwhile, and is refused
  kInterrupted,  ///< Ctrl-C
  kHostKilled,   ///< -9
  kBoardSilent,  ///< for some seconds, as behind a cable that was pulled
  kPowerCut,     ///< of the machine; the host finds its port gone
  kBothCut,      ///< one plug for both
  kSuspended,    ///< the computer sleeps for a while
  kClockJump,    ///< an hour, at once
  kDiskFull,     ///< of the host
};
constexpr std::array<const char*, 11> kEnds{
    "done",      "refused",  "second host", "Ctrl-C",     "host killed", "board silent",
    "power cut", "both cut", "suspended",   "clock jump", "disk full"};

/// What the host is at when its run ends.
enum class Phase : std::uint8_t { kMoving, kHoming, kResting };
constexpr std::array<const char*, 3> kPhases{"moving", "homing", "resting"};

struct Row {
  End end = End::kDone;
  Phase phase = Phase::kMoving;
};

struct Arm {
  const char* name;
  const char* robot;
  Arguments options;  ///< of host and machine
  bool on_spi;
  const char* unit;
  const char* motion;               ///< a program that moves for longer than any life lasts
  const char* mend;                 ///< brings it to where `motion` may begin
  const char* home;                 ///< the same from an unknown position; "" where it cannot
  bool needs_to_be_told;            ///< where it is: it has no sensors and no end stops
  double resolution;                ///< unit; of the wire, and what a motor trails by
  std::chrono::milliseconds start;  ///< from a power-up until the device listens
};

void PrintTo(const Arm& arm, std::ostream* out) {
  *out << arm.name;
}

struct Known {
  std::string quality;
  double lower = 0, upper = 0;
};

/// How far the joint that went farthest is from where it was.
double farthest(const std::vector<double>& before, const std::vector<double>& now) {
  double most = 0;
  for (std::size_t j = 0; j < std::min(before.size(), now.size()); ++j) {
    most = std::max(most, std::abs(now[j] - before[j]));
  }
  return most;
}

class OutageCell {
 public:
  explicit OutageCell(const Arm& arm) : arm_(arm), robot_(arm.robot) {
    if (arm.on_spi) robot_ = small_robot_arm_2(folder_, std::string(arm.name).ends_with("link"));
    setenv("XDG_STATE_HOME", folder_.at("xdg").c_str(), 1);
    motion_ = folder_.file("motion.sinew", arm.motion);
    mend_ = folder_.file("mend.sinew", arm.mend);
    home_ = folder_.file("home.sinew", arm.home);
    look_ = folder_.file("look.sinew", "wait 0.01s\n");
    rest_ = folder_.file("rest.sinew", "wait 100s\n");
    refused_ = folder_.file("refused.sinew", std::string(arm.mend) + "joint J1=10000\n");
    port_ = arm.on_spi ? "simwire:unix:" + folder_.at("port") : folder_.at("port");
    power_on();
  }

  const Arm& arm() const { return arm_; }
  bool is_on() const { return sim_ != nullptr; }
  void power_on() {
    Arguments all{"sim", robot_, "--json", "--state", folder_.at("state")};
    all.insert(all.end(), arm_.options.begin(), arm_.options.end());
    if (arm_.on_spi) {
      all.insert(all.end(), {"--simwire", "unix:" + folder_.at("port")});
    } else {
      all.insert(all.end(), {"--link", folder_.at("port")});
    }
    sim_ = std::make_unique<Process>(all);
    told_ = sim_->line_after(0).size() + 1;
    sim_->let_run(arm_.start);
  }
  void signal_board(int number) { sim_->signal(number); }
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
      const double moved = farthest(before, now);
      before = std::move(now);
      if (moved < 0.1 * arm_.resolution) break;
    }
    return before;
  }

  /// What a person who measures it says.
  std::string where() {
    std::string text;
    for (const double one : truth_at_rest()) {
      text += (text.empty() ? "" : ",") + std::to_string(one) + arm_.unit;
    }
    return text;
  }

  Arguments words(const std::string& program, const std::string& standing_at = "") const {
    Arguments all{"run",       program, "--robot", robot_,     "--port", port_,
                  "--journal", "k",     "--json",  "--record", "none"};
    all.insert(all.end(), arm_.options.begin(), arm_.options.end());
    if (arm_.on_spi) all.insert(all.end(), {"--time-scale", "40"});
    if (!standing_at.empty()) all.insert(all.end(), {"--standing-at", standing_at});
    return all;
  }
  template <class Words>
  Ended run(const Words& all) {
    Ended ended;
    for (int tries = 1; tries == 1 || (ended.was_late() && tries <= kTriesWhereLate); ++tries) {
      late_ += tries > 1 ? 1 : 0;
      ended = sinew(all());
    }
    return ended;
  }
  /// Runs that were tried again, since this computer was too busy for them.
  int late() const { return late_; }
  Ended look() {
    return run([&] { return words(look_); });
  }
  Ended refused() {
    return run([&] { return words(refused_); });
  }
  /// As a person does who reads what is said: the program again, then what the refusal names.
  /// @param says  a person says each time where it is
  Ended mend(bool says) {
    Ended ended = run([&] { return words(mend_, says ? where() : ""); });
    if (ended.exit != 0 && ended.err.find("device robot-arm-2 release") != std::string::npos) {
      const Arguments release{"device", robot_,      "release", "--port",
                              port_,    "--journal", "k",       "--json"};
      const Ended released = run([&] { return release; });
      EXPECT_EQ(released.exit, 0) << released.err;
      ended = run([&] { return words(mend_); });
    }
    if (ended.exit != 0 && *arm_.home != '\0') ended = run([&] { return words(home_); });
    return ended;
  }
  const std::string& program_of(Phase phase) const {
    if (phase == Phase::kHoming) return home_;
    return phase == Phase::kMoving ? motion_ : rest_;
  }

 private:
  Arm arm_;
  ScratchFolder folder_;
  std::string robot_;
  std::unique_ptr<Process> sim_;
  std::size_t told_ = 0;
  std::string motion_;
  std::string mend_;
  std::string home_;
  std::string look_;
  std::string rest_;
  std::string refused_;
  std::string port_;
  int late_ = 0;
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

/// A misfortune that the host brings on itself, so many ms after its start.
void set_misfortune(End end, std::int64_t at_ms) {
  if (end != End::kClockJump && end != End::kDiskFull) return;
  const std::string when = std::to_string(at_ms);
  const std::string what = end == End::kDiskFull ? "full@" + when : "jump@" + when + ":3600000";
  setenv("LD_PRELOAD", SINEW_MISFORTUNE_LIBRARY, 1);
  setenv("SINEW_MISFORTUNE", what.c_str(), 1);
}

void forget_misfortune() {
  unsetenv("LD_PRELOAD");
  unsetenv("SINEW_MISFORTUNE");
}

/// What befalls a host at work, or its machine; the host is interrupted behind it where it lives.
void befall(OutageCell& cell, Process& host, End end, Random& random) {
  switch (end) {
    case End::kHostKilled:
      host.signal(SIGKILL);
      break;
    case End::kSecondHost:
      EXPECT_NE(cell.look().exit, 0) << "two hosts at once";
      break;
    case End::kBoardSilent:
      cell.signal_board(SIGSTOP);
      host.let_run(std::chrono::milliseconds(random.integer(10, 3000)));
      cell.signal_board(SIGCONT);
      host.let_run(300ms);
      break;
    case End::kPowerCut:
      cell.power_off();
      host.let_run(100ms);
      break;
    case End::kBothCut:
      host.signal(SIGKILL);
      cell.power_off();
      break;
    case End::kSuspended:
      host.signal(SIGSTOP);
      host.let_run(std::chrono::milliseconds(random.integer(10, 2000)));
      host.signal(SIGCONT);
      host.let_run(300ms);
      break;
    case End::kClockJump:
    case End::kDiskFull:
      host.let_run(1s);
      break;
    case End::kDone:
    case End::kRefused:
    case End::kInterrupted:
      break;
  }
}

/// Whether it moved where it was to.
bool live_through(OutageCell& cell, const Row& row, Random& random) {
  if (row.end == End::kDone) {
    EXPECT_EQ(cell.mend(false).exit, 0);
    return true;
  }
  if (row.end == End::kRefused) {
    EXPECT_NE(cell.refused().exit, 0);
    return true;
  }
  const std::vector<double> before = cell.truth();
  const auto life = std::chrono::milliseconds(random.integer(1, 1500));
  set_misfortune(row.end, life.count());
  Process host(cell.words(cell.program_of(row.phase)));
  forget_misfortune();
  // Most of them in the middle of it, some before the first byte. A servo board that tells nothing
  // begins with a slow move to where it may stand already.
  const bool waits = row.phase != Phase::kResting && random.chance(0.8);
  const double little = 3 * cell.arm().resolution;
  // The motion comes back to where it began.
  bool moved = false;
  const auto look = [&] { return moved = moved || farthest(before, cell.truth()) >= little; };
  for (int k = 0; k < 600 && waits && !look(); ++k) host.let_run(20ms);
  host.let_run(life);
  look();
  befall(cell, host, row.end, random);
  host.signal(SIGINT);
  host.end();
  if (!cell.is_on()) cell.power_on();
  return moved || !waits;
}

/// All rows that there are for this robot, in an order by chance.
std::vector<Row> rows_of(const Arm& arm, Random& random) {
  std::vector<Row> rows;
  for (std::size_t e = 0; e < kEnds.size(); ++e) {
    for (const Phase phase : {Phase::kMoving, Phase::kHoming, Phase::kResting}) {
      if (phase == Phase::kHoming && *arm.home == '\0') continue;
      rows.push_back({static_cast<End>(e), phase});
      if (rows.back().end <= End::kRefused) break;
    }
  }
  for (std::size_t k = rows.size() - 1; k > 0; --k) {
    std::swap(rows[k],
              rows[static_cast<std::size_t>(random.integer(0, static_cast<std::int64_t>(k)))]);
  }
  return rows;
}

class Outages : public ::testing::TestWithParam<Arm> {};

TEST_P(Outages, leave_no_position_that_is_wrong_and_no_machine_that_is_stuck) {
  const Arm& arm = GetParam();
  OutageCell cell(arm);
  Random random(seed());
  std::map<std::string, int> qualities;
  const std::int64_t count = outages();
  const Ended first = cell.mend(arm.needs_to_be_told);
  ASSERT_EQ(first.exit, 0) << first.err;
  std::vector<Row> rows;
  std::int64_t still = 0;
  for (std::int64_t n = 0; n < count && !HasFailure(); ++n) {
    if (rows.empty()) rows = rows_of(arm, random);
    const Row row = rows.back();
    rows.pop_back();
    const std::string what = std::string(kEnds[static_cast<std::size_t>(row.end)]) + ", " +
                             kPhases[static_cast<std::size_t>(row.phase)] + ", number " +
                             std::to_string(n);
    SCOPED_TRACE(what);
    still += live_through(cell, row, random) ? 0 : 1;
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
    // Whoever stands before it says where it is, where nothing else can.
    const Ended mended = cell.mend(!whole && arm.needs_to_be_told);
    EXPECT_EQ(mended.exit, 0) << what << ": stuck: " << mended.err << "\nbefore: " << looked.err
                              << looked.out;
  }
  std::cout << "  " << count << " ends; joints";
  for (const auto& [quality, times] : qualities) std::cout << " " << quality << " " << times;
  std::cout << "; " << still << " had not moved, " << cell.late() << " tried again; seed " << seed()
            << "\n";
  EXPECT_LE(still, 1 + count / 4);
  RecordProperty("cases", std::to_string(count));
}

constexpr const char* kArm2Motion =
    "loop 1000\njoint J1=5deg J5=-5deg speed=20%\njoint J1=0deg J5=0deg speed=20%\nend\n";
constexpr const char* kArm2Mend = "joint J1=0deg J2=0deg J3=0deg J4=0deg J5=0deg J6=0deg\n";
constexpr const char* kArm2Home = "home\njoint J1=0deg J2=0deg J3=0deg J4=0deg J5=0deg J6=0deg\n";
constexpr const char* kLearmMotion =
    "joint base=0deg shoulder=0deg elbow=0deg wrist=0deg roll=0deg\n"
    "loop 1000\njoint base=20deg wrist=-20deg speed=20%\njoint base=0deg wrist=0deg "
    "speed=20%\nend\n";
constexpr const char* kHexapodMotion =
    "loop 1000\njoint leg1=268.40mm leg4=268.45mm leg5=268.30mm\n"
    "joint leg1=268.36mm leg4=268.36mm leg5=268.36mm\nend\n";
constexpr const char* kBigRobotArmMotion =
    "loop 1000\njoint base=4deg wrist=-3deg\njoint base=0deg wrist=0deg\nend\n";
constexpr const char* kLearmMend =
    "joint base=0deg shoulder=0deg elbow=0deg wrist=0deg roll=0deg\n";

const Arm kHexapod{"hexapod",      "hexapod", {},   false, "mm", kHexapodMotion,
                   "wait 0.01s\n", "",        true, 1e-4,  100ms};
const Arm kBigrobotarm{"bigrobotarm",
                       "bigrobotarm",
                       {},
                       false,
                       "deg",
                       kBigRobotArmMotion,
                       "joint base=0deg wrist=0deg\n",
                       "",
                       true,
                       0.3,
                       1600ms};
const Arm kBigrobotarmFramed{"bigrobotarm_framed",
                             "bigrobotarm",
                             {"--wire", "framed"},
                             false,
                             "deg",
                             kBigRobotArmMotion,
                             "joint base=0deg wrist=0deg\n",
                             "",
                             true,
                             0.3,
                             1600ms};
const Arm kLearm{"learm", "learm", {}, false, "deg", kLearmMotion, kLearmMend, "", false, 1, 20ms};
const Arm kLearmBus{
    "learm_bus", "learm", {"--profile", "bus"}, false, "deg", kLearmMotion, kLearmMend, "", false,
    1,           20ms};
const Arm kMaxarm{"maxarm",
                  "maxarm",
                  {},
                  false,
                  "deg",
                  "loop 1000\njoint base=110deg forearm=30deg\njoint base=90deg\nend\n",
                  "joint base=90deg\n",
                  "",
                  false,
                  0.5,
                  20ms};
const Arm kRobotArm2Registers{"robot_arm_2_registers",
                              "robot-arm-2",
                              {},
                              true,
                              "deg",
                              kArm2Motion,
                              kArm2Mend,
                              kArm2Home,
                              false,
                              0.5,
                              20ms};
const Arm kRobotArm2Link{"robot_arm_2_link", "robot-arm-2", {},    true, "deg", kArm2Motion,
                         kArm2Mend,          kArm2Home,     false, 0.5,  20ms};

INSTANTIATE_TEST_SUITE_P(Robots, Outages,
                         ::testing::Values(kHexapod, kBigrobotarm, kBigrobotarmFramed, kLearm,
                                           kLearmBus, kMaxarm, kRobotArm2Registers, kRobotArm2Link),
                         [](const auto& arm) { return std::string(arm.param.name); });

}  // namespace
}  // namespace sinew::test
