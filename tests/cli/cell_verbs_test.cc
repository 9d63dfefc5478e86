#include <gtest/gtest.h>

#include <chrono>
#include <csignal>
#include <cstdlib>
#include <filesystem>
#include <memory>
#include <vector>

#include "cli/process.h"
#include "sinew/core/units.h"
#include "support/scratch_folder.h"

/// `sinew serve` and those who talk to it, each a process of its own.
namespace sinew::test {
namespace {

using namespace std::chrono_literals;

constexpr std::string_view kTwoRobots = R"(title = "Two for a test"
time_scale = 10
[[robot]]
name = "left"
robot = "learm"
profile = "bus"
[[robot]]
name = "big"
robot = "bigrobotarm"
x_mm = 3000
)";

const std::string kStand = "joint base=0deg shoulder=20deg elbow=40deg wrist=40deg roll=0deg";

/// A server on a socket of its own.
class Cell {
 public:
  explicit Cell(const std::string& text = std::string(kTwoRobots))
      : serve_({"serve", folder_.file("cell.toml", text), "--socket", socket()}) {
    serve_.wait_for_err("answers on");
  }
  std::string socket() const { return folder_.at("cell.sock"); }
  const ScratchFolder& folder() const { return folder_; }
  Process& process() { return serve_; }

  Arguments on(Arguments arguments) const {
    arguments.insert(arguments.end(), {"--socket", socket()});
    return arguments;
  }
  Ended ask(const Arguments& arguments) const { return sinew(on(arguments)); }
  Json status(const std::string& robot) const {
    return ask({"status", robot, "--json"}).json()["robots"][0];
  }
  /// Waits for a state, for 10 s at most.
  bool comes_to(const std::string& robot, const std::string& state) {
    for (int k = 0; k < 100; ++k) {
      if (status(robot)["state"] == state) return true;
      serve_.let_run(50ms);
    }
    return false;
  }

