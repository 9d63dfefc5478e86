#include <gtest/gtest.h>

#include <fstream>
#include <iterator>

#include "cli/process.h"
#include "support/scratch_folder.h"

/// `sinew check`, `fmt` and `convert`, points beside a program and programs that are called, runs
/// that go on in the middle.
namespace sinew::test {
namespace {

std::string text_of(const std::string& path) {
  std::ifstream file(path);
  return {std::istreambuf_iterator<char>(file), {}};
}

TEST(CheckVerb, gives_each_row_its_verdict_and_goes_on_behind_a_refused_one) {
  const ScratchFolder folder;
  const std::string file = folder.file("p.sinew",
                                       "joint base=20deg shoulder=20deg elbow=40deg wrist=40deg\n"
                                       "joint base=500deg\n"
                                       "line z=200mm\n"
                                       "jaws 20mm\n");
  const Ended text = sinew({"check", file, "--robot", "learm"});
  EXPECT_EQ(text.exit, 2);
  EXPECT_NE(text.out.find("base would need 500 deg"), std::string::npos) << text.out;
  EXPECT_NE(text.out.find("not checked, because nobody knows where line 2 would have left the arm"),
            std::string::npos)
      << text.out;
  EXPECT_NE(text.out.find("1 refused, 1 not checked; checked from the home"), std::string::npos);
  const Ended json = sinew({"check", file, "--robot", "learm", "--json"});
  EXPECT_EQ(json.exit, 2);
  const Json rows = json.json()["rows"];
  ASSERT_EQ(rows.size(), 4U);
  EXPECT_EQ(rows[0]["verdict"], "fine");
  EXPECT_GT(rows[0]["time_max_s"], 0.1);
  EXPECT_EQ(rows[1]["verdict"], "refused");
  EXPECT_EQ(rows[1]["refusal"]["code"], "joint_limit");
  EXPECT_EQ(rows[2]["verdict"], "not_checked");
  EXPECT_EQ(rows[2]["because_of_line"], 2);
  EXPECT_EQ(rows[3]["verdict"], "fine");
}

TEST(CheckVerb, says_what_would_work_instead_of_a_refused_line) {
  const ScratchFolder folder;
  const std::string file = folder.file("p.sinew",
                                       "joint J1=0deg J2=20deg J3=-30deg J5=30deg\n"
                                       "line z=-400mm\nline dz=5mm\n");
  const Ended ended = sinew({"check", file, "--robot", "robot-arm-2", "--json"});
  EXPECT_EQ(ended.exit, 2) << ended.err;
  const Json rows = ended.json()["rows"];
  EXPECT_EQ(rows[1]["verdict"], "refused") << rows;
  EXPECT_TRUE(rows[1]["refusal"].contains("would_work")) << rows[1];
}

TEST(CheckVerb, sample_programs_are_all_fine_and_laid_out) {
  for (const char* sample :
       {"bigrobotarm/line", "bigrobotarm/wave", "hexapod/nod", "hexapod/tilt",
        "learm/pick_and_place", "learm/square", "learm/wave", "maxarm/pick",
        "maxarm/pick_and_place", "maxarm/stack", "robot-arm-2/first_moves", "robot-arm-2/square"}) {
    const std::string name = sample;
    const std::string file = SINEW_SOURCE_DIR "/robots/" + name + ".sinew";
    const Ended checked = sinew({"check", file, "--robot", name.substr(0, name.find('/'))});
    EXPECT_EQ(checked.exit, 0) << checked.out << checked.err;
    EXPECT_EQ(sinew({"fmt", "--check", file}).exit, 0) << file;
  }
}

TEST(CheckVerb, points_beside_the_program_and_called_programs_are_used_by_check_plan_and_run) {
  const ScratchFolder folder;
  folder.file("points.toml",
              "[points.ready]\nrobot = \"learm\"\njoints_deg = [10, 20, 40, 40, 0]\n"
              "[points.other]\nrobot = \"maxarm\"\nx_mm = 1\ny_mm = 2\nz_mm = 3\n");
  folder.file("grip.sinew", "jaws 20mm\nif base>5deg\n  wait 0.1s\nelse\n  wait 3s\nend\n");
  const std::string file = folder.file("p.sinew", "joint to=ready\nline dz=-10mm\ncall grip\n");
  const Ended checked = sinew({"check", file, "--robot", "learm", "--json"});
  EXPECT_EQ(checked.exit, 0) << checked.out;
  const Json answer = checked.json();
  EXPECT_NEAR(answer["duration_max_s"].get<double>() - answer["duration_min_s"].get<double>(), 2.9,
              1e-6);
  EXPECT_TRUE(answer["rows"][2]["file"].get<std::string>().ends_with("/grip.sinew"));
  const Ended plan = sinew({"plan", file, "--robot", "learm", "--json"});
  EXPECT_EQ(plan.exit, 0) << plan.err;
  EXPECT_NE(plan.out.find("both of its branches are checked"), std::string::npos);
  const Ended run = sinew({"run", file, "--robot", "learm", "--time-scale", "20", "--json"});
  EXPECT_EQ(run.exit, 0) << run.err;
  const Json orders = run.json()["orders"];
  ASSERT_EQ(orders.size(), 5U) << orders;
  EXPECT_EQ(orders[3]["command"], "if base > 5 deg: yes");
  EXPECT_TRUE(orders[3]["file"].get<std::string>().ends_with("/grip.sinew"));
  const Ended wrong = sinew({"check", file, "--robot", "maxarm"});
  EXPECT_EQ(wrong.exit, 2);
  EXPECT_NE(wrong.err.find("p.sinew:1:7: 'ready' is a point of learm, not of maxarm"),
            std::string::npos)
      << wrong.err;
}

TEST(CheckVerb, broken_points_refuse_only_the_rows_that_use_them) {
  const ScratchFolder folder;
  folder.file("points.toml", "[points.a]\nrobot = \"learm\"\n[points.b]\nx_mm = 1\n");
  const std::string file = folder.file("p.sinew", "wait 1s\n");
  EXPECT_EQ(sinew({"check", file, "--robot", "learm"}).exit, 0);
  const std::string uses = folder.file("q.sinew", "joint to=a\n");
  EXPECT_EQ(sinew({"check", uses, "--robot", "learm", "--json"}).exit, 2);
}

TEST(FmtVerb, lays_out_in_place_and_only_looks_where_it_is_asked_to) {
  const ScratchFolder folder;
  const std::string good = folder.file("good.sinew", "wait 1s\n");
  const std::string file = folder.file("p.sinew", "loop 2\nwait\t1s\r\nend");
  const Ended look = sinew({"fmt", "--check", good, file});
  EXPECT_EQ(look.exit, 1);
  EXPECT_EQ(look.out, file + "\n");
  EXPECT_EQ(text_of(file), "loop 2\nwait\t1s\r\nend");
  const Ended done = sinew({"fmt", good, file, "--json"});
  EXPECT_EQ(done.exit, 0) << done.err;
  EXPECT_EQ(done.json()["files"][0]["changed"], false);
  EXPECT_EQ(done.json()["files"][1]["changed"], true);
  EXPECT_EQ(text_of(file), "loop 2\n  wait 1s\nend\n");
  EXPECT_EQ(sinew({"fmt", "--check", good, file}).exit, 0);
}

TEST(FmtVerb, leaves_a_text_that_it_does_not_understand_as_it_is) {
  const ScratchFolder folder;
  const std::string file = folder.file("p.sinew", "wiat  1s\nend\n");
  const Ended ended = sinew({"fmt", file});
  EXPECT_EQ(ended.exit, 2);
  EXPECT_NE(ended.err.find("p.sinew:1:1: unknown step 'wiat'; did you mean wait?"),
            std::string::npos)
      << ended.err;
  EXPECT_EQ(text_of(file), "wiat  1s\nend\n");
}

TEST(ConvertVerb, gcode_becomes_a_program_that_can_be_checked) {
  const ScratchFolder folder;
  const std::string file = folder.file("p.nc",
                                       "G21 G90\nG0 X-40 Y-180 Z140 (above)\nG1 Z110 F2400\nM3\n"
                                       "G4 P0.5\nG1 Z140\nM5\n");
  const std::string out = folder.at("p.sinew");
  const Ended done = sinew({"convert", file, out, "--robot", "maxarm"});
  ASSERT_EQ(done.exit, 0) << done.err;
  EXPECT_EQ(text_of(out),
            "move x=-40mm y=-180mm z=140mm  # above\nline z=110mm speed=40mm/s\nsuction on\n"
            "wait 0.5s\nline z=140mm speed=40mm/s\nsuction off\n");
  EXPECT_EQ(sinew({"check", out, "--robot", "maxarm", "--from-joints", "90,110,30"}).exit, 0);
  EXPECT_EQ(sinew({"fmt", "--check", out}).exit, 0);
  const std::string arc = folder.file("arc.nc", "G2 X1 I1\n");
  const Ended refused = sinew({"convert", arc, out, "--robot", "maxarm", "--json", "--replace"});
  EXPECT_EQ(refused.exit, 2);
  EXPECT_EQ(refused.json()["error"]["complaints"].size(), 2U);
  EXPECT_TRUE(text_of(out).starts_with("move")) << "nothing is written then";
}

TEST(ConvertVerb, pose_of_the_platform_goes_to_a_row_and_back) {
  const ScratchFolder folder;
  const std::string row =
      folder.file("p.sinew", "move x=1.5mm y=-2mm z=251mm rx=0.5deg ry=1deg rz=2deg\n");
  const std::string pos = folder.at("p.pos");
  const Ended there = sinew({"convert", row, pos, "--robot", "hexapod", "--decimal-comma"});
  ASSERT_EQ(there.exit, 0) << there.err;
  EXPECT_NE(text_of(pos).find(','), std::string::npos);
  EXPECT_EQ(text_of(pos).find('.'), std::string::npos);
  const Ended back = sinew({"convert", pos, "--robot", "hexapod"});
  ASSERT_EQ(back.exit, 0) << back.err;
  EXPECT_NE(back.out.find("move x=1.5mm y=-2mm z=251mm rx=0.5deg ry=1deg rz=2deg"),
            std::string::npos)
      << back.out;
  EXPECT_EQ(sinew({"convert", pos, "--robot", "learm"}).exit, 2);
  const std::string cfg =
      folder.file("config.cfg", "COM3\r\nC:\\\r\n" + text_of(pos) + text_of(pos));
  const Ended config = sinew({"convert", cfg, "--robot", "hexapod", "--json"});
  ASSERT_EQ(config.exit, 0) << config.err;
  EXPECT_EQ(config.json()["legs"][5]["quality"], "uncertain");
  EXPECT_NEAR(config.json()["pose"]["z_mm"], 251, 1e-6);
  EXPECT_NE(
      sinew({"convert", cfg, "--robot", "hexapod", "--journal", "a b"}).err.find("is no name"),
      std::string::npos);
  setenv("XDG_STATE_HOME", folder.at("state").c_str(), 1);
  // Twice: the second time the journal knows something, even if it is little.
  const std::vector<std::string> taken{"convert", cfg, "--robot", "hexapod", "--journal", "old"};
  const Ended first = sinew(taken);
  ASSERT_EQ(first.exit, 0) << first.err;
  EXPECT_NE(first.out.find("/old begins with that"), std::string::npos) << first.out;
  EXPECT_NE(sinew(taken).err.find("--replace takes the file's word"), std::string::npos);
  unsetenv("XDG_STATE_HOME");
  std::string bent = text_of(pos);
  bent.replace(0, bent.find('\n'), "0");
  const Ended other = sinew({"convert", folder.file("bent.pos", bent), "--robot", "hexapod"});
  EXPECT_EQ(other.exit, 2);
  EXPECT_NE(other.err.find("no place of hexapod's platform"), std::string::npos) << other.err;
}

TEST(ConvertVerb, sequence_goes_to_rows_and_back_and_what_does_not_is_told) {
  const ScratchFolder folder;
  const std::string text = "S1\nBEGIN I5\nG0 B100 S200 E300 WR400 W300\nG1 E1 P40\nEND\n";
  const std::string file = folder.file("s.txt", text);
  const std::string rows = folder.at("s.sinew"), again = folder.at("again.txt");
  ASSERT_EQ(sinew({"convert", file, rows, "--robot", "bigrobotarm"}).exit, 0);
  ASSERT_EQ(sinew({"convert", rows, again, "--robot", "bigrobotarm"}).exit, 0);
  EXPECT_EQ(text_of(again), text);
  const Ended sample = sinew(
      {"convert", SINEW_SOURCE_DIR "/robots/bigrobotarm/sequence.txt", "--robot", "bigrobotarm"});
  EXPECT_EQ(sample.exit, 0) << sample.err;
  EXPECT_NE(sample.out.find("# without S1 each joint"), std::string::npos) << sample.out;
  EXPECT_EQ(sinew({"convert", file, rows, "--robot", "learm"}).exit, 2);
  EXPECT_EQ(sinew({"convert", rows, rows, "--robot", "bigrobotarm"}).exit, 2) << "onto itself";
  const Ended taken = sinew({"convert", file, rows, "--robot", "bigrobotarm"});
  EXPECT_EQ(taken.exit, 2);
  EXPECT_NE(taken.err.find("--replace"), std::string::npos) << taken.err;
  EXPECT_EQ(sinew({"convert", file, rows, "--robot", "bigrobotarm", "--replace"}).exit, 0);
  const Ended kind = sinew({"convert", folder.file("x.dat", "1"), "--robot", "learm"});
  EXPECT_EQ(kind.exit, 2);
  EXPECT_NE(kind.err.find("its ending does not say what it is"), std::string::npos);
}

TEST(RunPart, goes_on_from_a_line_and_slows_all_rows_down) {
  const ScratchFolder folder;
  const std::string file =
      folder.file("p.sinew",
                  "joint base=500deg\njoint base=10deg shoulder=0deg elbow=0deg "
                  "wrist=0deg roll=0deg\nloop 2\n  wait 0.1s\nend\n");
  const Arguments run{"run",  file,           "--robot", "learm", "--standing-at",
                      "home", "--time-scale", "20",      "--json"};
  EXPECT_EQ(sinew(run).exit, 1);
  const auto with = [&](Arguments more) {
    Arguments words = run;
    words.insert(words.end(), more.begin(), more.end());
    return sinew(words);
  };
  const Ended part = with({"--from-line", "2", "--speed", "30%"});
  ASSERT_EQ(part.exit, 0) << part.err;
  EXPECT_EQ(part.json()["orders"].size(), 3U);
  EXPECT_EQ(part.json()["orders"][0]["line"], 2);
  EXPECT_EQ(part.json()["from_line"], 2);
  EXPECT_EQ(part.json()["speed"]["through"], "feed");
  EXPECT_EQ(with({"--from-line", "4"}).exit, 2);
  EXPECT_NE(with({"--from-line", "4"}).err.find("inside the loop of line 3"), std::string::npos);
  EXPECT_EQ(with({"--from-line", "9"}).exit, 2);
  EXPECT_EQ(with({"--from-line", "2", "--speed", "0%"}).exit, 2);
  EXPECT_EQ(with({"--from-line", "2", "--speed", "30"}).exit, 2);
  const std::string big = folder.file("b.sinew", "joint base=10deg\n");
  const Ended whole = sinew(
      {"run", big, "--robot", "bigrobotarm", "--speed", "50%", "--time-scale", "20", "--json"});
  ASSERT_EQ(whole.exit, 0) << whole.err;
  EXPECT_EQ(whole.json()["speed"]["through"], "plan");
  const Ended boards =
      sinew({"run", folder.file("c.sinew", "home\n"), "--robot", "robot-arm-2", "--speed", "50%"});
  EXPECT_EQ(boards.exit, 2);
  EXPECT_NE(boards.err.find("one speed of its own"), std::string::npos) << boards.err;
}

}  // namespace
}  // namespace sinew::test
