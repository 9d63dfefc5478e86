#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <csignal>
#include <cstdlib>

#include "cli/process.h"
#include "cli/small_arm.h"
#include "support/scratch_folder.h"

/// Homing, recovery and commissioning of the robots of a running cell, from the command line.
namespace sinew::test {
namespace {

using namespace std::chrono_literals;

constexpr std::string_view kArm = R"(title = "One with end stops"
time_scale = 40
[[robot]]
name = "arm"
robot = "small.toml"
profile = "document"
)";

constexpr std::string_view kTwo = R"(title = "Two for a test"
time_scale = 2
[[robot]]
name = "six"
robot = "hexapod"
[[robot]]
name = "max"
robot = "maxarm"
x_mm = 3000
)";

/// A server with a state folder of its own.
class ProcedureCell {
 public:
  explicit ProcedureCell(std::string_view cell)
      : serve_(
            {"serve", folder_.file("cell.toml", std::string(cell)), "--socket", folder_.at("s")}) {
    unsetenv("XDG_STATE_HOME");
    serve_.wait_for_err("answers on");
  }

  const ScratchFolder& folder() const { return folder_; }
  Process& process() { return serve_; }
  Arguments on(Arguments arguments) const {
    arguments.insert(arguments.end(), {"--socket", folder_.at("s")});
    return arguments;
  }
  Ended ask(const Arguments& arguments) const { return sinew(on(arguments)); }
  Json answer(const Arguments& arguments) const {
    const Ended ended = ask(arguments);
    EXPECT_EQ(ended.exit, 0) << ended.err;
    return ended.json();
  }
  std::string script(const std::string& text) const { return folder_.file("answers", text); }

 private:
  /// Of the server, which is begun behind it.
  struct StateHome {
    explicit StateHome(const std::string& path) { setenv("XDG_STATE_HOME", path.c_str(), 1); }
  };

  ScratchFolder folder_;
  StateHome state_{folder_.at("state")};
  std::string arm_ = small_robot_arm_2(folder_, false);
  Process serve_;
};

TEST(CellProcedures, home_finds_the_zeros_and_goes_home_and_says_each_step) {
  const ProcedureCell cell(kArm);
  const Json once = cell.answer({"home", "arm", "--json"});
  EXPECT_EQ(once["phase"], "done") << once.dump();
  EXPECT_EQ(once["steps"][2]["state"], "skipped") << "nobody is there who asked for a second one";
  const Json status = cell.answer({"status", "arm", "--json"})["robots"][0];
  EXPECT_NE(status["position"], "lost");
  const Ended twice =
      cell.ask({"home", "arm", "--answers", cell.script("* = yes\nagain = go\nhome = go\n")});
  EXPECT_EQ(twice.exit, 0) << twice.err;
  EXPECT_NE(twice.err.find("Homing of"), std::string::npos) << twice.err;
  EXPECT_NE(twice.err.find("again"), std::string::npos) << twice.err;
  EXPECT_NE(twice.out.find("zeros found"), std::string::npos) << twice.out;
}

TEST(CellProcedures, what_cannot_be_done_is_told_in_a_sentence) {
  const ProcedureCell cell(kTwo);
  const auto says = [&](const Arguments& arguments, const std::string& what, int exit) {
    const Ended ended = cell.ask(arguments);
    EXPECT_EQ(ended.exit, exit) << ended.err;
    EXPECT_NE(ended.err.find(what), std::string::npos) << ended.err;
  };
  says({"home", "six"}, "the robot is at its home pose", 0);
  says({"home", "nobody"}, "no robot of this cell", 2);
  says({"recover", "six", "--answers", cell.script("plaec = home\n")}, "did you mean 'place'?", 2);
  says({"recover", "six", "--answers", cell.script("adjust.leg1 = 200mm\n")}, "at most +10 mm", 1);
  says({"recover", "six", "--answers", cell.script("adjust.leg1 = done\n")},
       "no answer for the step 'adjust.leg2'", 1);
  says({"recover", "six", "--answers", cell.folder().at("none")}, "none", 2);
  says({"recover", "six", "--answers", "a", "--standing-at", "home"}, "--answers", 2);
  says({"commission", "six", "--cell", "--port", "/dev/ttyUSB0"}, "not in a running cell", 2);
}

constexpr std::string_view kBig = R"(title = "One that counts"
time_scale = 20
[[robot]]
name = "big"
robot = "bigrobotarm"
)";