 private:
  ScratchFolder folder_;
  Process serve_;
};

double base_rad(const Json& status) {
  return status["joints"][0]["position_rad"];
}

TEST(Cell, lease_is_held_until_its_process_ends) {
  Cell cell;
  Process holder(cell.on({"lease", "left"}));
  for (int k = 0; k < 100 && !cell.status("left").contains("lease"); ++k) holder.let_run(50ms);
  const Ended refused = cell.ask({"move", "left", kStand});
  EXPECT_EQ(refused.exit, 1) << refused.out;
  EXPECT_NE(refused.err.find("moves this machine; take over, or wait"), std::string::npos)
      << refused.err;
  holder.signal(SIGINT);
  EXPECT_EQ(holder.end().exit, 0);
  EXPECT_FALSE(cell.status("left").contains("lease"));
  const Ended moved = cell.ask({"move", "left", kStand});
  EXPECT_EQ(moved.exit, 0) << moved.err;
}

TEST(Cell, nudge_goes_as_far_as_it_says_and_no_farther_than_it_may) {
  Cell cell;
  const auto steps = [&] { return cell.ask({"status", "big", "--json"}).json(); };
  const Ended none = cell.ask({"nudge", "left", "base", "1deg"});
  EXPECT_EQ(none.exit, 1) << none.out;
  EXPECT_NE(none.err.find("moves to places only"), std::string::npos) << none.err;
  const Ended unknown = cell.ask({"nudge", "big", "base", "1"});
  EXPECT_EQ(unknown.exit, 2) << unknown.err;
  EXPECT_NE(unknown.err.find("needs a unit"), std::string::npos) << unknown.err;
  EXPECT_EQ(steps()["robots"][0]["state"], "off") << "nothing has moved";
}

TEST(Cell, nudge_until_probe_ends_where_the_boards_input_closes_and_says_where) {
  const std::string robot = std::string(SINEW_SOURCE_DIR) + "/robots/examples/ar4-grbl.toml";
  Process board({"sim", robot, "--json", "--fault", "probe=J2@1deg@0s"});
  const std::string port = Json::parse(board.line_after(0)).at("port");
  const Cell cell("title = \"Probe\"\n[[robot]]\nname = \"arm\"\nrobot = \"" + robot +
                  "\"\nport = \"" + port + "\"\n");
  const auto probe = [&](const char* joint, const char* way) {
    return cell.ask({"nudge", "arm", joint, way, "--until-probe", "--json"});
  };
  const Ended stands = cell.ask({"stands", "arm", "home"});
  ASSERT_EQ(stands.exit, 0) << stands.err;
  const Ended none = probe("base", "1deg");
  EXPECT_EQ(none.exit, 1);
  EXPECT_NE(none.err.find("the probe input did not close within 1deg"), std::string::npos)
      << none.err;
  const Ended touched = probe("shoulder", "3deg");
  ASSERT_EQ(touched.exit, 0) << touched.err;
  EXPECT_NEAR(touched.json()["touched"]["position_rad"], from_deg(1), from_deg(0.01));
  const Ended closed = probe("shoulder", "1deg");
  EXPECT_EQ(closed.exit, 1);
  EXPECT_NE(closed.err.find("closed before anything has moved"), std::string::npos) << closed.err;
  EXPECT_EQ(cell.ask({"nudge", "arm", "shoulder", "-1deg"}).exit, 0);
  EXPECT_EQ(probe("shoulder", "1.5deg").exit, 0) << "once more";
}

TEST(Cell, nudge_until_probe_is_refused_where_no_board_has_such_an_input) {
  const Cell cell;
  EXPECT_EQ(cell.ask({"stands", "big", "home"}).exit, 0);
  const Ended refused = cell.ask({"nudge", "big", "base", "1deg", "--until-probe"});
  EXPECT_EQ(refused.exit, 1) << refused.out;
  EXPECT_NE(refused.err.find("no input that a probe could close"), std::string::npos)
      << refused.err;
}

TEST(Bullride, one_seed_is_one_program_and_a_cell_rides_it) {
  const Arguments words{"bullride", "learm", "--time", "4s", "--seed", "7"};
  const Ended one = sinew(words);
  EXPECT_EQ(one.exit, 0) << one.err;
  EXPECT_EQ(sinew(words).out, one.out);
  EXPECT_NE(sinew({"bullride", "learm", "--time", "4s", "--seed", "8"}).out, one.out);
  const ScratchFolder folder;
  const Ended checked = sinew({"check", folder.file("ride.sinew", one.out), "--robot", "learm"});
  EXPECT_EQ(checked.exit, 0) << checked.err;
  Cell cell;
  EXPECT_EQ(cell.ask({"move", "left", kStand}).exit, 0);
  const Ended rode = cell.ask({"bullride", "left", "--cell", "--time", "4s", "--seed", "7"});
  EXPECT_EQ(rode.exit, 0) << rode.err;
}

TEST(Bullride, legs_take_a_length_and_a_refusal_says_what_the_wire_could) {
  const auto ride = [](const char* amplitude, const char* time) {
    return sinew({"bullride", "hexapod", "--time", time, "--amplitude", amplitude});
  };
  EXPECT_NE(ride("0.05mm", "10s").out.find("each leg 0.05mm to a side"), std::string::npos);
  const Ended much = ride("1mm", "10s");
  EXPECT_EQ(much.exit, 1);
  const std::string offer = "--amplitude ";
  const std::size_t begin = much.err.find(offer) + offer.size();
  const std::string fits = much.err.substr(begin, much.err.find(" fits") - begin);
  EXPECT_TRUE(fits.ends_with("mm")) << much.err;
  EXPECT_EQ(ride(fits.c_str(), "10s").exit, 0) << fits;
  EXPECT_EQ(ride("80mm", "10s").exit, 2) << "more than half the stroke";
  EXPECT_EQ(sinew({"bullride", "learm", "--amplitude", "5mm"}).exit, 2) << "its joints turn";
}

TEST(Cell, is_steered_from_other_processes) {
  Cell cell;
  Ended stands = cell.ask({"move", "left", kStand});
  EXPECT_EQ(stands.exit, 0) << stands.err;
  EXPECT_NE(stands.out.find("done: 1 of 1"), std::string::npos) << stands.out;
  const Ended turned = cell.ask({"move", "left", "joint", "base=30deg"});
  EXPECT_EQ(turned.exit, 0) << turned.err;
  EXPECT_NEAR(base_rad(cell.status("left")), 0.52, 0.04);
  const Ended big = cell.ask({"move", "big", "joint", "base=20deg"});
  EXPECT_EQ(big.exit, 0) << big.err;
  const Ended all = cell.ask({"status"});
  EXPECT_NE(all.out.find("left"), std::string::npos);
  EXPECT_NE(all.out.find("big"), std::string::npos);
  const std::string program =
      cell.folder().file("two.sinew", "joint base=0deg\njoint base=10deg\n");
  const Ended ran = cell.ask({"run", program, "--robot", "left"});
  EXPECT_EQ(ran.exit, 0) << ran.err;
  EXPECT_NE(ran.out.find("2 of 2"), std::string::npos) << ran.out;
  const Ended jogged = cell.ask(
      {"jog", "left", "--frame", "joint", "--velocity", "10deg/s,0,0,0,0", "--time", "0.5s"});
  EXPECT_EQ(jogged.exit, 0) << jogged.err;
}

/// One runs it, another one leads it through, forth and back.
TEST(Cell, program_is_stepped_forth_and_back) {
  Cell cell;
  EXPECT_EQ(cell.ask({"move", "left", kStand}).exit, 0);
  const std::string rows =
      cell.folder().file("three.sinew", "joint base=10deg\njoint base=20deg\njoint base=30deg\n");
  Process run(cell.on({"run", rows, "--robot", "left", "--single-step"}));
  run.wait_for_err("paused");
  EXPECT_NEAR(base_rad(cell.status("left")), 0.17, 0.04);
  const Ended forth = cell.ask({"step", "left"});
  EXPECT_EQ(forth.exit, 0) << forth.err;
  EXPECT_EQ(forth.out, "  paused: 2 of 3 orders done\n");
  EXPECT_NEAR(base_rad(cell.status("left")), 0.35, 0.04);
  const Ended back = cell.ask({"step", "left", "--back"});
  EXPECT_EQ(back.out, "  paused: 1 of 3 orders done\n") << back.err;
  EXPECT_NEAR(base_rad(cell.status("left")), 0.17, 0.04);
  EXPECT_EQ(cell.ask({"step", "left", "--back"}).exit, 0);
  const Ended too_far = cell.ask({"step", "left", "--back"});
  EXPECT_EQ(too_far.exit, 1);
  EXPECT_NE(too_far.err.find("cannot go back"), std::string::npos) << too_far.err;
  EXPECT_EQ(cell.ask({"resume", "left"}).exit, 0);
  const Ended ended = run.end();
  EXPECT_EQ(ended.exit, 0) << ended.err;
  EXPECT_NEAR(base_rad(cell.status("left")), 0.52, 0.04);
  const Ended none = cell.ask({"step", "left"});
  EXPECT_EQ(none.exit, 1);
  EXPECT_NE(none.err.find("no program"), std::string::npos) << none.err;
}

TEST(Cell, where_an_arm_stands_becomes_a_point_of_a_program) {
  Cell cell;
  const std::string points = cell.folder().at("points.toml");
  const Arguments teach_here{"teach", "left", "here", "--points", points};
  const Ended lost = cell.ask(teach_here);
  EXPECT_EQ(lost.exit, 1);
  EXPECT_NE(lost.err.find("nobody knows"), std::string::npos) << lost.err;
  EXPECT_EQ(cell.ask({"move", "left", kStand}).exit, 0);
  const Ended taught = cell.ask(teach_here);
  EXPECT_EQ(taught.exit, 0) << taught.err;
  EXPECT_NE(taught.out.find("here taught"), std::string::npos) << taught.out;
  const double base = base_rad(cell.status("left"));
  EXPECT_EQ(cell.ask({"move", "left", "joint", "base=50deg"}).exit, 0);
  const Ended again = cell.ask(teach_here);
  EXPECT_EQ(again.exit, 2);
  EXPECT_NE(again.err.find("--replace"), std::string::npos) << again.err;
  const std::string rows = cell.folder().file("back.sinew", "joint to=here\n");
  EXPECT_EQ(cell.ask({"run", rows, "--robot", "left"}).exit, 0);
  EXPECT_NEAR(base_rad(cell.status("left")), base, 0.02);
  const Ended listed = sinew({"points", points, "--json"});
  EXPECT_EQ(listed.json()["points"][0]["name"], "here");
  EXPECT_EQ(listed.json()["points"][0]["robot"], "learm");
  EXPECT_EQ(cell.ask({"teach", "left", "here", "--points", points, "--replace"}).exit, 0);
  EXPECT_EQ(cell.ask({"teach", "left", "3d", "--points", points}).exit, 2);
  const std::string other =
      cell.folder().file("other.toml", "[points.here]\nrobot = \"maxarm\"\nlegs_mm = [1]\n");
  const Ended foreign = cell.ask({"teach", "left", "here", "--points", other, "--replace"});
  EXPECT_EQ(foreign.exit, 2);
  EXPECT_NE(foreign.err.find("is a point of maxarm"), std::string::npos) << foreign.err;
  EXPECT_EQ(cell.ask({"teach", "lfet", "there", "--points", points}).exit, 2);
  const std::string wrong = cell.folder().file("wrong.toml", "[points.a]\nrobot = 3\n");
  EXPECT_EQ(cell.ask({"teach", "left", "b", "--points", wrong}).exit, 2);
  EXPECT_EQ(text_of(wrong), "[points.a]\nrobot = 3\n");
}

TEST(Cell, a_row_in_quotes_finds_the_points_beside_it) {
  Cell cell;
  cell.folder().file("points.toml",
                     "[points.good]\nrobot = \"learm\"\njoints_deg = [10, 20, 40, 40, 0]\n"
                     "source = \"a test\"\n");
  const auto before = std::filesystem::current_path();
  std::filesystem::current_path(cell.folder().at(""));
  const Ended quoted = cell.ask({"move", "left", "joint to=good"});
  const Ended words = cell.ask({"move", "left", "joint", "to=good"});
  std::filesystem::current_path(before);
  EXPECT_EQ(quoted.exit, 0) << quoted.err;
  EXPECT_EQ(words.exit, 0) << words.err;
  EXPECT_NEAR(base_rad(cell.status("left")), 0.17, 0.04);
}

TEST(Cell, a_sequence_is_run_as_it_is_and_its_refusal_says_where_and_what_would_work) {
  Cell cell;
  const auto run = [&](const std::string& file) {
    return cell.ask({"run", file, "--robot", "big"});
  };
  const Ended fine = run(cell.folder().file("fine.txt", "# one\nG0 B100 S200\nG0 B0 S0\n"));
  EXPECT_EQ(fine.exit, 0) << fine.err;
  EXPECT_NE(fine.out.find("note: line 2: without S1"), std::string::npos) << fine.out;
  const Ended down =
      run(cell.folder().file("down.txt", "# through the table\nG0 B0 S-2500 E-10000 WR0 W0\n"));
  EXPECT_EQ(down.exit, 1) << down.out;
  for (const char* part : {"down.txt:2, at ", "on the rest of the way they would overlap by ",
                           "\n  would work: as far as the joints can go: joint base=0deg "}) {
    EXPECT_NE(down.err.find(part), std::string::npos) << down.err;
  }
}

TEST(Cell, a_way_that_is_looked_at_is_in_its_file_before_the_end) {
  Cell cell;
  EXPECT_EQ(cell.ask({"move", "left", kStand}).exit, 0);
  const std::string way = cell.folder().at("way.sinew");
  Process teach(cell.on({"teach", "left", "--way", way}));
  teach.wait_for_err("Ctrl-C ends");
  EXPECT_EQ(cell.ask({"move", "left", "joint", "base=30deg"}).exit, 0);
  for (int k = 0; k < 200 && text_of(way).empty(); ++k) teach.let_run(100ms);
  teach.signal(SIGKILL);
  teach.end();
  EXPECT_EQ(sinew({"check", way, "--robot", "learm"}).exit, 0) << text_of(way);
}

TEST(Cell, a_jog_holds_for_the_time_of_the_robot) {
  Cell cell;
  EXPECT_EQ(cell.ask({"move", "left", kStand}).exit, 0);
  const Ended jogged = cell.ask(
      {"jog", "left", "--frame", "joint", "--velocity", "10deg/s,0,0,0,0", "--time", "3s"});
  EXPECT_EQ(jogged.exit, 0) << jogged.err;
  // 30 deg, and as much as a computer that looks late adds to it.
  EXPECT_GT(base_rad(cell.status("left")), 0.35);
}

TEST(Cell, points_taught_at_once_are_all_kept) {
  Cell cell;
  EXPECT_EQ(cell.ask({"move", "left", kStand}).exit, 0);
  const std::string points = cell.folder().at("points.toml");
  std::vector<std::unique_ptr<Process>> teachers;
  for (const char* name : {"a", "b", "c", "d", "e", "f"}) {
    teachers.push_back(
        std::make_unique<Process>(cell.on({"teach", "left", name, "--points", points})));
  }
  for (const auto& teacher : teachers) {
    const Ended taught = teacher->end();
    EXPECT_EQ(taught.exit, 0) << taught.err;
  }
  const Ended listed = sinew({"points", points, "--json"});
  EXPECT_EQ(Json::parse(listed.out)["points"].size(), 6U) << text_of(points);
}

/// Somebody leads an arm by a jog, somebody looks on, and a program goes the same way.
TEST(Cell, a_way_that_an_arm_was_led_becomes_a_program) {
  Cell cell;
  EXPECT_EQ(cell.ask({"move", "left", kStand}).exit, 0);
  const std::string way = cell.folder().at("way.sinew");
  Process teach(cell.on({"teach", "left", "--way", way}));
  teach.wait_for_err("Ctrl-C ends");
  const auto jog = [&](const std::string& velocity) {
    const Ended jogged =
        cell.ask({"jog", "left", "--frame", "joint", "--velocity", velocity, "--time", "2s"});
    EXPECT_EQ(jogged.exit, 0) << jogged.err;
  };
  jog("15deg/s,0,0,0,0");
  const double turned = base_rad(cell.status("left"));
  EXPECT_GT(turned, 0.2);
  jog("0,0,10deg/s,0,0");
  teach.let_run(200ms);
  teach.signal(SIGINT);
  const Ended taught = teach.end();
  EXPECT_EQ(taught.exit, 0) << taught.err;
  EXPECT_NE(taught.out.find(" rows, of "), std::string::npos) << taught.out;
  const Json end = cell.status("left");
  EXPECT_EQ(cell.ask({"move", "left", kStand}).exit, 0);
  const Ended ran = cell.ask({"run", way, "--robot", "left"});
  EXPECT_EQ(ran.exit, 0) << ran.err << text_of(way);
  const Json again = cell.status("left");
  for (std::size_t j = 0; j < 5; ++j) {
    EXPECT_NEAR(again["joints"][j]["position_rad"], end["joints"][j]["position_rad"].get<double>(),
                0.03);
  }
  EXPECT_EQ(cell.ask({"teach", "left", "--way", way}).exit, 2) << "not over what is there";
  EXPECT_EQ(cell.ask({"teach", "left"}).exit, 2);
  EXPECT_EQ(cell.ask({"teach", "left", "a", "--way", cell.folder().at("b.sinew")}).exit, 2);
}

TEST(Cell, run_takes_a_part_of_a_program_and_its_pace) {
  Cell cell;
  EXPECT_EQ(cell.ask({"move", "left", kStand}).exit, 0);
  const std::string rows =
      cell.folder().file("two.sinew", "joint base=40deg\njoint base=30deg\njoint base=0deg\n");
  const Ended part = cell.ask({"run", rows, "--robot", "left", "--from-line", "2"});
  EXPECT_NE(part.out.find("2 of 2"), std::string::npos) << part.out << part.err;
  const auto taken = [&](const Arguments& more) {
    Arguments arguments{"run", rows, "--robot", "left", "--json"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    return cell.ask(arguments).json()["elapsed_s"].get<double>();
  };
  // Accelerations stay as they are; and what one run asks for is over with it.
  const double slow = taken({"--speed", "5%"});
  EXPECT_GT(slow, 2 * taken({}));
  const auto refuses = [&](const Arguments& more, const std::string& what) {
    Arguments arguments{"run", rows, "--robot", "left"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    const Ended ended = cell.ask(arguments);
    EXPECT_EQ(ended.exit, 2);
    EXPECT_NE(ended.err.find(what), std::string::npos) << ended.err;
  };
  refuses({"--speed", "300%"}, "1% to 100%");
  refuses({"--speed", "fast"}, "--speed");
  refuses({"--from-line", "77"}, "from_line");
  refuses({"--from-line", "-1"}, "from_line");
  refuses({"--port", "/dev/ttyUSB0"}, "--port: not in a running cell");
  refuses({"--plot", "a.svg"}, "--plot: not in a running cell");
}

TEST(Cell, refuses_what_makes_no_sense_in_a_sentence) {
  Cell cell;
  const auto says = [&](const Arguments& arguments, const std::string& what, int exit = 2) {
    const Ended ended = cell.ask(arguments);
    EXPECT_EQ(ended.exit, exit) << ended.err;
    EXPECT_NE(ended.err.find(what), std::string::npos) << ended.err;
    EXPECT_EQ(ended.out, "");
  };
  says({"move", "lfet", "joint", "base=3deg"}, "no robot of this cell");
  says({"status", "lfet"}, "did you mean 'left'?");
  says({"move", "left", "jiont", "base=3deg"}, "move:1:1");
  says({"move", "left", "joint", "base=3"}, "unit");
  says({"jog", "left", "--velocity", "fast"}, "is no speed");
  says({"jog", "left", "--velocity", "20mm/s,0,0", "--time", "-1s"}, "--time");
  says({"jog", "big", "--velocity", "20mm/s,0,0"}, "whole moves", 1);
  says({"recover", "left", "--standing-at", "1,2"}, "--standing-at");
  says({"resume", "left"}, "", 1);
  says({"pause", "nobody"}, "no robot of this cell");
  says({"run", "/nowhere.sinew", "--robot", "left"}, "/nowhere.sinew");
}

TEST(Cell, one_robot_without_its_port_leaves_the_others_working) {
  const ScratchFolder folder;
  const std::string file =
      folder.file("half.toml",
                  "title = \"half\"\n[[robot]]\nname = \"gone\"\nrobot = "
                  "\"learm\"\nport = \"/dev/nowhere\"\njournal = \"test\"\n"
                  "[[robot]]\nname = \"here\"\nrobot = \"maxarm\"\nx_mm = 3000\n");
  setenv("XDG_STATE_HOME", folder.at("state").c_str(), 1);
  Process serve({"serve", file, "--socket", folder.at("s")});
  unsetenv("XDG_STATE_HOME");
  serve.wait_for_err("answers on");
  const auto ask = [&](Arguments arguments) {
    arguments.insert(arguments.end(), {"--socket", folder.at("s")});
    return sinew(arguments);
  };
  const Ended gone = ask({"move", "gone", "joint", "base=10deg"});
  EXPECT_EQ(gone.exit, 1);
  EXPECT_NE(gone.err.find("gone: /dev/nowhere: no such file"), std::string::npos) << gone.err;
  EXPECT_EQ(ask({"move", "here", "joint", "base=95deg"}).exit, 0);
  EXPECT_NE(ask({"status"}).out.find("no port"), std::string::npos);
}

TEST(Cell, a_port_that_it_holds_is_refused_to_others_by_its_name) {
  const ScratchFolder folder;
  const std::string link = folder.at("arm");
  Process sim({"sim", "maxarm", "--link", link});
  sim.wait_for_out("\n");
  const std::string file =
      folder.file("one.toml",
                  "title = \"one\"\n[[robot]]\nname = \"mine\"\nrobot = \"maxarm\"\n"
                  "port = \"" +
                      link + "\"\n");
  const std::string program = folder.file("turn.sinew", "joint base=95deg\n");
  setenv("XDG_RUNTIME_DIR", folder.at().c_str(), 1);
  Process serve({"serve", file});
  serve.wait_for_err("answers on");
  const Ended refused = sinew({"run", program, "--robot", "maxarm", "--port", link});
  const Ended asked = sinew({"doctor", "--robot", "maxarm", "--port", link});
  const Ended ran = sinew({"run", program, "--cell", "--robot", "mine"});
  const Ended shown = sinew({"status", "mine"});
  unsetenv("XDG_RUNTIME_DIR");
  EXPECT_EQ(asked.exit, 1);
  EXPECT_NE(asked.err.find("holds it, as 'mine': sinew status mine shows it"), std::string::npos)
      << asked.err;
  EXPECT_EQ(shown.exit, 0) << shown.err;
  EXPECT_EQ(refused.exit, 1);
  EXPECT_NE(refused.err.find("holds it, as 'mine'"), std::string::npos) << refused.err;
  EXPECT_EQ(ran.exit, 0) << ran.err;
}

TEST(Cell, without_a_server_says_how_to_start_one) {
  const ScratchFolder folder;
  const Ended ended = sinew({"status", "--socket", folder.at("none.sock")});
  EXPECT_EQ(ended.exit, 1);
  EXPECT_NE(ended.err.find("sinew serve starts one"), std::string::npos) << ended.err;
}

TEST(Cell, one_socket_has_one_server) {
  Cell cell;
  const Ended second = sinew({"serve", "--socket", cell.socket()});
  EXPECT_EQ(second.exit, 1);
  EXPECT_NE(second.err.find("another program listens there"), std::string::npos) << second.err;
  EXPECT_EQ(cell.ask({"status"}).exit, 0);
}

TEST(Cell, whoever_is_killed_leaves_nothing_moving_and_another_process_resumes) {
  Cell cell;
  ASSERT_EQ(cell.ask({"move", "left", kStand}).exit, 0);
  {
    Process mover(cell.on({"move", "left", "joint", "base=90deg", "speed=2%"}));
    ASSERT_TRUE(cell.comes_to("left", "moving"));
    mover.signal(SIGKILL);
    mover.end();
  }
  EXPECT_TRUE(cell.comes_to("left", "held"));
  EXPECT_LT(base_rad(cell.status("left")), 1.4);
  const Ended refused = cell.ask({"move", "left", "joint", "base=0deg"});
  EXPECT_EQ(refused.exit, 1);
  EXPECT_NE(refused.err.find("resume or stop it first"), std::string::npos) << refused.err;
  const Ended resumed = cell.ask({"resume", "left"});
  EXPECT_EQ(resumed.exit, 0) << resumed.err;
  EXPECT_NE(resumed.out.find("done"), std::string::npos) << resumed.out;
  EXPECT_NEAR(base_rad(cell.status("left")), 1.5708, 0.03);
  EXPECT_EQ(cell.ask({"move", "left", "joint", "base=0deg"}).exit, 0);
}

TEST(Cell, a_guarded_pause_is_resumed_by_an_explicit_take_over_only) {
  Cell cell;
  ASSERT_EQ(cell.ask({"move", "left", kStand}).exit, 0);
  Process mover(cell.on({"move", "left", "joint", "base=60deg", "speed=5%"}));
  ASSERT_TRUE(cell.comes_to("left", "moving"));
  EXPECT_EQ(cell.ask({"pause", "left", "--guard"}).exit, 0);
  EXPECT_TRUE(cell.comes_to("left", "held"));
  const Ended refused = cell.ask({"resume", "left"});
  EXPECT_EQ(refused.exit, 1);
  EXPECT_NE(refused.err.find("only that client resumes it"), std::string::npos) << refused.err;
  EXPECT_EQ(cell.ask({"resume", "left", "--take-over"}).exit, 0);
  const Ended done = mover.end();
  EXPECT_EQ(done.exit, 0) << done.err;
}

TEST(Cell, who_is_taken_over_is_told_so_and_the_program_can_be_resumed) {
  Cell cell;
  ASSERT_EQ(cell.ask({"move", "left", kStand}).exit, 0);
  Process mover(cell.on({"move", "left", "joint", "base=60deg", "speed=5%"}));
  ASSERT_TRUE(cell.comes_to("left", "moving"));
  Process holder(cell.on({"lease", "left", "--take-over"}));
  const Ended told = mover.end();
  EXPECT_EQ(told.exit, 1);
  EXPECT_NE(told.err.find("sinew resume left goes on with it"), std::string::npos) << told.err;
  EXPECT_TRUE(cell.comes_to("left", "held"));
  EXPECT_EQ(cell.ask({"resume", "left"}).exit, 1) << "another process has control";
  const Ended resumed = cell.ask({"resume", "left", "--take-over"});
  EXPECT_EQ(resumed.exit, 0) << resumed.err;
}

TEST(Cell, pauses_goes_on_and_stops_for_anybody) {
  Cell cell;
  ASSERT_EQ(cell.ask({"move", "left", kStand}).exit, 0);
  Process mover(cell.on({"move", "left", "joint", "base=60deg", "speed=2%"}));
  ASSERT_TRUE(cell.comes_to("left", "moving"));
  EXPECT_EQ(cell.ask({"pause", "left"}).exit, 0);
  EXPECT_TRUE(cell.comes_to("left", "held"));
  EXPECT_EQ(cell.ask({"resume", "left"}).exit, 0);
  ASSERT_TRUE(cell.comes_to("left", "moving"));
  EXPECT_EQ(cell.ask({"stop"}).exit, 0);
  const Ended stopped = mover.end();
  EXPECT_EQ(stopped.exit, 1);
  EXPECT_NE(stopped.err.find("stopped"), std::string::npos) << stopped.err;
}

TEST(Cell, ctrl_c_stops_the_program_of_whoever_presses_it) {
  Cell cell;
  ASSERT_EQ(cell.ask({"move", "left", kStand}).exit, 0);
  Process mover(cell.on({"move", "left", "joint", "base=90deg", "speed=2%"}));
  ASSERT_TRUE(cell.comes_to("left", "moving"));
  mover.signal(SIGINT);
  EXPECT_EQ(mover.end().exit, 1);
  EXPECT_TRUE(cell.comes_to("left", "ready"));
}

TEST(Cell, the_server_ends_in_order_while_something_moves) {
  Cell cell;
  ASSERT_EQ(cell.ask({"move", "left", kStand}).exit, 0);
  Process mover(cell.on({"move", "left", "joint", "base=90deg", "speed=2%"}));
  ASSERT_TRUE(cell.comes_to("left", "moving"));
  cell.process().signal(SIGINT);
  EXPECT_EQ(cell.process().end().exit, 0);
  const Ended left = mover.end();
  EXPECT_EQ(left.exit, 1);
  EXPECT_NE(left.err.find("the server has gone away"), std::string::npos) << left.err;
}

}  // namespace
}  // namespace sinew::test
