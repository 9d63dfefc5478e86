#include "sinew/program/language/program_file.h"

#include <gtest/gtest.h>

#include <array>
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
      "gripper on\n"
      "suction release\n"
      "nozzle -45deg time=1.5s",
      "p", test::robot("learm"));
  ASSERT_TRUE(program) << to_text(program.error().front());
  ASSERT_EQ(program->steps.size(), 11U);
  const auto& joint = std::get<JointStep>(program->steps[1].what);
  EXPECT_EQ(program->steps[1].line, 3);
  EXPECT_EQ(joint.given, 0b11);
  EXPECT_DOUBLE_EQ(joint.q[0], from_deg(30));
  EXPECT_DOUBLE_EQ(joint.q[1], -0.5);
  EXPECT_DOUBLE_EQ(joint.how.joint_share, 0.5);
  const auto& loop = std::get<LoopStep>(program->steps[2].what);
  EXPECT_EQ(loop.rounds, 3);
  EXPECT_EQ(loop.end, 5U);
  EXPECT_EQ(std::get<EndStep>(program->steps[5].what).loop, 2U);
  const auto& on = std::get<GripperTo>(std::get<ToolStep>(program->steps[8].what).action);
  EXPECT_TRUE(on.enabled);
  EXPECT_FALSE(on.angle);
  const auto& nozzle = std::get<NozzleTo>(std::get<ToolStep>(program->steps[10].what).action);
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
       "p.sinew:2:3: unknown step 'fly'; steps are joint move line arc spline home jaws gripper "
       "suction nozzle wait loop if else end call velocity acceleration look pick place "
       "repeat"},
      {"joint", "p.sinew:1:1: a joint is missing; write joint base=10deg"},
      {"joint speed=50%", "p.sinew:1:1: a joint is missing: options alone move nothing"},
      {"joint base=10", "p.sinew:1:7: '10' needs a unit: deg, rad"},
      {"joint base=10mm", "p.sinew:1:7: '10mm' ends in 'mm', which is none of deg, rad"},
      {"joint base", "p.sinew:1:7: 'base': write NAME=VALUE, as in base=10deg"},
      {"joint bse=10deg", "p.sinew:1:7: 'bse' is no joint of this robot; did you mean base?"},
      {"joint J6=10deg",
       "p.sinew:1:7: 'J6' is no joint of this robot; it has base shoulder elbow "
       "wrist roll speed accel blend time"},
      {"joint base=1deg J1=2deg", "p.sinew:1:17: 'J1' is named twice"},
      {"joint base=1deg speed=150%", "p.sinew:1:17: speed is 1% to 100%"},
      {"joint base=nandeg", "p.sinew:1:7: 'nandeg' is not a finite number"},
      {"wait 2h", "p.sinew:1:6: '2h' ends in 'h', which is none of s, ms, min"},
      {"wait -1s", "p.sinew:1:6: a wait is 0 s to one hour"},
      {"wait", "p.sinew:1:1: something is missing; write wait 0.5s"},
      {"home base", "p.sinew:1:6: write how long it takes, as in time=2s"},
      {"loop 0\nend", "p.sinew:1:6: '0': a loop has 1 to 10000 rounds"},
      {"loop 2", "p.sinew:1:1: loop without end: write end behind its last step"},
      {"end", "p.sinew:1:1: end without loop or if"},
      {"suction of", "p.sinew:1:9: 'of': suction is on, release or off"},
      {"nozzle", "p.sinew:1:1: something is missing; write nozzle 45deg time=1s"},
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

