#include "sinew/program/program_file.h"

#include <gtest/gtest.h>

#include <iostream>

#include "sinew/core/units.h"
#include "support/property.h"
#include "support/robots.h"

namespace sinew::program {
namespace {

std::vector<std::string> complaints(std::string_view text, std::string_view robot = "learm") {
  const auto program = parse(text, "p.sinew", test::robot(robot));
  std::vector<std::string> lines;
  if (program) return lines;
  for (const Complaint& complaint : program.error()) lines.push_back(to_text(complaint));
  return lines;
}

TEST(ProgramFile, every_row_is_read) {
  const auto program = parse(
      "\xEF\xBB\xBF# a program\r\n"
      "home\r\n"
      "joint base=30deg J2=-0.5rad speed=50%  # two joints\r\n"
      "loop 3\n"
      "  jaws 20mm\n"
      "  wait 200ms\n"
      "end\n"
      "gripper 40deg\n"
      "gripper off\n"
      "suction release\n"
      "nozzle -45deg time=1.5s",
      "p", test::robot("learm"));
  ASSERT_TRUE(program) << to_text(program.error().front());
  ASSERT_EQ(program->steps.size(), 10U);
  const auto& joint = std::get<JointStep>(program->steps[1].what);
  EXPECT_EQ(program->steps[1].line, 3);
  EXPECT_EQ(joint.given, 0b11);
  EXPECT_DOUBLE_EQ(joint.q[0], from_deg(30));
  EXPECT_DOUBLE_EQ(joint.q[1], -0.5);
  EXPECT_DOUBLE_EQ(joint.speed, 0.5);
  const auto& loop = std::get<LoopStep>(program->steps[2].what);
  EXPECT_EQ(loop.rounds, 3);
  EXPECT_EQ(loop.end, 5U);
  EXPECT_EQ(std::get<EndStep>(program->steps[5].what).loop, 2U);
  const auto& nozzle = std::get<NozzleTo>(std::get<ToolStep>(program->steps[9].what).action);
  EXPECT_DOUBLE_EQ(nozzle.angle, from_deg(-45));
  EXPECT_EQ(nozzle.duration, std::chrono::milliseconds(1500));
}

TEST(ProgramFile, every_fault_is_told_at_its_place_with_its_remedy) {
  const struct {
    const char* text;
    const char* complaint;
  } kCases[] = {
      {"jont base=1deg", "p.sinew:1:1: unknown step 'jont'; did you mean joint?"},
      {"\n  fly",
       "p.sinew:2:3: unknown step 'fly'; steps are joint home jaws gripper suction "
       "nozzle wait loop end"},
      {"joint", "p.sinew:1:1: a joint is missing; write joint base=10deg"},
      {"joint speed=50%", "p.sinew:1:1: a joint is missing: speed alone moves nothing"},
      {"joint base=10", "p.sinew:1:7: '10' needs a unit: deg, rad"},
      {"joint base=10mm", "p.sinew:1:7: '10mm' ends in 'mm', which is none of deg, rad"},
      {"joint base", "p.sinew:1:7: 'base': write NAME=VALUE, as in base=10deg"},
      {"joint bse=10deg", "p.sinew:1:7: 'bse' is no joint of this robot; did you mean base?"},
      {"joint J6=10deg",
       "p.sinew:1:7: 'J6' is no joint of this robot; it has base shoulder elbow "
       "wrist roll speed"},
      {"joint base=1deg J1=2deg", "p.sinew:1:17: 'J1' is named twice"},
      {"joint base=1deg speed=150%", "p.sinew:1:17: speed is 1% to 100%, once"},
      {"joint base=nandeg", "p.sinew:1:7: 'nandeg' is not a finite number"},
      {"wait 2h", "p.sinew:1:6: '2h' ends in 'h', which is none of s, ms, min"},
      {"wait -1s", "p.sinew:1:6: a wait is 0 s to one hour"},
      {"wait", "p.sinew:1:1: something is missing; write wait 0.5s"},
      {"home base", "p.sinew:1:6: too many words; write home, which homes all joints"},
      {"loop 0\nend", "p.sinew:1:6: '0': a loop has 1 to 10000 rounds"},
      {"loop 2", "p.sinew:1:1: loop without end: write end behind its last step"},
      {"end", "p.sinew:1:1: end without loop"},
      {"suction of", "p.sinew:1:9: 'of': suction is on, release or off"},
      {"nozzle 10deg 1s", "p.sinew:1:14: write how long it takes, as in time=1s"},
      {"nozzle 10deg time=0s", "p.sinew:1:14: time is above 0 and at most 60 s"},
  };
  for (const auto& c : kCases) {
    EXPECT_EQ(complaints(c.text), std::vector<std::string>{c.complaint}) << c.text;
  }
  EXPECT_EQ(complaints("joint leg1=20deg", "hexapod"),
            std::vector<std::string>{
                "p.sinew:1:7: '20deg' ends in 'deg', which is none of mm, cm, m, in"});
}

TEST(ProgramFile, all_faults_come_at_once_and_never_too_many) {
  EXPECT_EQ(complaints("fly\nwait\nend").size(), 3U);
  std::string text;
  for (int i = 0; i < 1000; ++i) text += "fly\n";
  EXPECT_EQ(complaints(text).size(), 100U);
  std::string nested;
  for (int i = 0; i < 20; ++i) nested += "loop 2\n";
  EXPECT_FALSE(complaints(nested).empty());
}

TEST(ProgramFile, any_bytes_are_read_or_refused_with_a_place) {
  constexpr std::string_view kWords[] = {
      "joint", "base=", "10deg", "J2=",  "-1rad",    "loop", "3",    "end",  "wait", "0.5s",
      "\n",    " ",     "#",     "\r\n", "speed=5%", "home", "\xff", "jaws", "20mm", "suction on"};
  constexpr std::string_view kRows[] = {"joint base=10deg", "loop 3", "end", "wait 0.5s",
                                        "jaws 20mm",        "",       "end", "# why"};
  int accepted = 0;
  int loops = 0;
  test::for_random_cases(20'000, [&](test::Random& random) {
    std::string text;
    const double noise = random.chance(0.5) ? 0.05 : 1;
    for (auto i = random.integer(0, 20); i > 0; --i) {
      if (random.chance(noise)) {
        text += kWords[random.integer(0, std::ssize(kWords) - 1)];
        if (random.chance(0.5)) text += ' ';
      } else {
        text += kRows[random.integer(0, std::ssize(kRows) - 1)];
      }
      if (noise < 1 || random.chance(0.2)) text += '\n';
    }
    const auto program = parse(text, "p", test::robot("learm"));
    if (program) {
      ++accepted;
      for (std::size_t i = 0; i < program->steps.size(); ++i) {
        const auto* loop = std::get_if<LoopStep>(&program->steps[i].what);
        if (loop == nullptr) continue;
        ++loops;
        ASSERT_GT(loop->end, i);
        ASSERT_EQ(std::get<EndStep>(program->steps[loop->end].what).loop, i);
      }
      return;
    }
    for (const Complaint& complaint : program.error()) {
      ASSERT_GE(complaint.line, 1);
      ASSERT_FALSE(complaint.message.empty());
    }
  });
  std::cout << "  " << accepted << " programs were read, with " << loops << " loops\n";
  EXPECT_GT(accepted, 500);
  EXPECT_LT(accepted, 15'000);
  EXPECT_GT(loops, 100);
}

}  // namespace
}  // namespace sinew::program