TEST(CellProcedures, stands_is_held_against_the_boards_count_and_can_zero_it) {
  const ProcedureCell cell(kBig);
  ASSERT_EQ(cell.ask({"move", "big", "joint", "base=20deg"}).exit, 0);
  const Ended elsewhere = cell.ask({"stands", "big", "home"});
  EXPECT_EQ(elsewhere.exit, 1) << elsewhere.out;
  EXPECT_NE(elsewhere.err.find("base 19.99"), std::string::npos) << elsewhere.err;
  EXPECT_NE(elsewhere.err.find("but the device counts"), std::string::npos) << elsewhere.err;
  const Json said = cell.answer(
      {"stands", "big", "home", "--moved", "turned it back by hand", "--zero-counters", "--json"});
  EXPECT_NEAR(said["joints"][0]["position_rad"].get<double>(), 0, 1e-9);
  EXPECT_EQ(said["position"], "commanded");
  // The board counts from there, and says the same in the next question.
  const Ended home = cell.ask({"stands", "big", "home"});
  EXPECT_EQ(home.exit, 0) << home.err;
  ASSERT_EQ(cell.ask({"move", "big", "joint", "base=5deg"}).exit, 0);
  const Ended status = cell.ask({"status", "big"});
  EXPECT_NE(status.out.find(" 5"), std::string::npos) << status.out;
}

TEST(CellProcedures, recover_goes_by_a_script_and_a_declared_place_needs_its_reason) {
  const ProcedureCell cell(kTwo);
  std::string script = "adjust.leg1 = -0.02mm\nadjust.leg1 = done\n";
  for (int leg = 2; leg <= 6; ++leg) script += "adjust.leg" + std::to_string(leg) + " = done\n";
  const Json recovered = cell.answer({"recover", "six", "--json", "--answers",
                                      cell.script(script + "place = lowered moved: let down\n")});
  EXPECT_EQ(recovered["phase"], "done");
  EXPECT_EQ(recovered["steps"][0]["words"], "went -0.02 mm in all");
  const Ended elsewhere = cell.ask({"recover", "six", "--standing-at", "home"});
  EXPECT_EQ(elsewhere.exit, 1);
  EXPECT_NE(elsewhere.err.find("cannot stand at"), std::string::npos) << elsewhere.err;
  EXPECT_EQ(cell.ask({"recover", "six", "--standing-at", "home", "--moved", "lifted"}).exit, 0);
  EXPECT_EQ(cell.ask({"recover", "six", "--standing-at", "home"}).exit, 0) << "it does stand there";
  EXPECT_EQ(cell.ask({"bullride", "six", "--cell", "--time", "4s", "--amplitude", "0.005mm"}).exit,
            0);
  // "Save Position As": the heads are where the pose has them, and the file opens again.
  const std::string pos = cell.folder().at("stands.pos");
  const Ended saved = cell.ask({"teach", "six", pos});
  EXPECT_EQ(saved.exit, 0) << saved.err;
  const std::string numbers = text_of(pos);
  EXPECT_EQ(std::ranges::count(numbers, '\n'), 24);
  EXPECT_NE(cell.ask({"teach", "six", pos}).err.find("--replace"), std::string::npos);
  const Ended opened = sinew({"convert", pos, cell.folder().at("p.sinew"), "--robot", "hexapod"});
  EXPECT_EQ(opened.exit, 0) << opened.err;
  EXPECT_NE(text_of(cell.folder().at("p.sinew")).find("z=250"), std::string::npos);
  EXPECT_NE(cell.ask({"teach", "max", cell.folder().at("m.pos")}).err.find("platform"),
            std::string::npos);
}

TEST(CellProcedures, ctrl_c_ends_a_procedure_and_what_it_moves) {
  ProcedureCell cell(kArm);
  Process homing(
      cell.on({"home", "arm", "--answers", cell.script("* = yes\nagain = go\nhome = go\n")}));
  homing.wait_for_err("> go");
  homing.signal(SIGINT);
  const Ended ended = homing.end();
  EXPECT_EQ(ended.exit, 1);
  EXPECT_NE(ended.err.find("cancelled"), std::string::npos) << ended.err;
  std::string state;
  for (int k = 0; k < 200 && state != "ready"; ++k) {
    cell.process().let_run(50ms);
    state = cell.answer({"status", "arm", "--json"})["robots"][0]["state"];
  }
  EXPECT_EQ(state, "ready");
}

