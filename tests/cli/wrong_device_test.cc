#include <gtest/gtest.h>

#include <atomic>
#include <chrono>
#include <csignal>
#include <cstdlib>
#include <optional>
#include <thread>

#include "cli/process.h"
#include "sinew/io/port.h"
#include "support/scratch_folder.h"

/// What a person is told where the device is another one than was asked for, talks nonsense, or
/// does something by itself.
namespace sinew::test {
namespace {

using namespace std::chrono_literals;

/// A simulation with a link that is there when this is made.
class Simulated {
 public:
  explicit Simulated(Arguments more) : process_(words(std::move(more))) {
    process_.wait_for_out("\n");
    port_ = process_.out().substr(0, process_.out().find('\n'));
  }
  const std::string& port() const { return port_; }
  void let_run(std::chrono::milliseconds time) { process_.let_run(time); }
  /// Where the machine really is.
  std::string end() {
    process_.signal(SIGINT);
    return process_.end().out;
  }

 private:
  static Arguments words(Arguments more) {
    more.insert(more.begin(), "sim");
    return more;
  }
  Process process_;
  std::string port_;
};

constexpr const char* kFirstMove =
    "joint base=-60deg shoulder=-60deg elbow=60deg wrist=60deg roll=-60deg\n";

TEST(WrongDevice, bus_board_that_is_taken_for_a_classic_one_is_not_moved) {
  const ScratchFolder folder;
  Simulated arm({"learm", "--profile", "bus"});
  const Ended run = sinew({"run", folder.file("p.sinew", kFirstMove), "--robot", "learm", "--port",
                           arm.port(), "--json"});
  EXPECT_EQ(run.exit, 1);
  EXPECT_EQ(run.json()["refusal"]["code"], "other_board");
  EXPECT_EQ(run.json()["orders"].size(), 0U);
  EXPECT_NE(run.err.find("--profile bus"), std::string::npos) << run.err;
  const Ended doctor = sinew({"doctor", "--robot", "learm", "--port", arm.port()});
  EXPECT_EQ(doctor.exit, 1);
  EXPECT_NE(doctor.err.find("--profile bus"), std::string::npos) << doctor.err;
}

TEST(WrongDevice, classic_board_that_is_taken_for_a_bus_board_is_named) {
  Simulated arm({"learm", "--profile", "lsc6"});
  const Ended doctor =
      sinew({"doctor", "--robot", "learm", "--port", arm.port(), "--profile", "bus"});
  EXPECT_EQ(doctor.exit, 1);
  EXPECT_NE(doctor.err.find("try --profile lsc6"), std::string::npos) << doctor.err;
}

TEST(WrongDevice, board_that_answers_none_of_the_questions_leads_to_its_profile) {
  Simulated arm({"learm", "--profile", "esp32"});
  const Ended doctor = sinew({"doctor", "--robot", "learm", "--port", arm.port()});
  EXPECT_EQ(doctor.exit, 1);
  EXPECT_NE(doctor.err.find("another kind of board (--profile lsc6, bus or esp32)?"),
            std::string::npos)
      << doctor.err;
}

TEST(WrongDevice, zeros_without_end_are_not_called_a_wrong_zero) {
  auto zeros = io::Port::open_pseudo_terminal();
  ASSERT_TRUE(zeros);
  std::atomic<bool> over = false;
  std::thread talker([&] {
    const std::vector<std::uint8_t> some(32);
    while (!over) {
      static_cast<void>(zeros->write_now(some));
      std::vector<std::uint8_t> asked(64);
      static_cast<void>(zeros->read(asked, std::chrono::milliseconds(20)));
    }
  });
  constexpr const char* kSaid = "answers nothing that was asked; its last byte was 0";
  Ended status;
  // A computer that is busy elsewhere may let the talker pause, and that is another story.
  for (int tries = 0; tries < kTriesWhereLate; ++tries) {
    status = sinew({"device", "hexapod", "status", "--port", zeros->path()});
    if (status.err.find(kSaid) != std::string::npos) break;
  }
  over = true;
  talker.join();
  EXPECT_EQ(status.exit, 1);
  EXPECT_NE(status.err.find(kSaid), std::string::npos) << status.err;
  EXPECT_NE(status.err.find("is another robot on this port?"), std::string::npos) << status.err;
}

TEST(WrongDevice, options_that_an_action_does_not_take_are_refused_before_anything_is_sent) {
  Simulated hexapod({"hexapod"});
  for (const Arguments& words : {Arguments{"kill", "--leg", "1"}, Arguments{"status", "--leg", "3"},
                                 Arguments{"wake", "--steps", "5"}}) {
    Arguments all{"device", "hexapod", "--port", hexapod.port()};
    all.insert(all.end(), words.begin(), words.end());
    const Ended ended = sinew(all);
    EXPECT_EQ(ended.exit, 2) << words[0];
    EXPECT_NE(ended.err.find(words[1] + ": " + words[0]), std::string::npos) << ended.err;
    EXPECT_NE(ended.err.find("only jog does"), std::string::npos) << ended.err;
  }
  const Ended alive = sinew({"device", "hexapod", "status", "--port", hexapod.port()});
  EXPECT_EQ(alive.err.find("did not answer"), std::string::npos) << "not killed; " << alive.err;
  EXPECT_EQ(alive.err.find("cut its power"), std::string::npos) << alive.err;
}

TEST(WrongDevice, modules_with_a_low_supply_are_shown_and_the_supply_is_named) {
  Simulated hexapod({"hexapod", "--fault", "supply=7V@0s"});
  const Ended status = sinew({"device", "hexapod", "status", "--port", hexapod.port(), "--json"});
  EXPECT_EQ(status.exit, 1);
  EXPECT_NE(status.err.find("says that its supply is, or was, too low"), std::string::npos)
      << status.err;
  EXPECT_EQ(status.err.find("is it switched on"), std::string::npos) << "it has answered";
  const Json legs = status.json()["legs"];
  ASSERT_EQ(legs.size(), 6U);
  EXPECT_NE(legs[0]["flags"].get<std::string>().find("supply too low"), std::string::npos)
      << legs[0].dump();
}

/// Runs, dips the supply at rest, lets `look` ask the modules, and runs again.
/// @return  what the last run said; nothing where this computer was too late
std::optional<Ended> run_behind(const Arguments& look) {
  const ScratchFolder folder;
  setenv("XDG_STATE_HOME", folder.at("xdg").c_str(), 1);
  const auto began = std::chrono::steady_clock::now();
  Simulated hexapod({"hexapod", "--fault", "supply=5V@6s,supply=12V@7s"});
  const auto on = [&](Arguments words, const Arguments& more = {}) {
    words.insert(words.end(), more.begin(), more.end());
    words.insert(words.end(), {"--port", hexapod.port(), "--journal", "legs", "--json"});
    return sinew(words);
  };
  const Arguments run{"run", folder.file("p.sinew", "wait 0.1s\n"), "--robot", "hexapod"};
  const Ended first = on(run, {"--standing-at", "home"});
  if (first.exit != 0 || std::chrono::steady_clock::now() - began > 5s) return std::nullopt;
  EXPECT_NE(first.out.find("\"commanded\""), std::string::npos) << first.out;
  while (std::chrono::steady_clock::now() - began < 8s) hexapod.let_run(100ms);
  const Ended seen = on(look);
  EXPECT_EQ(seen.exit, 1);
  EXPECT_NE(seen.err.find("supply is, or was, too low"), std::string::npos) << seen.err;
  return on(run);
}

TEST(WrongDevice, flags_that_status_or_doctor_reads_first_are_known_to_the_next_run) {
  for (const Arguments& look :
       {Arguments{"device", "hexapod", "status"}, Arguments{"doctor", "--robot", "hexapod"}}) {
    std::optional<Ended> run;
    for (int tries = 0; tries < kTriesWhereLate && !run; ++tries) run = run_behind(look);
    ASSERT_TRUE(run) << look[0];
    EXPECT_EQ(run->out.find("\"commanded\""), std::string::npos) << look[0] << ": " << run->out;
  }
}

TEST(Told, stopped_first_move_says_how_long_the_arm_goes_on_and_that_nobody_knows_where) {
  const ScratchFolder folder;
  Simulated arm({"learm"});
  Process run({"run", folder.file("p.sinew", kFirstMove), "--robot", "learm", "--port", arm.port(),
               "--log", folder.at("log")});
  // The frame of the first move: five servos.
  const auto limit = std::chrono::steady_clock::now() + std::chrono::seconds(20);
  while (text_of(folder.at("log")).find("55 55 14 03") == std::string::npos) {
    ASSERT_LT(std::chrono::steady_clock::now(), limit) << text_of(folder.at("log"));
    std::this_thread::yield();
  }
  run.signal(SIGINT);
  const Ended ended = run.end();
  EXPECT_EQ(ended.exit, 1);
  EXPECT_NE(ended.err.find("sinew: stopped; the machine goes on for up to 6"), std::string::npos)
      << ended.err;
  EXPECT_NE(ended.out.find("as far as is known it is at: base lost, shoulder lost, elbow lost"),
            std::string::npos)
      << ended.out;
}

TEST(Told, arm_that_falls_while_it_should_wait_is_told_as_it_falls_and_at_the_end) {
  const ScratchFolder folder;
  Simulated arm({"maxarm", "--fault", "supply=5.5V@6s,supply=7.5V@9s"});
  const std::string program =
      folder.file("p.sinew", "joint base=120deg shoulder=120deg forearm=30deg\nwait 8s\n");
  const Ended run = sinew({"run", program, "--robot", "maxarm", "--port", arm.port()});
  EXPECT_NE(run.err.find("note: "), std::string::npos) << run.err;
  const std::string sentence = "line 2: shoulder is at 215";
  EXPECT_NE(run.err.find(sentence), std::string::npos) << run.err;
  EXPECT_NE(run.out.find("told meanwhile:"), std::string::npos) << run.out;
  EXPECT_NE(run.out.find(sentence), std::string::npos) << run.out;
}

TEST(Told, notices_are_in_the_document) {
  const ScratchFolder folder;
  Simulated arm({"maxarm", "--fault", "supply=5.5V@6s"});
  const std::string program =
      folder.file("p.sinew",
                  "joint base=120deg shoulder=120deg forearm=30deg\nwait 8s\n"
                  "joint shoulder=110deg\n");
  const Ended run = sinew({"run", program, "--robot", "maxarm", "--port", arm.port(), "--json"});
  EXPECT_EQ(run.exit, 1) << "no motion starts where it was not planned from";
  const Json json = run.json();
  ASSERT_EQ(json["refusal"]["code"], "moved_unasked") << json["refusal"].dump();
  EXPECT_EQ(json["refusal"]["line"], 3);
  EXPECT_EQ(json["refusal"]["joint"], "shoulder");
  EXPECT_NEAR(json["refusal"]["limit_deg"].get<double>(), 120, 1e-9);
  EXPECT_GT(json["refusal"]["measured_deg"].get<double>(), 200);
  EXPECT_EQ(json["notices_told"], json["notices"].size());
  Json fall;  // a busy computer may have made the driver wait for an answer as well
  for (const Json& notice : json["notices"]) {
    if (notice["code"] == "moved_unasked") fall = notice;
  }
  ASSERT_TRUE(fall.is_object()) << json["notices"].dump();
  EXPECT_EQ(fall["line"], 2);
  EXPECT_EQ(fall["joint"], "shoulder");
  EXPECT_GT(fall["t_s"].get<double>(), 1.0);
  EXPECT_EQ(json["goes_on_s"], 0.0);
}

}  // namespace
}  // namespace sinew::test
