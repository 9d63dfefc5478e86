#include <gtest/gtest.h>

#include <chrono>
#include <csignal>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <limits>
#include <set>

#include "cli/process.h"
#include "sinew/io/port.h"
#include "support/scratch_folder.h"
#include "support/tcp_server.h"

/// Arms that are a table and limits: they have the ideal device.
namespace sinew::test {
namespace {

using namespace std::chrono_literals;

const std::string kExamples = std::string(SINEW_SOURCE_DIR) + "/robots/examples/";
const std::string kAr4 = kExamples + "ar4.toml";
const std::string kAr4Grbl = kExamples + "ar4-grbl.toml";
const std::string kSo101 = kExamples + "so-101-feetech.toml";

double position(const Json& report, std::size_t joint, const char* quality = "measured") {
  const Json& one = report["positions"][joint];
  EXPECT_EQ(one["quality"], quality) << report.dump();
  for (const char* key : {"q_deg", "q_mm"}) {
    if (one.contains(key)) return one[key];
  }
  return std::numeric_limits<double>::quiet_NaN();
}

TEST(AnyArm, each_example_goes_where_it_is_sent_and_says_who_told_its_numbers) {
  const ScratchFolder folder;
  std::set<std::string> seen;
  for (const auto& entry : std::filesystem::directory_iterator(kExamples)) {
    if (entry.path().extension() != ".toml") continue;
    const std::string robot = entry.path().string();
    seen.insert(entry.path().stem().string());
    if (entry.path().stem().string().contains("-axis-link")) continue;
    if (entry.path().stem().string().contains("-grbl")) continue;
    if (entry.path().stem().string().contains("-feetech")) continue;
    SCOPED_TRACE(robot);
    const Ended shown = sinew({"robots", robot, "--json"});
    ASSERT_EQ(shown.exit, 0) << shown.err;
    EXPECT_EQ(shown.json()["protocol"], "ideal");
    const bool lifts = entry.path().stem() == "scara";
    const std::string program =
        folder.file("p.sinew", std::string("joint J1=100deg J2=") + (lifts ? "80mm" : "80deg") +
                                   " J3=20deg speed=50%\njoint J1=60deg\n");
    const Ended run = sinew({"run", program, "--robot", robot, "--json", "--time-scale", "5"});
    ASSERT_EQ(run.exit, 0) << run.err << run.out;
    EXPECT_NEAR(position(run.json(), 0), 60, 1e-3);
    EXPECT_NEAR(position(run.json(), 2), 20, 1e-3);
  }
  EXPECT_EQ(seen,
            (std::set<std::string>{"ar4", "ar4-axis-link", "ar4-grbl", "scara", "scara-grbl",
                                   "six-axis", "so-101", "so-101-feetech", "uarm-swift-pro"}));
}

TEST(AnyArm, an_ar4_of_26_lines_draws_lines_and_goes_home) {
  const ScratchFolder folder;
  const std::string lines = folder.file("q.sinew",
                                        "joint shoulder=20deg elbow=10deg wrist=45deg\n"
                                        "line dx=30mm dz=-40mm\nline dy=-50mm blend=10mm\n"
                                        "line dz=30mm\nhome\n");
  const Ended run = sinew({"run", lines, "--robot", kAr4, "--json", "--time-scale", "5"});
  ASSERT_EQ(run.exit, 0) << run.err << run.out;
  for (std::size_t i = 0; i < 6; ++i) EXPECT_NEAR(position(run.json(), i), 0, 1e-3);
}

TEST(AnyArm, an_ar4_on_the_axis_link_homes_and_moves_at_26700_steps_a_second) {
  const ScratchFolder folder;
  const std::string program =
      folder.file("p.sinew", "home\njoint shoulder=60deg elbow=-80deg\njoint shoulder=0deg\n");
  const Ended run = sinew({"run", program, "--robot", kExamples + "ar4-axis-link.toml", "--json",
                           "--time-scale", "100"});
  ASSERT_EQ(run.exit, 0) << run.err << run.out;
  EXPECT_NEAR(position(run.json(), 1), 0, 0.3);
  EXPECT_NEAR(position(run.json(), 2), -80, 0.3);
}

TEST(AnyArm, an_ar4_on_a_board_that_speaks_grbl_homes_and_keeps_the_time_of_its_plan) {
  const ScratchFolder folder;
  const std::string program =
      folder.file("p.sinew",
                  "home\njoint shoulder=20deg elbow=10deg wrist=45deg\nline dx=30mm dz=-40mm\n"
                  "line dy=-50mm blend=10mm\nline dz=30mm\njoint shoulder=0deg\n");
  for (const char* firmware : {"grbl", "grblhal", "fluidnc"}) {
    const Ended run = sinew({"run", program, "--robot", kAr4Grbl, "--json", "--profile", firmware,
                             "--time-scale", "50"});
    ASSERT_EQ(run.exit, 0) << run.err << run.out;
    EXPECT_NEAR(position(run.json(), 1, "commanded"), 0, 0.01);
    EXPECT_NEAR(position(run.json(), 4, "commanded"), 46.15, 0.02);
  }
}

constexpr const char* kScaraRows =
    "joint base=40deg lift=80mm elbow=-60deg hand=10deg\nline x=250mm y=100mm z=50mm\n"
    "line dz=40mm\nmove x=150mm y=200mm z=90mm rz=90deg\nmove x=250mm y=-100mm rz=0deg\n"
    "line dy=60mm speed=50mm/s blend=10mm\nline x=200mm y=20mm z=20mm\njoint d.lift=30mm\n";

TEST(AnyArm, a_scara_lifts_draws_and_turns_its_tool_simulated_and_on_a_board_that_speaks_grbl) {
  const ScratchFolder folder;
  const std::string rows = kScaraRows;
  const Ended ideal = sinew({"run", folder.file("p.sinew", rows), "--robot",
                             kExamples + "scara.toml", "--json", "--time-scale", "20"});
  ASSERT_EQ(ideal.exit, 0) << ideal.err << ideal.out;
  const Ended board = sinew({"run", folder.file("h.sinew", "home\n" + rows), "--robot",
                             kExamples + "scara-grbl.toml", "--json", "--time-scale", "50"});
  ASSERT_EQ(board.exit, 0) << board.err << board.out;
  for (std::size_t i = 0; i < 4; ++i) {
    EXPECT_NEAR(position(board.json(), i, "commanded"), position(ideal.json(), i), 0.04) << i;
  }
  EXPECT_NEAR(position(ideal.json(), 1), 50, 1e-3);
}

TEST(AnyArm, a_scara_goes_to_taught_joints_and_refuses_what_it_cannot_have_with_its_unit) {
  const ScratchFolder folder;
  folder.file("points.toml",
              "[points.up]\nrobot = \"scara\"\n"
              "joints = [\"30deg\", \"120mm\", \"60deg\", \"-90deg\"]\n"
              "[points.legs]\nrobot = \"scara\"\njoints_deg = [1, 2, 3, 4]\n"
              "[points.two]\nrobot = \"scara\"\njoints = [\"1deg\", \"2mm\"]\n");
  const auto run = [&](const std::string& row) {
    return sinew({"run", folder.file("p.sinew", row + "\n"), "--robot", kExamples + "scara.toml",
                  "--json", "--time-scale", "20"});
  };
  const Ended taught = run("joint to=up");
  ASSERT_EQ(taught.exit, 0) << taught.err;
  EXPECT_NEAR(position(taught.json(), 1), 120, 1e-3);
  EXPECT_NEAR(position(taught.json(), 3), -90, 1e-3);
  const struct {
    const char* row;
    const char* sentence;
  } kRefused[] = {
      {"joint to=legs", "'legs' has degrees where scara has mm, or mm for degrees"},
      {"joint to=two", "'two' has 2 joints, scara has 4 joints"},
      {"joint lift=200mm", "lift would need 200 mm, limit 150 mm"},
      {"joint lift=30deg", "'30deg' ends in 'deg', which is none of mm"},
      {"line z=-5mm", "lift would need -5 mm, limit 0 mm"},
      {"line rx=10deg", "rz alone turns this tool; rx, ry and rz together name an orientation"},
      {"move x=250mm y=0mm z=50mm rx=90deg ry=0deg rz=0deg",
       "the nearest orientation is 90 deg away"},
      {"move x=500mm y=0mm z=50mm", "out of reach by 135.5 mm"},
  };
  for (const auto& [row, sentence] : kRefused) {
    const Ended refused = run(row);
    EXPECT_NE(refused.exit, 0) << row;
    EXPECT_TRUE(refused.err.contains(sentence)) << refused.err;
  }
}

TEST(AnyArm, the_table_of_a_scaras_links_has_its_slide_where_it_is) {
  const Ended shown = sinew(
      {"fk", kExamples + "scara.toml", "--joints-deg", "10,50mm,20,30", "--frames", "--json"});
  ASSERT_EQ(shown.exit, 0) << shown.err;
  const Json lift = shown.json()["dh"][1];
  EXPECT_EQ(lift["theta_deg"], 0.0);
  EXPECT_NEAR(lift["d_mm"].get<double>(), 160, 1e-9);
  EXPECT_NEAR(shown.json()["joints_deg_mm"][1].get<double>(), 50, 1e-9);
}

TEST(AnyArm, a_first_day_moves_what_slides_by_millimetres) {
  const ScratchFolder folder;
  std::ifstream file(kExamples + "scara-grbl.toml");
  std::string robot((std::istreambuf_iterator<char>(file)), {});
  const std::string homing = "homing = \"yes\"";
  robot.replace(robot.find(homing), homing.size(), "homing = \"no\"");
  // 5 mm below its limit there is room for a small step upwards, and for none of 2 deg as metres.
  const std::string answers =
      folder.file("answers",
                  "* = yes\nplace = 0deg, 145mm, 90deg, -90deg\ndirection.base = plus\n"
                  "direction.lift = plus\ndirection.elbow = plus\ndirection.hand = plus\n");
  const Ended day = sinew({"commission", folder.file("scara.toml", robot), "--answers", answers,
                           "--save", folder.at("found.json"), "--json"});
  ASSERT_EQ(day.exit, 0) << day.err << day.out;
  EXPECT_FALSE(day.out.contains(".turn")) << day.out;
}

TEST(AnyArm, a_first_day_on_grbl_finds_a_motor_that_turns_the_other_way_and_the_switches) {
  const ScratchFolder folder;
  const std::string answers = folder.file(
      "answers",
      "* = yes\ndirection.base = plus\ndirection.shoulder = minus\ndirection.elbow = plus\n"
      "direction.forearm = plus\ndirection.wrist = plus\ndirection.hand = plus\n");
  const std::string saved = folder.at("found.json");
  const Ended day =
      sinew({"commission", kAr4Grbl, "--answers", answers, "--save", saved, "--json"});
  ASSERT_EQ(day.exit, 0) << day.err << day.out;
  std::ifstream file(saved);
  const std::string text((std::istreambuf_iterator<char>(file)), {});
  EXPECT_TRUE(text.contains("joint.shoulder.turn")) << text;
  const Ended home =
      sinew({"commission", kAr4Grbl, "--procedure", "home", "--answers",
             folder.file("home", "* = yes\nsearch = go\nagain = skip\nhome = go\n"), "--json"});
  EXPECT_EQ(home.exit, 0) << home.err << home.out;
}

/// In another process, on a port.
class OnAPort {
 public:
  explicit OnAPort(const std::string& robot) : sim_({"sim", robot, "--json"}) {
    const std::string first = sim_.line_after(0);
    seen_ = first.size() + 1;
    port_ = Json::parse(first).at("port");
  }
  const std::string& port() const { return port_; }
  double base() {
    sim_.signal(SIGUSR1);
    const std::string line = sim_.line_after(seen_);
    seen_ += line.size() + 1;
    return Json::parse(line).at("truth").at("joints").at(0).at("q_deg");
  }
  /// Until its base has come so far.
  void wait_for(double degrees) {
    const auto limit = std::chrono::steady_clock::now() + 20s;
    while (base() < degrees && std::chrono::steady_clock::now() < limit) {
      sim_.let_run(5ms);
    }
  }