TEST(CellProcedures, a_killed_client_leaves_its_step_to_the_next_process) {
  std::string slow(kArm);
  slow.replace(slow.find("40"), 2, "8");
  ProcedureCell cell(slow);
  const auto arm = [&] { return Json(cell.answer({"status", "arm", "--json"})["robots"][0]); };
  const auto found = [](const Json& robot, std::size_t joint) {
    return robot["joints"][joint]["quality"] != "lost";
  };
  Json left;
  {
    Process homing(
        cell.on({"home", "arm", "--answers", cell.script("* = yes\nagain = go\nhome = go\n")}));
    homing.wait_for_err("> go");
    for (int k = 0; k < 500 && (left.is_null() || !found(left, 1)); ++k) {
      homing.let_run(10ms);
      left = arm();
    }
    homing.signal(SIGKILL);
    homing.end();
  }
  const auto lost = [&] { return left.value("procedure", Json::object()).contains("client_lost"); };
  for (int k = 0; k < 200 && !lost(); ++k) {
    cell.process().let_run(50ms);
    left = arm();
  }
  ASSERT_TRUE(lost()) << left.dump();
  EXPECT_TRUE(found(left, 0) && !found(left, 5)) << left.dump();
  Process resumed(cell.on({"home", "arm", "--json"}));
  // What was found before is not searched for again.
  const auto searches = [](const Json& now) {
    return now.contains("procedure") && now["procedure"]["step"] == 2;
  };
  Json now = left;
  for (int k = 0; k < 3000 && searches(now); ++k, now = arm()) {
    EXPECT_TRUE(found(now, 0)) << now.dump();
    resumed.let_run(10ms);
  }
  EXPECT_FALSE(searches(now)) << now.dump();
  const Json ended = resumed.end().json();
  EXPECT_EQ(ended["phase"], "done") << ended.dump();
  EXPECT_EQ(ended["steps"][0]["answer"], "yes") << "as it was answered before, never at step 1";
}

TEST(CellProcedures, what_commissioning_finds_in_a_cell_is_kept_and_named_in_its_file) {
  const ProcedureCell cell(kTwo);
  const std::string answers = cell.script(
      "* = yes\nfirmware = arduino\ndirection.base = left\ndirection.shoulder = backward\n"
      "direction.forearm = up\nsuction_seen = held\n");
  const Json found = cell.answer({"commission", "max", "--cell", "--json", "--answers", answers});
  EXPECT_EQ(found["settings"], Json({{"joint.shoulder.turn", "other"}}));
  const std::string kept = cell.folder().at("state/sinew/commissioning/max.simulated.json");
  ASSERT_EQ(found["file"], kept);
  cell.folder().file("found.json", text_of(kept));
  const auto serve = [&](const std::string& robot, const std::string& settings) {
    return Arguments{"serve",
                     cell.folder().file("other.toml", "title = \"t\"\n[[robot]]\nname = \"a\"\n" +
                                                          std::string("robot = \"") + robot +
                                                          "\"\nsettings = \"" + settings + "\"\n"),
                     "--socket", cell.folder().at("other")};
  };
  Process used(serve("maxarm", "found.json"));
  used.wait_for_err("answers on");
  const Ended again = sinew(
      {"commission", "a", "--cell", "--socket", cell.folder().at("other"), "--answers", answers});
  EXPECT_EQ(again.exit, 1);
  EXPECT_NE(again.err.find("found.json"), std::string::npos) << again.err;
  const auto refused = [&](const std::string& robot, const std::string& settings,
                           const std::string& what) {
    const Ended ended = sinew(serve(robot, settings));
    EXPECT_EQ(ended.exit, 2);
    EXPECT_NE(ended.err.find("a: settings: "), std::string::npos) << ended.err;
    EXPECT_NE(ended.err.find(what), std::string::npos) << ended.err;
  };
  used.signal(SIGINT);
  used.end();
  refused("learm", "found.json", "another robot's");
  refused("maxarm", "nowhere.json", "nowhere.json");
  cell.folder().file("half.json",
                     R"({"version":1,"robot":"maxarm","finished":false,"settings":{}})");
  refused("maxarm", "half.json", "was not finished");
}

}  // namespace
}  // namespace sinew::test
