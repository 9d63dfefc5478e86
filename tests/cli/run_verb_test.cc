#include <fcntl.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <array>
#include <chrono>
#include <csignal>
#include <filesystem>
#include <sstream>

#include "cli/process.h"
#include "support/scratch_folder.h"

/// `sinew run`: programs on the simulated arm, its own and one behind a port.
namespace sinew::test {
namespace {

constexpr const char* kTwoMoves = "G0 B100 S200 E300 WR400 W300\nG0 B0 S50 E2000 WR700 W0\n";
/// A quick order, then half a minute of motion.
constexpr const char* kLongMove = "G0 B10\nM203 B2\nG0 B1500\nG0 B0\n";

class RunVerb : public ::testing::Test {
 protected:
  /// Arguments of a quick run of this program.
  Arguments quick(const std::string& program, const Arguments& more = {}) const {
    return run(program, "100", more);
  }
  Arguments run(const std::string& program, const std::string& scale,
                const Arguments& more = {}) const {
    Arguments arguments{"run", folder.file("p.txt", program), "--robot", "bigrobotarm"};
    if (scale != "1") arguments.insert(arguments.end(), {"--time-scale", scale});
    arguments.insert(arguments.end(), more.begin(), more.end());
    return arguments;
  }
  ScratchFolder folder;
};

/// A simulation with a link that is there when this is made.
class Simulation {
 public:
  explicit Simulation(const std::string& link, const std::string& scale = "100")
      : process_({"sim", "bigrobotarm", "--link", link, "--time-scale", scale}) {
    process_.wait_for_out("\n");
  }
  Process& process() { return process_; }