 private:
  Process sim_;
  std::size_t seen_ = 0;
  std::string port_;
};

TEST(AnyArm, a_host_that_is_killed_leaves_it_standing_and_the_next_one_goes_on) {
  const ScratchFolder folder;
  setenv("XDG_STATE_HOME", folder.at("xdg").c_str(), 1);
  OnAPort arm(kAr4);
  const auto run_of = [&](const char* row) {
    return Arguments{"run",     folder.file("p.sinew", row),
                     "--robot", kAr4,
                     "--port",  arm.port(),
                     "--json",  "--journal",
                     "one"};
  };
  Process dies(run_of("joint base=150deg\n"));
  arm.wait_for(20);
  dies.signal(SIGKILL);
  dies.end();
  const Ended next = sinew(run_of("joint base=10deg\n"));
  ASSERT_EQ(next.exit, 0) << next.err << next.out;
  EXPECT_NEAR(position(next.json(), 0), 10, 1e-3);
  EXPECT_NEAR(arm.base(), 10, 1e-3);
}

TEST(AnyArm, an_so_101_on_its_servos_keeps_the_time_of_its_plan_and_comes_near_its_targets) {
  const ScratchFolder folder;
  const std::string program = folder.file(
      "p.sinew",
      "joint pan=30deg lift=20deg elbow=-20deg wrist=30deg\njaws 30mm\njoint pan=-30deg\n");
  for (const char* series : {"sts", "scs"}) {
    const Ended run = sinew({"run", program, "--robot", kSo101, "--profile", series, "--json"});
    ASSERT_EQ(run.exit, 0) << run.err << run.out;
    const double near = series == std::string("sts") ? 0.6 : 1.2;
    EXPECT_NEAR(position(run.json(), 0), -30, near);
    EXPECT_NEAR(position(run.json(), 1), 20, near);
    for (const Json& order : run.json()["orders"]) {
      if (!order.contains("predicted_s")) continue;
      EXPECT_LE(order["took_s"].get<double>(), order["predicted_s"].get<double>() + 0.3) << order;
    }
  }
}

TEST(AnyArm, a_host_that_is_killed_leaves_servos_at_their_last_goal_and_nothing_has_to_be_found) {
  const ScratchFolder folder;
  setenv("XDG_STATE_HOME", folder.at("xdg").c_str(), 1);
  OnAPort arm(kSo101);
  const auto run_of = [&](const char* row) {
    return Arguments{"run",     folder.file("p.sinew", row),
                     "--robot", kSo101,
                     "--port",  arm.port(),
                     "--json",  "--journal",
                     "one"};
  };
  Process dies(run_of("joint pan=100deg speed=50%\n"));
  arm.wait_for(30);
  dies.signal(SIGKILL);
  dies.end();
  const double there = arm.base();
  EXPECT_LT(there, 95);
  const Ended next = sinew(run_of("joint pan=10deg\n"));
  ASSERT_EQ(next.exit, 0) << next.err << next.out;
  EXPECT_NEAR(arm.base(), 10, 0.6);
}

TEST(AnyArm, a_first_day_on_servos_finds_one_that_counts_the_other_way_and_each_zero) {
  const ScratchFolder folder;
  const std::string answers =
      folder.file("answers",
                  "* = yes\nfree = go\nhold = go\njaws = go\njaws_seen = open\n"
                  "direction.pan = plus\ndirection.lift = plus\ndirection.elbow = minus\n"
                  "direction.wrist = plus\ndirection.roll = plus\n");
  const std::string saved = folder.at("found.json");
  const Ended day = sinew({"commission", kSo101, "--answers", answers, "--save", saved, "--json"});
  ASSERT_EQ(day.exit, 0) << day.err << day.out;
  std::ifstream file(saved);
  const std::string text((std::istreambuf_iterator<char>(file)), {});
  EXPECT_TRUE(text.contains("joint.elbow.turn")) << text;
  EXPECT_TRUE(text.contains("joint.lift.trim_rad")) << text;
  EXPECT_TRUE(text.contains("model 777")) << text;
}

/// A copy of the AR4 on GRBL with something changed.
std::string grbl_with(const ScratchFolder& folder, const std::string& name, const std::string& from,
                      const std::string& to) {
  std::ifstream file(kAr4Grbl);
  std::string text((std::istreambuf_iterator<char>(file)), {});
  const std::size_t at = text.find(from);
  EXPECT_NE(at, std::string::npos) << from;
  return folder.file(name, text.replace(at, from.size(), to));
}

TEST(AnyArm, a_grbl_board_counts_on_while_hosts_come_die_and_come_again) {
  const ScratchFolder folder;
  setenv("XDG_STATE_HOME", folder.at("xdg").c_str(), 1);
  const std::string robot = grbl_with(folder, "g.toml", "homing = \"yes\"", "homing = \"no\"");
  OnAPort arm(robot);
  const auto run_of = [&](const char* row, std::initializer_list<const char*> more = {}) {
    Arguments words{"run",     folder.file("p.sinew", row),
                    "--robot", robot,
                    "--port",  arm.port(),
                    "--json",  "--journal",
                    "one"};
    for (const char* one : more) words.emplace_back(one);
    return words;
  };
  EXPECT_NE(sinew(run_of("joint base=10deg\n")).exit, 0);
  EXPECT_EQ(sinew(run_of("joint base=10deg\n", {"--standing-at", "home"})).exit, 0);
  EXPECT_NEAR(arm.base(), 10, 0.01);
  Process dies(run_of("joint base=150deg\n"));
  arm.wait_for(30);
  dies.signal(SIGKILL);
  dies.end();
  const Ended next = sinew(run_of("joint base=20deg\n"));
  ASSERT_EQ(next.exit, 0) << next.err << next.out;
  EXPECT_NEAR(arm.base(), 20, 0.01);
}

/// What makes a serial port one in the network, as ser2net or a board with WLAN does.
void bridge(TcpTestServer::Client& client, const std::string& path) {
  auto port = io::Port::open_serial(path, 115'200);
  if (!port) return;
  std::array<std::uint8_t, 1024> buffer{};
  while (client.stays(0)) {
    const std::string said = client.receive(1);
    if (!port->write({reinterpret_cast<const std::uint8_t*>(said.data()), said.size()})) return;
    const auto count = port->read(buffer, 1ms);
    if (!count) return;
    if (!client.send({reinterpret_cast<const char*>(buffer.data()), *count})) return;
  }
}

TEST(AnyArm, a_board_is_reached_over_tcp) {
  const ScratchFolder folder;
  setenv("XDG_STATE_HOME", folder.at("xdg").c_str(), 1);
  const std::string robot = grbl_with(folder, "g.toml", "homing = \"yes\"", "homing = \"no\"");
  OnAPort arm(robot);
  TcpTestServer server([&](auto& client, int) { bridge(client, arm.port()); });
  const std::string port = "tcp:127.0.0.1:" + std::to_string(server.port());
  const auto run_of = [&](const char* row, std::initializer_list<const char*> more = {}) {
    Arguments words{"run", folder.file("p.sinew", row), "--robot", robot, "--port", port, "--json"};
    for (const char* one : more) words.emplace_back(one);
    return words;
  };
  const Ended first = sinew(run_of("joint base=20deg\n", {"--standing-at", "home"}));
  ASSERT_EQ(first.exit, 0) << first.err;
  const Ended next = sinew(run_of("joint base=10deg\n"));
  ASSERT_EQ(next.exit, 0) << next.err;
  EXPECT_NEAR(arm.base(), 10, 0.01);
  server.end();
  const Ended gone = sinew(run_of("joint base=0deg\n"));
  EXPECT_NE(gone.exit, 0);
  EXPECT_TRUE(gone.err.contains("127.0.0.1")) << gone.err;
}

TEST(AnyArm, a_grbl_board_that_is_set_up_otherwise_moves_nothing_and_says_what) {
  const ScratchFolder folder;
  OnAPort arm(kAr4Grbl);
  const std::string robot =
      grbl_with(folder, "g.toml", "velocity_deg_s_max = 60", "velocity_deg_s_max = 90");
  const Ended run = sinew(
      {"run", folder.file("p.sinew", "home\n"), "--robot", robot, "--port", arm.port(), "--json"});
  EXPECT_NE(run.exit, 0);
  EXPECT_TRUE(
      run.err.contains("the board moves base at 60 deg/s at most, and the robot's file "
                       "says 90 deg/s"))
      << run.err;
}

TEST(AnyArm, ctrl_c_in_the_middle_stops_it_on_its_path) {
  const ScratchFolder folder;
  setenv("XDG_STATE_HOME", folder.at("xdg").c_str(), 1);
  OnAPort arm(kAr4);
  Process run({"run", folder.file("p.sinew", "joint base=150deg\n"), "--robot", kAr4, "--port",
               arm.port(), "--json"});
  arm.wait_for(20);
  run.signal(SIGINT);
  const Ended ended = run.end();
  EXPECT_NE(ended.exit, 0);
  const double there = arm.base();
  EXPECT_GT(there, 20);
  EXPECT_LT(there, 60);
  EXPECT_NEAR(position(ended.json(), 0), there, 1e-3);
}

TEST(AnyArm, bad_files_and_ports_are_said_with_what_helps) {
  const ScratchFolder folder;
  const std::string program = folder.file("p.sinew", "joint base=10deg\n");
  const auto said = [&](const Arguments& words, int exit, const std::string& part) {
    const Ended ended = sinew(words);
    EXPECT_EQ(ended.exit, exit) << ended.err;
    EXPECT_TRUE(ended.err.contains(part)) << ended.err;
  };
  const std::string none =
      folder.file("none.toml", "id = \"x\"\ntitle = \"x\"\n[device]\nprotocol = \"none\"\n");
  said({"run", program, "--robot", none}, 2, "none");
  said({"run", program, "--robot", kAr4, "--profile", "fast"}, 2,
       "--profile: 'fast' is unknown: ar4 has but one");
  said({"run", program, "--robot", kAr4, "--wire", "text"}, 2,
       "--wire: 'text' is unknown: ar4 has but one");
  said({"run", program, "--robot", kAr4, "--port", "/dev/null"}, 1, "/dev/null: not a serial port");
  said({"run", program, "--robot", kAr4, "--port", "spidev"}, 1, "serial port");
  said({"run", folder.file("far.sinew", "joint base=171deg\n"), "--robot", kAr4}, 1,
       "base would need 171 deg, limit 170 deg");
  said({"commission", "ar4"}, 2, "ar4");
}

}  // namespace
}  // namespace sinew::test