TEST(ProgramFile, every_fault_of_a_tool_row_is_told_too) {
  const struct {
    const char* text;
    const char* complaint;
  } kCases[] = {
      {"line",
       "p.sinew:1:1: a target is missing; it has x y z pitch roll rx ry rz to dx dy dz dpitch "
       "droll drx dry drz frame speed accel blend time"},
      {"line speed=10%",
       "p.sinew:1:1: a target is missing; it has x y z pitch roll rx ry rz to dx dy dz dpitch "
       "droll drx dry drz frame speed accel blend time"},
      {"line X=10mm",
       "p.sinew:1:6: 'X' is nothing that this row takes; it has x y z pitch roll rx ry rz to dx "
       "dy dz dpitch droll drx dry drz frame speed accel blend time"},
      {"line x=10", "p.sinew:1:6: '10' needs a unit: mm, cm, m, in"},
      {"line x=1mm x=2mm", "p.sinew:1:12: 'x' is named twice"},
      {"line x=200m", "p.sinew:1:6: 'x' is farther away than 100 m"},
      {"line rx=10deg",
       "p.sinew:1:1: rx, ry and rz belong together: an orientation needs all three"},
      {"line rx=1000deg ry=0deg rz=0deg", "p.sinew:1:6: 'rx' is two turns at most"},
      {"line x=1mm rx=1deg rx=1deg", "p.sinew:1:20: 'rx' is named twice"},
      {"line x=1mm speed=80", "p.sinew:1:12: '80' needs a unit: %"},
      {"line x=1mm speed=0mm/s", "p.sinew:1:12: a tool's speed is 0.001 mm/s to 100 m/s"},
      {"line x=1mm speed=1e-6mm/s", "p.sinew:1:12: a tool's speed is 0.001 mm/s to 100 m/s"},
      {"line x=1mm speed=1mm/s speed=2mm/s", "p.sinew:1:24: 'speed' of the tool is named twice"},
      {"line x=1mm speed=1% speed=2%", "p.sinew:1:21: 'speed' of the joints is named twice"},
      {"line x=1mm accel=1mm/s",
       "p.sinew:1:12: '1mm/s' ends in 'mm/s', which is none of mm/s2, m/s2"},
      {"line x=1mm accel=-1mm/s2", "p.sinew:1:12: accel is 0.001 mm/s2 to 100 m/s2"},
      {"line x=1mm blend=0mm", "p.sinew:1:12: blend is above 0 and at most 1 m of the tool"},
      {"line x=1mm blend=500deg",
       "p.sinew:1:12: blend is above 0 and at most 60 deg of the joints"},
      {"line x=1mm blend=1mm blend=1mm", "p.sinew:1:22: 'blend' is named twice"},
      {"line x=1mm ptch=3deg",
       "p.sinew:1:12: 'ptch' is nothing that this row takes; did you mean pitch?"},
      {"arc x=1mm", "p.sinew:1:1: an arc needs a point on its way; write via=200mm,0mm,180mm"},
      {"arc via=1mm,2mm x=1mm", "p.sinew:1:5: '1mm,2mm': a point is X,Y,Z, as in 200mm,0mm,150mm"},
      {"arc via=1mm,2mm,3 x=1mm", "p.sinew:1:5: '3' needs a unit: mm, cm, m, in"},
      {"arc via=1mm,2mm,3mm via=1mm,2mm,3mm x=1mm", "p.sinew:1:21: 'via' is named twice"},
      {"line via=1mm,2mm,3mm",
       "p.sinew:1:6: 'via' is nothing that this row takes; it has x y z pitch roll rx ry rz to dx "
       "dy dz dpitch droll drx dry drz frame speed accel blend time"},
      {"spline", "p.sinew:1:1: a spline has 1 to 256 points, as in 200mm,0mm,150mm"},
      {"spline 1mm,2mm,3mm x=1mm",
       "p.sinew:1:20: 'x' is nothing that this row takes; it has speed accel blend time"},
  };
  for (const auto& c : kCases) {
    EXPECT_EQ(complaints(c.text), std::vector<std::string>{c.complaint}) << c.text;
  }
}

TEST(ProgramFile, rows_of_the_tool_are_read) {
  const auto program = parse(
      "move x=200mm z=1in speed=50% blend=3deg\n"
      "line y=-5cm rx=180deg ry=0deg rz=90deg speed=80mm/s speed=20% accel=1m/s2 blend=20mm\n"
      "arc via=200mm,0mm,180mm y=50mm\n"
      "spline 1mm,2mm,3mm 4mm,5mm,6mm speed=1in/s\n",
      "p", test::robot("puma560"));
  ASSERT_TRUE(program) << to_text(program.error().front());
  ASSERT_EQ(program->steps.size(), 4U);
  const auto& move = std::get<ToolMoveStep>(program->steps[0].what);
  EXPECT_EQ(move.way, ToolMoveStep::Way::kJoints);
  EXPECT_EQ(move.to.p_BT, (std::array<std::optional<double>, 3>{0.2, std::nullopt, 0.0254}));
  EXPECT_EQ(move.how.joint_share, 0.5);
  EXPECT_DOUBLE_EQ(move.how.blend_joints, from_deg(3));
  EXPECT_EQ(move.how.blend_radius, 0);
  EXPECT_FALSE(move.to.R_BT);
  const auto& line = std::get<ToolMoveStep>(program->steps[1].what);
  EXPECT_EQ(line.way, ToolMoveStep::Way::kLine);
  ASSERT_TRUE(line.to.R_BT);
  EXPECT_LT(angle_between(*line.to.R_BT, rotation_from_fixed_xyz({kPi, 0, kPi / 2})), 1e-9);
  EXPECT_DOUBLE_EQ(line.how.tool_speed, 0.08);
  EXPECT_DOUBLE_EQ(line.how.joint_share, 0.2);
  EXPECT_DOUBLE_EQ(line.how.tool_acceleration, 1);
  EXPECT_DOUBLE_EQ(line.how.blend_radius, 0.02);
  EXPECT_TRUE(motion_of(program->steps[1])->blends());
  const auto& arc = std::get<ToolMoveStep>(program->steps[2].what);
  EXPECT_EQ(arc.way, ToolMoveStep::Way::kArc);
  EXPECT_NEAR(arc.p_via_BT.z, 0.18, 1e-12);
  EXPECT_FALSE(motion_of(program->steps[2])->blends());
  const auto& spline = std::get<SplineStep>(program->steps[3].what);
  ASSERT_EQ(spline.through->size(), 2U);
  EXPECT_NEAR((*spline.through)[1].y, 0.005, 1e-12);
  EXPECT_DOUBLE_EQ(spline.how.tool_speed, 0.0254);
}

TEST(ProgramFile, arms_with_five_joints_take_pitch_and_roll) {
  const auto five = parse("line pitch=90deg roll=-10deg", "p", test::robot("learm"));
  const auto& to = std::get<ToolMoveStep>(five->steps[0].what).to;
  EXPECT_DOUBLE_EQ(*to.pitch, kPi / 2);
  EXPECT_DOUBLE_EQ(*to.roll, from_deg(-10));
  EXPECT_FALSE(parse("line pitch=90deg", "p", test::robot("puma560")));
  EXPECT_EQ(complaints("line rx=1deg", "maxarm"),
            std::vector<std::string>{"p.sinew:1:6: 'rx' is nothing that this row takes; it has x y "
                                     "z to dx dy dz frame speed accel blend time"});
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
