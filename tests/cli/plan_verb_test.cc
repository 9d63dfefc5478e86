#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>

#include "cli/process.h"
#include "support/scratch_folder.h"

namespace sinew::test {
namespace {

const Arguments kLine{"plan",  "robot-arm-2", "--json", "--from-joints", "0,-30,-30,0,30,0",
                      "--to",  "400,150,300", "--to",   "400,-150,300",  "--speed",
                      "80mm/s"};

Arguments with(Arguments words, const Arguments& more) {
  words.insert(words.end(), more.begin(), more.end());
  return words;
}

TEST(PlanVerb, tool_goes_straight_from_point_to_point_inside_all_limits) {
  const Ended ended = sinew(with(kLine, {"--wire", "link"}));
  ASSERT_EQ(ended.exit, 0) << ended.err;
  const Json plan = ended.json();
  ASSERT_EQ(plan["stretches"].size(), 2U);
  bool turned = false;
  for (const Json& sample : plan["samples"]) {
    const double x = sample["tool_mm"][0];
    const double y = sample["tool_mm"][1];
    const double z = sample["tool_mm"][2];
    turned = turned || std::hypot(x - 400, y - 150, z - 300) < 0.01;
    if (turned) {
      EXPECT_NEAR(x, 400, 0.01) << sample;
      EXPECT_NEAR(z, 300, 0.01) << sample;
    }
    for (int j = 0; j < 6; ++j) {
      EXPECT_LE(std::abs(sample["velocity_deg_s"][j].get<double>()), 29.5 + 1e-6);
      EXPECT_LE(std::abs(sample["acceleration_deg_s2"][j].get<double>()), 10 + 1e-6);
      EXPECT_LE(std::abs(sample["jerk_deg_s3"][j].get<double>()), 10 + 1e-6);
    }
  }
  EXPECT_TRUE(turned);
  EXPECT_NEAR(plan["samples"].back()["tool_mm"][1], -150, 1e-3);
  EXPECT_NEAR(plan["samples"].back()["t_s"], plan["duration_s"], 1e-9);
}

TEST(PlanVerb, wide_blend_saves_the_stop_in_the_corner) {
  const Arguments words{"plan", "puma560", "--json", "--to", "400,150,100", "--to", "400,-150,100"};
  const Ended stopped = sinew(words);
  const Ended blended = sinew(with(words, {"--blend", "60mm"}));
  ASSERT_EQ(blended.exit, 0) << blended.err;
  EXPECT_EQ(blended.json()["stretches"].size(), 1U);
  EXPECT_LT(blended.json()["duration_s"], stopped.json()["duration_s"]);
}

TEST(PlanVerb, program_is_planned_row_by_row_and_nothing_moves) {
  const ScratchFolder folder;
  const std::string file = folder.file("p.sinew",
                                       "joint J1=0deg J2=20deg J3=-30deg J5=30deg\n"
                                       "wait 0.5s\n"
                                       "loop 2\n"
                                       "line y=40mm z=600mm\n"
                                       "line y=-40mm blend=5mm\n"
                                       "line z=620mm speed=20mm/s\n"
                                       "end\n");
  const Ended ended = sinew({"plan", file, "--robot", "robot-arm-2", "--json"});
  ASSERT_EQ(ended.exit, 0) << ended.err;
  const Json plan = ended.json();
  // Its first line begins elsewhere in the second round; the boards stop behind each row.
  ASSERT_EQ(plan["stretches"].size(), 5U);
  EXPECT_EQ(plan["stretches"][2]["first_line"], 5);
  EXPECT_EQ(plan["stretches"][2]["last_line"], 5);
  EXPECT_EQ(plan["stretches"][2]["times"], 2);
  const Json& last = plan["samples"].back();
  // These boards are told whole degrees, and that is where they go.
  EXPECT_NEAR(last["tool_mm"][1], -40, 5);
  EXPECT_NEAR(last["tool_mm"][2], 620, 5);
  for (const Json& angle : last["joints_deg"]) {
    EXPECT_NEAR(angle.get<double>(), std::round(angle.get<double>()), 1e-9);
  }
  EXPECT_NEAR(last["t_s"], plan["on_wire_s"], 1e-9);
  // The elbow alone moves far here; sinew torque --program tells the same.
  EXPECT_EQ(plan["heaviest_load"]["joint"], "elbow");
  EXPECT_GT(plan["heaviest_load"]["share_of_available"], 0.1);
  EXPECT_LT(plan["heaviest_load"]["share_of_available"], 0.5);
  // Register boards take whole moves, so a way takes them longer.
  EXPECT_GT(plan["stretches"][1]["on_wire_s"], plan["stretches"][1]["duration_s"]);
}

TEST(PlanVerb, program_that_hits_its_own_arm_is_refused_with_line_and_links) {
  const ScratchFolder folder;
  const std::string file = folder.file("p.sinew", "joint J3=-30deg\njoint J3=-100deg\n");
  for (const Arguments& words : {Arguments{"plan", file, "--robot", "robot-arm-2"},
                                 Arguments{"run", file, "--robot", "robot-arm-2"}}) {
    const Ended ended = sinew(words);
    EXPECT_EQ(ended.exit, 1) << ended.out;
    EXPECT_NE(ended.err.find("p.sinew:2, at "), std::string::npos) << ended.err;
    EXPECT_NE(ended.err.find("shoulder and forearm_roll would come within"), std::string::npos)
        << ended.err;
  }
}

TEST(PlanVerb, picture_has_a_box_for_each_joint_and_quantity) {
  const ScratchFolder folder;
  const std::string file = folder.at("plan.svg");
  const Ended ended = sinew(with(kLine, {"--plot", file}));
  ASSERT_EQ(ended.exit, 0) << ended.err;
  const std::string svg = text_of(file);
  std::size_t boxes = 0;
  for (std::size_t at = 0; (at = svg.find("acceleration, deg/s", at)) != std::string::npos; ++at) {
    ++boxes;
  }
  EXPECT_EQ(boxes, 6U);
  EXPECT_NE(svg.find("from above"), std::string::npos);
}

TEST(PlanVerb, picture_of_a_platform_shows_its_legs_at_both_ends) {
  const ScratchFolder folder;
  const std::string file = folder.at("plan.svg");
  const Ended ended = sinew({"plan", "hexapod", "--to", "10,0,225", "--plot", file});
  ASSERT_EQ(ended.exit, 0) << ended.err;
  const std::string svg = text_of(file);
  EXPECT_NE(svg.find("oblique: x across, z up, y into the page"), std::string::npos);
  std::size_t rings = 0;
  for (std::size_t at = 0; (at = svg.find("<polygon ", at)) != std::string::npos; ++at) ++rings;
  EXPECT_EQ(rings, 3U) << "the base, the platform where it starts, and where it ends";
}

TEST(PlanVerb, what_cannot_be_gone_is_refused_with_move_and_place) {
  const struct {
    Arguments words;
    const char* says;
  } kCases[] = {
      {{"plan", "robot-arm-2", "--to", "900,0,300"}, "move 1, at "},
      {{"plan", "robot-arm-2", "--to", "joints=0,95,0,0,0,0"}, "shoulder"},
      {{"plan", "robot-arm-2", "--to", "joints=0,10,-30,0,30,0", "--to", "2000,0,300"}, "move 2"},
      {{"plan", "maxarm", "--to", "0,-900,100"}, "move 1"},
  };
  for (const auto& c : kCases) {
    const Ended ended = sinew(c.words);
    EXPECT_EQ(ended.exit, 1) << c.words[3] << ended.out;
    EXPECT_NE(ended.err.find(c.says), std::string::npos) << c.words[3] << ": " << ended.err;
  }
}

TEST(PlanVerb, start_outside_the_limits_comes_in_by_joints_and_a_line_says_so) {
  const Arguments from{"plan", "robot-arm-2", "--from-joints", "171,10,-40,0,30,0"};
  const Ended in = sinew(with(from, {"--to", "joints=150,10,-40,0,30,0"}));
  EXPECT_EQ(in.exit, 0) << in.err;
  const Ended line = sinew(with(from, {"--to", "300,0,300"}));
  EXPECT_EQ(line.exit, 1);
  EXPECT_NE(line.err.find("only joints lead back in"), std::string::npos) << line.err;
  EXPECT_NE(line.err.find("would work: first back inside its limits: --to joints=169.999,10"),
            std::string::npos)
      << line.err;
}

TEST(PlanVerb, samples_of_a_device_that_takes_whole_moves_stop_as_often_as_it_does) {
  const Ended ended = sinew({"plan", "maxarm", "--to", "0,-200,100", "--json"});
  ASSERT_EQ(ended.exit, 0) << ended.err;
  const Json plan = ended.json();
  std::size_t stops = 0;
  bool stood = true;
  for (const Json& sample : plan["samples"]) {
    bool stands = true;
    for (const Json& qd : sample["velocity_deg_s"]) stands = stands && qd.get<double>() == 0;
    stops += stands && !stood ? 1 : 0;
    stood = stands;
  }
  EXPECT_GT(stops, 2U);
  EXPECT_EQ(stops, plan["stretches"][0]["pieces"].get<std::size_t>());
  EXPECT_NEAR(plan["samples"].back()["t_s"], plan["on_wire_s"], 1e-9);
}

TEST(PlanVerb, what_takes_hours_of_pieces_is_refused_in_a_moment) {
  const Ended ended = sinew({"plan", "learm", "--from-joints", "0,20,30,40,0", "--to", "226,0,218",
                             "--speed", "0.001mm/s"});
  EXPECT_EQ(ended.exit, 1);
  EXPECT_NE(ended.err.find("limit 8e+03 s: faster, or in several rows"), std::string::npos)
      << ended.err;
}

TEST(PlanVerb, turns_are_not_counted_in_millimetres_and_contacts_say_how_deep) {
  const Ended turn = sinew({"plan", "learm", "--to", "joints=0,0,0,0,95"});
  EXPECT_NE(turn.err.find("move 1, at 94.7 %: "), std::string::npos) << turn.err;
  const Ended hit = sinew({"plan", "robot-arm-2", "--to", "joints=0,-60,-110,0,0,0"});
  EXPECT_NE(hit.err.find("; on the rest of the way they would overlap by "), std::string::npos);
  EXPECT_NE(hit.err.find(" mm, its target is "), std::string::npos) << hit.err;
  EXPECT_NE(hit.err.find("would work: as far as the joints can go: --to joints="),
            std::string::npos)
      << hit.err;
}

TEST(PlanVerb, bad_input_is_told_in_a_sentence) {
  const struct {
    Arguments more;
    const char* says;
  } kCases[] = {
      {{}, "--to"},
      {{"--to", "1,2"}, "--to: "},
      {{"--to", "a,b,c"}, "--to: "},
      {{"--to", "nan,0,0"}, "--to: "},
      {{"--to", "joints=1,2"}, "--to: "},
      {{"--to", "300,0,300", "--speed", "-1mm/s"}, "--speed: "},
      {{"--to", "300,0,300", "--speed", "0"}, "--speed: "},
      {{"--to", "300,0,300", "--speed", "80mm"}, "--speed: "},
      {{"--to", "300,0,300", "--blend", "3deg"}, "--blend: "},
      {{"--to", "300,0,300", "--from-joints", "1"}, "--from-joints: "},
      {{"--to", "300,0,300", "--plot", "/nowhere/p.svg"}, "--plot: "},
      {{"--to", "300,0,300", "--robot", "learm"}, "--robot: "},
  };
  for (const auto& c : kCases) {
    const Ended ended = sinew(with({"plan", "robot-arm-2"}, c.more));
    EXPECT_EQ(ended.exit, 2) << ended.out << ended.err;
    EXPECT_NE(ended.err.find(c.says), std::string::npos) << ended.err;
  }
}

TEST(PlanVerb, program_needs_its_robot_and_no_moves_beside_it) {
  const ScratchFolder folder;
  const std::string good = folder.file("p.sinew", "line z=600mm\n");
  const std::string bad = folder.file("q.sinew", "line z=600\n");
  const struct {
    Arguments words;
    const char* says;
  } kCases[] = {
      {{"plan", good}, "--robot is missing"},
      {{"plan", good, "--robot", "robot-arm-2", "--to", "1,2,3"}, "--to, --speed, --blend: "},
      {{"plan", folder.at("none.sinew"), "--robot", "robot-arm-2"}, "none.sinew"},
      {{"plan", bad, "--robot", "robot-arm-2"}, "q.sinew:1:6: '600' needs a unit"},
  };
  for (const auto& c : kCases) {
    const Ended ended = sinew(c.words);
    EXPECT_EQ(ended.exit, 2) << ended.out << ended.err;
    EXPECT_NE(ended.err.find(c.says), std::string::npos) << ended.err;
  }
}

TEST(PlanVerb, home_is_a_row_with_its_bound_and_the_way_home_behind_it) {
  const Arguments words{"plan", SINEW_SOURCE_DIR "/robots/robot-arm-2/first_moves.sinew", "--robot",
                        "robot-arm-2"};
  const Ended text = sinew(words);
  ASSERT_EQ(text.exit, 0) << text.err;
  EXPECT_NE(text.out.find("2 home "), std::string::npos) << text.out;
  EXPECT_NE(text.out.find("at most 17 min"), std::string::npos) << text.out;
  EXPECT_NE(text.out.find("shoulder and forearm_roll overlap by"), std::string::npos) << text.out;
  const Json plan = sinew(with(words, {"--json"})).json();
  EXPECT_EQ(plan["stretches"][0]["what"], "home");
  EXPECT_GT(plan["stretches"][0]["at_most_s"], 900);
  EXPECT_EQ(plan["homing_at_most_s"], plan["stretches"][0]["at_most_s"]);
  double sum = 0;
  for (const Json& row : plan["stretches"]) {
    if (row.contains("on_wire_s")) sum += row["on_wire_s"].get<double>();
  }
  EXPECT_NEAR(plan["on_wire_s"], sum, 1e-9) << "the main figure is what the device takes";
  EXPECT_EQ(plan["stretches"][1]["what"], "to home");
}

TEST(PlanVerb, loops_list_a_row_once_and_count_it) {
  const ScratchFolder folder;
  const std::string file = folder.file("p.sinew",
                                       "joint J1=0deg J2=20deg J3=-30deg J5=30deg\n"
                                       "loop 500\nline y=40mm\nline y=0mm\nend\n");
  const Ended ended = sinew({"plan", file, "--robot", "robot-arm-2"});
  ASSERT_EQ(ended.exit, 0) << ended.err;
  EXPECT_NE(ended.out.find("4 x 500"), std::string::npos) << ended.out;
  EXPECT_NE(ended.out.find("  line 4: "), std::string::npos) << ended.out;
}

TEST(PlanVerb, what_the_device_is_not_told_is_noted) {
  const ScratchFolder folder;
  const struct {
    const char* robot;
    const char* rows;
    const char* says;
  } kCases[] = {
      {"maxarm", "joint base=110deg blend=5deg\njoint shoulder=100deg\n", "stops at each corner"},
      {"maxarm", "joint base=110deg accel=5mm/s2\n", "accel= is not heard"},
      {"robot-arm-2", "joint J1=10deg speed=10%\n", "speed= and time= is not heard"},
  };
  for (const auto& c : kCases) {
    const Ended ended = sinew({"plan", folder.file("p.sinew", c.rows), "--robot", c.robot});
    ASSERT_EQ(ended.exit, 0) << ended.err;
    EXPECT_NE(ended.out.find(c.says), std::string::npos) << ended.out;
  }
}

TEST(PlanVerb, arm_that_does_not_know_where_it_stands_is_counted_with_its_slow_first_move) {
  const std::string file = SINEW_SOURCE_DIR "/robots/learm/wave.sinew";
  const Arguments words{"plan", file, "--robot", "learm", "--json"};
  const Json unknown = sinew(words).json();
  ASSERT_EQ(unknown["notes"].size(), 1U);
  EXPECT_NE(unknown["notes"][0].get<std::string>().find("line 2 takes 10 s"), std::string::npos);
  const Json known = sinew(with(words, {"--from-joints", "0,0,0,0,0"})).json();
  EXPECT_TRUE(known["notes"].empty());
  EXPECT_GT(unknown["on_wire_s"].get<double>(), known["on_wire_s"].get<double>() + 9);
}

/// Each offer can be typed and works; what was just refused is none.
TEST(PlanVerb, what_would_work_works_as_it_is_printed) {
  const Arguments kCases[] = {
      {"plan", "robot-arm-2", "--from-joints", "0,-30,-30,0,30,0", "--to", "700,0,300"},
      {"plan", "bigrobotarm", "--from-joints", "0,20,60,0,40", "--to", "350,50,150,0,180,0"},
      {"plan", "learm", "--to", "150,50,100,0,170,0"},
      {"plan", "learm", "--to", "150,0,100,0,150,5"},
  };
  int tried = 0;
  for (const Arguments& words : kCases) {
    const Ended refused = sinew(with(words, {"--json"}));
    ASSERT_EQ(refused.exit, 1);
    const Json answer = refused.json();
    for (const Json& way : answer["refusal"]["would_work"]) {
      const std::string text = way;
      const std::size_t at = text.find("--to ");
      ASSERT_NE(at, std::string::npos) << text;
      if (text.starts_with("the same way")) continue;
      Arguments again(words.begin(), words.end() - 1);
      again.push_back(text.substr(at + 5));
      const Ended ended = sinew(again);
      EXPECT_EQ(ended.exit, 0) << text << ended.err;
      ++tried;
    }
  }
  EXPECT_GE(tried, 1);
  const Ended far = sinew(kCases[0]);
  EXPECT_NE(far.err.find("its target: out of reach by 36."), std::string::npos) << far.err;
  EXPECT_NE(far.err.find("mm of the line: --to "), std::string::npos) << far.err;
}

TEST(PlanVerb, ideal_device_has_its_time_on_the_wire_too) {
  const Ended ended = sinew({"plan", "puma560", "--to", "400,150,100"});
  ASSERT_EQ(ended.exit, 0) << ended.err;
  EXPECT_EQ(ended.out.find("nan"), std::string::npos) << ended.out;
  EXPECT_NE(ended.out.find("on the wire"), std::string::npos) << ended.out;
}

/// Found by an audit: run drove row 1, and then the wire could not say row 2.
TEST(PlanVerb, target_that_the_wire_cannot_say_is_refused_by_plan_and_run_before_anything_moves) {
  const ScratchFolder folder;
  const struct {
    const char* robot;
    const char* rows;
    const char* says;
  } kCases[] = {
      {"bigrobotarm", "joint J1=20deg\njoint J1=48deg\n", "(base at 48 deg)"},
      {"maxarm", "joint J1=110deg\njoint J1=0deg\n", "(base at 0 deg)"},
  };
  for (const auto& c : kCases) {
    const std::string file = folder.file("p.sinew", c.rows);
    for (const char* verb : {"plan", "run"}) {
      const Ended ended = sinew({verb, file, "--robot", c.robot});
      EXPECT_EQ(ended.exit, 1) << verb << ended.out;
      for (const char* part : {"p.sinew:2", c.says, "nothing was moved", "can be sent: joint "}) {
        EXPECT_NE(ended.err.find(part), std::string::npos) << verb << part << ended.err;
      }
    }
  }
}

TEST(PlanVerb, boards_that_were_just_switched_on_are_noted_to_need_home_first) {
  const std::string square = SINEW_SOURCE_DIR "/robots/robot-arm-2/square.sinew";
  const Arguments words{"plan", square, "--robot", "robot-arm-2", "--json"};
  const Json unknown = sinew(words).json();
  std::string notes = unknown["notes"].dump();
  EXPECT_NE(notes.find("does not know where it stands refuses line 3"), std::string::npos) << notes;
  const Json known = sinew(with(words, {"--from-joints", "0,-30,-30,0,30,0"})).json();
  EXPECT_EQ(known["notes"].dump().find("where it stands"), std::string::npos) << known["notes"];
  const ScratchFolder folder;
  const std::string homed = folder.file("p.sinew", "home\njoint J1=10deg\n");
  const Ended ended = sinew({"plan", homed, "--robot", "robot-arm-2"});
  EXPECT_EQ(ended.exit, 0) << ended.err;
  EXPECT_EQ(ended.out.find("where it stands"), std::string::npos) << ended.out;
}

TEST(PlanVerb, time_by_the_limits_leaves_the_wire_out) {
  const Arguments words{"plan", "hexapod", "--to", "0,0,230"};
  const Json hexapod = sinew(with(words, {"--json"})).json();
  EXPECT_LT(hexapod["by_limits_s"].get<double>(), 0.5 * hexapod["on_wire_s"].get<double>());
  EXPECT_EQ(hexapod["stretches"][0]["by_limits_s"], hexapod["by_limits_s"]);
  const Json arm = sinew({"plan", "maxarm", "--to", "joints=110,90,10", "--json"}).json();
  EXPECT_EQ(arm["by_limits_s"], arm["duration_s"]) << "a wire that limits nothing";
}

TEST(PlanVerb, share_of_the_limits_that_a_motion_is_planned_with_is_named) {
  const Ended link =
      sinew({"plan", "robot-arm-2", "--wire", "link", "--to", "joints=10,0,0,0,0,0"});
  EXPECT_NE(link.out.find("planned with 80 % of the limits: the device needs the rest"),
            std::string::npos)
      << link.out << link.err;
  const Ended whole = sinew({"plan", "maxarm", "--to", "joints=110,90,10"});
  EXPECT_EQ(whole.exit, 0) << whole.err;
  EXPECT_EQ(whole.out.find("planned with"), std::string::npos) << whole.out;
}

TEST(PlanVerb, file_that_is_no_program_is_told_what_it_is) {
  const std::string robots = SINEW_SOURCE_DIR "/robots/";
  const struct {
    Arguments words;
    const char* says;
  } kCases[] = {
      {{"plan", robots + "bigrobotarm/sequence.txt"}, "--robot is missing"},
      {{"plan", robots + "learm/wave.md", "--robot", "learm"}, "is none"},
      {{"plan", robots + "learm.toml", "--robot", "learm"}, "is a robot's file itself"},
  };
  for (const auto& c : kCases) {
    const Ended ended = sinew(c.words);
    EXPECT_EQ(ended.exit, 2) << ended.out;
    EXPECT_NE(ended.err.find(c.says), std::string::npos) << ended.err;
  }
}

TEST(PlanVerb, is_made_for_the_wire_that_is_named) {
  const auto planned = [](const std::string& wire) {
    return sinew({"plan", "robot-arm-2", "--wire", wire, "--from-joints", "0,-30,-30,0,30,0",
                  "--to", "400,150,300", "--to", "400,-150,300", "--blend", "40mm", "--json"});
  };
  const Ended whole_moves = planned("registers");
  const Ended stream = planned("link");
  ASSERT_EQ(whole_moves.exit, 0) << whole_moves.err;
  ASSERT_EQ(stream.exit, 0) << stream.err;
  const double slow = whole_moves.json()["on_wire_s"].get<double>();
  const double quick = stream.json()["on_wire_s"].get<double>();
  EXPECT_GT(slow, 2 * quick) << "boards that take whole moves stop between any two of them";
  EXPECT_NEAR(quick, stream.json()["duration_s"].get<double>(), 0.1);
  const Ended unknown = planned("nix");
  EXPECT_EQ(unknown.exit, 2);
  EXPECT_NE(unknown.err.find("--wire: 'nix' is none of registers, link"), std::string::npos);
}

TEST(PlanVerb, sample_programs_of_all_robots_can_be_made) {
  namespace fs = std::filesystem;
  int programs = 0;
  for (const auto& entry : fs::recursive_directory_iterator(SINEW_SOURCE_DIR "/robots")) {
    if (entry.path().extension() != ".sinew") continue;
    const fs::path name = fs::relative(entry.path(), SINEW_SOURCE_DIR "/robots");
    const std::string robot = *name.begin();
    const Ended ended = sinew({"plan", entry.path(), "--robot", robot});
    EXPECT_EQ(ended.exit, 0) << entry.path() << ended.err;
    ++programs;
  }
  EXPECT_GE(programs, 10);
}

}  // namespace
}  // namespace sinew::test