 private:
  Process process_;
};

TEST_F(RunVerb, sequence_is_followed_by_the_position_journal) {
  setenv("XDG_STATE_HOME", folder.at("state").c_str(), 1);
  const std::string link = folder.at("arm");
  Simulation simulation(link, "1");
  const auto run_here = [&](const std::string& file, Arguments more) {
    more.insert(more.begin(),
                {"run", file, "--robot", "bigrobotarm", "--port", link, "--journal", "arm"});
    return sinew(more);
  };
  const std::string rows = folder.file("a.sinew", "joint base=2deg\n");
  EXPECT_EQ(run_here(rows, {"--standing-at", "home"}).exit, 0);
  EXPECT_EQ(run_here(rows, {}).exit, 0) << "the journal knows";
  const Ended sequence = run_here(folder.file("b.txt", "G0 B50\n"), {});
  EXPECT_EQ(sequence.exit, 0) << sequence.err;
  const Ended behind = run_here(rows, {"--json"});
  EXPECT_EQ(behind.exit, 0) << behind.err;
  EXPECT_NEAR(behind.json()["positions"][0]["q_deg"].get<double>(), 2, 0.02);
  EXPECT_EQ(behind.json()["positions"][0]["quality"], "commanded");
  unsetenv("XDG_STATE_HOME");
}

/// Nothing moves that could not be recorded.
TEST_F(RunVerb, sequence_waits_for_a_journal_that_cannot_be_written) {
  setenv("XDG_STATE_HOME", folder.file("no_folder", "").c_str(), 1);
  const Ended ended = sinew(quick(kTwoMoves, {"--journal", "arm"}));
  unsetenv("XDG_STATE_HOME");
  EXPECT_EQ(ended.exit, 1);
  EXPECT_EQ(ended.out.find("done"), std::string::npos) << ended.out;
}

TEST_F(RunVerb, document_says_what_was_asked_done_and_sent) {
  for (const std::string wire : {"byte", "text"}) {
    SCOPED_TRACE(wire);
    const Json json = answer(quick(kTwoMoves, {"--wire", wire}));
    EXPECT_EQ(json["robot"], "bigrobotarm");
    EXPECT_EQ(json["result"], "done");
    EXPECT_EQ(json["orders_planned"], 2);
    ASSERT_EQ(json["orders"].size(), 2U);
    const Json& order = json["orders"][1];
    EXPECT_EQ(order["line"], 2);
    for (std::size_t j = 0; j < 5; ++j) {
      const double reported = order["positions"][j]["q_deg"].get<double>();
      EXPECT_NEAR(reported, order["commanded"][j].get<double>(), 1e-6) << j;
      EXPECT_EQ(json["positions"][j]["q_deg"].get<double>(), reported) << j;
    }
    EXPECT_NEAR(order["commanded"][1].get<double>(), -1.8, 1e-6);
    EXPECT_NEAR(order["commanded"][2].get<double>(), -18, 1e-6);
    // The elbow's 15.3 degrees under its jerk limit, and what the wire adds.
    EXPECT_NEAR(order["predicted_s"].get<double>(), 1.58, 0.1);
    EXPECT_EQ(json["pose"]["quaternion_wxyz"].size(), 4U);
    EXPECT_GT(json["ran_s"].get<double>(), json["predicted_s"].get<double>() - 0.2);
    EXPECT_GT(json["bytes_to_device"].get<int>(), 2 + 22 + 22);
    EXPECT_NE(json["notes"].dump().find("without S1"), std::string::npos) << json["notes"];
  }
}

TEST_F(RunVerb, pose_at_the_end_is_that_of_fk) {
  const Json json = answer(quick("G0 B0 S50 E5000 WR1500 W0\n"));
  const Json fk = answer({"fk", "bigrobotarm", "--joints-deg", "0,-1.8,-45,-67.5,0"});
  for (const char* key : {"x_mm", "y_mm", "z_mm"}) {
    EXPECT_NEAR(json["pose"][key].get<double>(), fk["pose"][key].get<double>(), 1e-3);
  }
}

TEST_F(RunVerb, people_get_a_table_on_stdout_and_progress_on_stderr) {
  const Ended ended = sinew(quick("BEGIN I2\nG0 B10\nG1 E1 P40\nG0 B13\nEND\n"));
  EXPECT_EQ(ended.exit, 0);
  EXPECT_NE(ended.out.find("predicted s"), std::string::npos);
  EXPECT_NE(ended.out.find("gripper 40"), std::string::npos);
  EXPECT_NE(ended.out.find("the tool is at"), std::string::npos) << ended.out;
  // The step beside the one that cannot be sent is not passed over in silence.
  EXPECT_NE(ended.out.find("B13 cannot be sent"), std::string::npos) << ended.out;
  EXPECT_NE(ended.err.find("6/6 line 4 round 2/2 done"), std::string::npos) << ended.err;
}

TEST_F(RunVerb, record_plot_and_log_are_written) {
  const Json json = answer(quick(kTwoMoves, {"--record", folder.at("r.csv"), "--plot",
                                             folder.at("p.svg"), "--log", folder.at("log")}));
  EXPECT_EQ(json["result"], "done");
  std::stringstream csv(text_of(folder.at("r.csv")));
  std::string line;
  std::getline(csv, line);
  EXPECT_TRUE(
      line.starts_with("t_s,base_deg,shoulder_deg,elbow_deg,wrist_rotate_deg,wrist_deg,quality,"))
      << line;
  std::size_t rows = 0;
  double last = 0;
  std::string end;
  while (std::getline(csv, line)) {
    ++rows;
    EXPECT_GE(std::stod(line), last);
    last = std::stod(line);
    end = line.substr(line.find(','));
  }
  // As many as a busy computer looks at it.
  EXPECT_GT(rows, 10U);
  EXPECT_TRUE(end.starts_with(",0.000000,-1.800000,-18.000000,-31.500000,0.000000,commanded,"))
      << end;
  const std::string svg = text_of(folder.at("p.svg"));
  EXPECT_TRUE(svg.starts_with("<svg "));
  EXPECT_TRUE(svg.ends_with("</svg>\n"));
  EXPECT_NE(svg.find("wrist_rotate"), std::string::npos);
  EXPECT_EQ(svg.find("nan"), std::string::npos);
  EXPECT_NE(text_of(folder.at("log")).find("host -> device  08 0d"), std::string::npos);
  EXPECT_EQ(folder.names().size(), 4U);
}

TEST_F(RunVerb, files_that_find_no_room_are_told_and_the_run_is_not_hidden) {
  const Ended ended =
      sinew(quick("G0 B10\n", {"--json", "--log", "/dev/full", "--record", folder.at("r.csv")}));
  EXPECT_EQ(ended.exit, 1);
  EXPECT_EQ(ended.json()["result"], "done");
  EXPECT_EQ(ended.err, "sinew: --log: /dev/full: no space left on device; the log is not whole\n");
  EXPECT_FALSE(text_of(folder.at("r.csv")).empty());
  const Ended record = sinew(quick("G0 B10\n", {"--record", "/dev/full"}));
  EXPECT_EQ(record.exit, 1);
  EXPECT_NE(record.err.find("--record: /dev/full: no space left on device"), std::string::npos);
  EXPECT_TRUE(std::filesystem::is_character_file("/dev/full"));
}

TEST_F(RunVerb, program_may_come_out_of_a_pipe) {
  Arguments arguments = quick("");
  arguments[1] = "/dev/stdin";
  Typed program;
  {
    Process process(arguments, {.in = program.in()});
    program.say("G0 B10\n");
    program.end();
    const Ended ended = process.end();
    EXPECT_EQ(ended.exit, 0) << ended.err;
  }
}

TEST_F(RunVerb, one_simulation_serves_one_run_after_the_other) {
  const std::string link = folder.at("arm");
  Simulation simulation(link);
  const Json first = answer(run("G0 B1000\n", "1", {"--port", link, "--standing-at", "home"}));
  EXPECT_EQ(first["result"], "done");
  EXPECT_EQ(first["port"], link);
  // The second starts where the first ended: only the shoulder has a way to go.
  const std::string there = "13.846154,0,0,0,0";
  const Json second =
      answer(run("G0 B1000 S-100\n", "1", {"--port", link, "--standing-at", there}));
  EXPECT_NEAR(second["predicted_s"].get<double>(), 1.08, 0.1);
  for (int i = 0; i < 5; ++i) {
    EXPECT_EQ(answer(run("G1 E1 P40\n", "1", {"--port", link}))["result"], "done");
  }
  simulation.process().signal(SIGINT);
  const std::string truth = simulation.process().end().out;
  // 1000 steps of 72.2 a degree, -100 of 27.8 the other way.
  EXPECT_NE(truth.find("(believes 13.846)"), std::string::npos) << truth;
  EXPECT_NE(truth.find("(believes 3.600)"), std::string::npos) << truth;
}

TEST_F(RunVerb, wrong_wire_ends_in_a_question_for_the_wire) {
  const std::string link = folder.at("arm");
  const Simulation simulation(link, "1");
  const Ended ended = sinew(run("G0 B10\n", "1", {"--port", link, "--wire", "text", "--json"}));
  EXPECT_EQ(ended.exit, 1);
  EXPECT_EQ(ended.json()["result"], "failed");
  EXPECT_EQ(ended.json()["refusal"]["line"], 0);
  EXPECT_NE(ended.err.find("--wire"), std::string::npos) << ended.err;
}

TEST_F(RunVerb, port_that_is_taken_is_refused_and_the_log_of_its_owner_stays) {
  const std::string link = folder.at("arm");
  const Simulation simulation(link, "1");
  Process first(
      run(kLongMove, "1", {"--port", link, "--standing-at", "home", "--log", folder.at("log")}));
  first.wait_for_err("1/3 line 1");
  const std::string log = text_of(folder.at("log"));
  EXPECT_FALSE(log.empty());
  const Ended second =
      sinew(run("G0 B10\n", "1",
                {"--port", link, "--standing-at", "home", "--log", folder.at("log"), "--json"}));
  EXPECT_EQ(second.exit, 1);
  EXPECT_EQ(second.json()["error"]["sentence"], link + ": another program is using this port");
  EXPECT_TRUE(text_of(folder.at("log")).starts_with(log));
  first.signal(SIGINT);
  first.signal(SIGTERM);
  EXPECT_EQ(first.end().exit, 1);
}

TEST_F(RunVerb, two_at_once_have_each_a_device_of_their_own) {
  const Arguments arguments = quick(kTwoMoves, {"--json"});
  Arguments other = arguments;
  other[1] = folder.file("other.txt", "G0 B500\n");
  Process first(arguments);
  Process second(other);
  const Ended a = first.end();
  const Ended b = second.end();
  EXPECT_EQ(a.json()["orders"].size(), 2U);
  EXPECT_NEAR(b.json()["positions"][0]["q_deg"].get<double>(), 500 / (6500.0 / 90), 1e-6);
}

TEST_F(RunVerb, one_interrupt_finishes_the_motion_under_way) {
  for (const int signal : {SIGINT, SIGTERM, SIGHUP}) {
    Process process(
        run("G0 B10\nM203 B100\nG0 B2000\nG0 B0\n", "2", {"--record", folder.at("r.csv")}));
    process.wait_for_err("1/3 line 1");
    process.let_run(std::chrono::milliseconds(100));
    process.signal(signal);
    const Ended ended = process.end();
    EXPECT_EQ(ended.exit, 1);
    EXPECT_NE(ended.err.find("stopped"), std::string::npos);
    EXPECT_NE(ended.out.find("stopped: 1 of 3 orders"), std::string::npos) << ended.out;
    EXPECT_NE(ended.out.find("it is at: base 27.69"), std::string::npos) << ended.out;
    EXPECT_NE(text_of(folder.at("r.csv")).find(",27.69230"), std::string::npos);
  }
}

TEST_F(RunVerb, two_interrupts_leave_at_once) {
  const auto start = std::chrono::steady_clock::now();
  Process process(run(kLongMove, "1"));
  process.wait_for_err("1/3 line 1");
  process.signal(SIGINT);
  process.signal(SIGTERM);
  const Ended ended = process.end();
  EXPECT_EQ(ended.exit, 1);
  EXPECT_NE(ended.err.find("left at once; what was under way goes on, unseen"), std::string::npos);
  EXPECT_NE(ended.out.find("left: 1 of 3 orders"), std::string::npos) << ended.out;
  EXPECT_LT(std::chrono::steady_clock::now() - start, std::chrono::seconds(10));
}

TEST_F(RunVerb, interrupted_run_is_still_one_json_document) {
  Process process(run("G0 B2000\nG0 B0\n", "1", {"--json", "--log", folder.at("log")}));
  const std::string taken_up = "host -> device  01 d0 07 00 00";
  const auto limit = std::chrono::steady_clock::now() + std::chrono::seconds(10);
  while (text_of(folder.at("log")).find(taken_up) == std::string::npos) {
    ASSERT_LT(std::chrono::steady_clock::now(), limit);
  }
  process.signal(SIGINT);
  const Ended ended = process.end();
  EXPECT_EQ(ended.exit, 1);
  EXPECT_EQ(ended.json()["result"], "stopped");
  EXPECT_EQ(ended.json()["orders"].size(), 0U);
  EXPECT_NEAR(ended.json()["positions"][0]["q_deg"].get<double>(), 27.6923, 1e-3);
}

TEST_F(RunVerb, device_killed_in_a_motion_leaves_a_report_of_what_was_done) {
  const std::string link = folder.at("arm");
  Simulation simulation(link, "1");
  Process process(run(kLongMove, "1",
                      {"--port", link, "--standing-at", "home", "--record", folder.at("r.csv")}));
  process.wait_for_err("1/3 line 1");
  simulation.process().signal(SIGKILL);
  const Ended ended = process.end();
  EXPECT_EQ(ended.exit, 1);
  EXPECT_NE(ended.err.find(link + ": the other side closed the port"), std::string::npos)
      << ended.err;
  EXPECT_NE(ended.out.find("failed: 1 of 3 orders"), std::string::npos) << ended.out;
  EXPECT_TRUE(text_of(folder.at("r.csv")).starts_with("t_s,"));
}

TEST_F(RunVerb, runs_in_a_row_all_end_well) {
  for (int i = 0; i < 40; ++i) {
    const Ended ended = sinew(quick("G0 B10\nG28\n"));
    ASSERT_EQ(ended.exit, 0) << "run " << i << ": " << ended.err;
  }
}

TEST_F(RunVerb, robot_of_ones_own_with_other_limits_is_obeyed) {
  std::string robot = text_of(std::string(SINEW_SOURCE_DIR) + "/robots/bigrobotarm.toml");
  const std::string limit = "upper_deg = 90";
  robot.replace(robot.find(limit), limit.size(), "upper_deg = 10");
  Arguments arguments = quick("G0 B1000\n");
  arguments[3] = folder.file("small.toml", robot);
  const Ended ended = sinew(arguments);
  EXPECT_EQ(ended.exit, 1);
  EXPECT_NE(ended.err.find("base would need 13.8462 deg, limit 10 deg"), std::string::npos)
      << ended.err;
  EXPECT_NE(ended.err.find("nothing was moved"), std::string::npos);
}

}  // namespace
}  // namespace sinew::test
