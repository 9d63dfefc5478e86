#include <gtest/gtest.h>

#include <algorithm>

#include "sinew/core/units.h"
#include "sinew/devices/bigrobotarm/bigrobotarm_format.h"
#include "sinew/devices/bigrobotarm/bigrobotarm_settings.h"
#include "sinew/model/joint_lookup.h"
#include "sinew/program/formats/gcode_file.h"
#include "sinew/program/formats/pose_file.h"
#include "sinew/program/formats/text_forms.h"
#include "sinew/program/plans/program_plan.h"
#include "support/property.h"
#include "support/robots.h"

/// Programs and poses of others: read, written, and never read half.
namespace sinew::program {
namespace {

const HexapodGeometry& geometry() {
  return std::get<HexapodGeometry>(test::robot("hexapod").geometry);
}

kinematics::PoseBP random_pose(test::Random& random) {
  const auto turn = [&] { return random.uniform(-0.4, 0.4); };
  kinematics::PoseBP X = geometry().X_BP_home;
  X.p = X.p +
        Vec3{random.uniform(-0.05, 0.05), random.uniform(-0.05, 0.05), random.uniform(-0.05, 0.05)};
  X.R = rotation_from_fixed_xyz({turn(), turn(), turn()}) * X.R;
  return X;
}

std::string first_complaint(const auto& read) {
  return read ? std::string() : to_text(read.error().front());
}

TEST(PoseFile, pose_comes_back_from_either_decimal_mark_line_end_and_encoding) {
  test::for_random_cases(1'000, [](test::Random& random) {
    const auto X_BP = random_pose(random);
    const auto mark = random.chance(0.5) ? DecimalMark::kPoint : DecimalMark::kComma;
    std::string text = pose_text(pose_file(X_BP, geometry()), mark);
    if (random.chance(0.5)) {
      std::string windows;
      for (const char c : text) windows += c == '\n' ? std::string("\r\n") : std::string(1, c);
      text = windows + "\r\n";
    }
    if (random.chance(0.3)) {
      std::string wide = "\xFF\xFE";
      for (const char c : text) wide += std::string{c, '\0'};
      text = wide;
    } else if (random.chance(0.3)) {
      text.insert(0, "\xEF\xBB\xBF");
    }
    const auto again = read_pose_file(text, "p.pos");
    ASSERT_TRUE(again) << to_text(again.error().front());
    const PlatformFit fit = fit_platform(again->heads, geometry());
    ASSERT_LT(fit.residual, 1e-11);
    ASSERT_NEAR(norm(fit.X_BP.p - X_BP.p), 0, 1e-11);
    ASSERT_NEAR(angle_between(fit.X_BP.R, X_BP.R), 0, 1e-7);
    ASSERT_NEAR(norm(again->translation_total - (X_BP.p - geometry().X_BP_home.p)), 0, 1e-11);
  });
}

TEST(PoseFile, fit_is_the_best_one_and_its_residual_tells_of_another_platform) {
  test::for_random_cases(300, [](test::Random& random) {
    const auto X_BP = random_pose(random);
    auto heads = pose_file(X_BP, geometry()).heads;
    for (Vec3& head : heads) {
      const auto noise = [&] { return random.uniform(-1e-4, 1e-4); };
      head = head + Vec3{noise(), noise(), noise()};
    }
    const auto squares = [&](const kinematics::PoseBP& X) {
      double sum = 0;
      for (std::size_t leg = 0; leg < kLegs; ++leg) {
        const Vec3 off = heads[leg] - X * geometry().p_PA[leg];
        sum += dot(off, off);
      }
      return sum;
    };
    const PlatformFit fit = fit_platform(heads, geometry());
    const double best = squares(fit.X_BP);
    ASSERT_LE(best, squares(X_BP));
    for (int i = 0; i < 20; ++i) {  // no neighbour is better
      const auto step = [&] { return random.uniform(-1e-5, 1e-5); };
      kinematics::PoseBP near = fit.X_BP;
      near.p = near.p + Vec3{step(), step(), step()};
      near.R = rotation_from_vector({10 * step(), 10 * step(), 10 * step()}) * near.R;
      ASSERT_GE(squares(near), best);
    }
  });
  auto heads = pose_file(geometry().X_BP_home, geometry()).heads;
  heads[2].x += 0.01;
  EXPECT_GT(fit_platform(heads, geometry()).residual, kPlatformResidualMax);
}

TEST(PoseFile, every_fault_is_told_at_its_place) {
  const std::string good =
      pose_text(pose_file(geometry().X_BP_home, geometry()), DecimalMark::kPoint);
  const auto with_first = [&](const std::string& first) {
    return first_complaint(read_pose_file(first + good.substr(good.find('\n')), "p.pos"));
  };
  EXPECT_EQ(with_first("1.5e1"), "");
  EXPECT_EQ(with_first("+3"), "");
  EXPECT_EQ(with_first(" nan"), "p.pos:1:2: 'nan' is not a finite number");
  EXPECT_EQ(with_first("1e999"), "p.pos:1:1: '1e999' is not a finite number");
  EXPECT_EQ(with_first("1.234,5"), "p.pos:1:1: '1.234,5': has more than one decimal mark");
  EXPECT_EQ(with_first("12mm"), "p.pos:1:1: '12mm' is not a finite number");
  EXPECT_EQ(with_first("1e8"), "p.pos:1:1: '1e8' is beyond any platform");
  EXPECT_EQ(with_first(""), "p.pos:1:1: '': a number is missing");
  EXPECT_EQ(with_first("+-3"), "p.pos:1:1: '+-3' is not a finite number");
  EXPECT_NE(with_first("1,5").find("the decimal mark was , in line 1; a file has one kind"),
            std::string::npos)
      << with_first("1,5");
  EXPECT_EQ(first_complaint(read_pose_file("1\n2\n", "p.pos")),
            "p.pos:2:1: a .pos file has 24 rows, this one 2");
  EXPECT_EQ(first_complaint(read_pose_file(good + "3\n", "p.pos")),
            "p.pos:25:1: a .pos file has 24 rows, this one 25");
  EXPECT_EQ(first_complaint(read_pose_file("", "p.pos")),
            "p.pos:1:1: a .pos file has 24 rows, this one 0");
}

TEST(PlatformConfig, old_program_says_where_it_stood_and_each_leg_stays_uncertain) {
  const RobotModel& robot = test::robot("hexapod");
  test::Random random(7);
  const auto X_BP = random_pose(random);
  const std::string text =
      "COM3\r\nC:\\Dokumente\\S\xF6hne\r\n" +
      pose_text(pose_file(X_BP, geometry()), DecimalMark::kComma) +
      pose_text(pose_file(geometry().X_BP_home, geometry()), DecimalMark::kComma);
  const auto config = read_platform_config(text, "config.cfg");
  ASSERT_TRUE(config) << to_text(config.error().front());
  EXPECT_EQ(config->port, "COM3");
  const auto legs = uncertain_legs(fit_platform(config->real.heads, geometry()), robot);
  const JointVector wanted = kinematics::Hexapod(geometry()).inverse(X_BP);
  ASSERT_EQ(legs.size(), kLegs);
  for (std::size_t leg = 0; leg < kLegs; ++leg) {
    EXPECT_EQ(legs[leg].quality, PositionQuality::kUncertain);
    EXPECT_NEAR(legs[leg].q, wanted[leg], 1e-10);
    EXPECT_EQ(legs[leg].lower, robot.joints[leg].lower) << "it may stand anywhere";
    EXPECT_EQ(legs[leg].upper, robot.joints[leg].upper);
  }
  EXPECT_EQ(first_complaint(read_platform_config("COM3\n", "c")),
            "c:1:1: a config.cfg has 50 rows, this one 1");
}

std::string rows(std::string_view gcode, std::string_view robot = "maxarm") {
  const auto text = rows_of_gcode(gcode, "p.nc", test::robot(robot));
  return text ? text->text : "refused: " + to_text(text.error().front());
}

TEST(Gcode, words_become_rows) {
  EXPECT_EQ(rows("%\nG21 G90 G94 (made by hand)\n"
                 "N10 G0 X-40 Y-180 Z140 ; above it\n"
                 "g1 z110.5 f2400\nX -30\n"
                 "M3\nG4 P0.5\nG91 G1 Z+20\nG0 X1 M5\nG28\nM2\n%\n"),
            "# made by hand\n"
            "move x=-40mm y=-180mm z=140mm  # above it\n"
            "line z=110.5mm speed=40mm/s\n"
            "line x=-30mm speed=40mm/s\n"
            "suction on\nwait 0.5s\n"
            "line dz=20mm speed=40mm/s\n"
            "suction off\nmove dx=1mm\n"
            "home\n");
  EXPECT_EQ(rows("G20 G1 X2 F60"), "line x=2in speed=1in/s\n");
  EXPECT_EQ(rows("G93 G1 X2 F30\nG0 X1\nG1 X5 F120\nG94 G1 X7 F600\n"),
            "line x=2mm time=2s\nmove x=1mm\nline x=5mm time=0.5s\nline x=7mm speed=10mm/s\n");
  EXPECT_EQ(rows("G93 G1 X2"), "refused: p.nc:1:1: 'G93' needs an F of its own behind G93");
  EXPECT_EQ(rows("M4"), "suction release\n");
  EXPECT_EQ(rows("M3 S20\nM5", "learm"), "jaws 20mm\njaws 60mm\n");
  EXPECT_EQ(rows("M3 S40\nM5", "bigrobotarm"), "gripper 40deg\ngripper off\n");
}

TEST(Gcode, nothing_is_skipped_that_is_not_understood) {
  const struct {
    const char* text;
    const char* complaint;
  } kCases[] = {
      {"X10", "refused: p.nc:1:1: 'X10' moves without a G0 or G1 before it"},
      {"G1 X10", "refused: p.nc:1:1: 'G1' has no speed: a G1 needs an F in or before its line"},
      {"G2 X1 I2 F9",
       "refused: p.nc:1:1: 'G2' is an arc in a plane of the machine; write it as lines, or as a "
       "row "
       "arc via=X,Y,Z x= y= z= of a program"},
      {"G0 A3", "refused: p.nc:1:4: 'A3' is no word that is read here: G M X Y Z F P S N are"},
      {"G54",
       "refused: p.nc:1:1: 'G54' means the zero of a workpiece; here zero is the robot's base"},
      {"G1.5 X3",
       "refused: p.nc:1:1: 'G1.5' is not read here: G0 G1 G4 G20 G21 G28 G90 G91 G93 G94 "
       "are"},
      {"M8", "refused: p.nc:1:1: 'M8' is not read here: M2 M3 M4 M5 M30 are"},
      {"G0 X1 X2", "refused: p.nc:1:7: 'X2' stands twice in one line"},
      {"G0 G1 X1 F3", "refused: p.nc:1:4: 'G1' and another motion stand in one line"},
      {"G4", "refused: p.nc:1:1: 'G4' needs P, the seconds that it waits"},
      {"G4 P-1", "refused: p.nc:1:4: 'P-1' is no wait: 0 to 3600 seconds"},
      {"G0 X1 P3", "refused: p.nc:1:7: 'P3' belongs to a G4"},
      {"G0 X1 S3", "refused: p.nc:1:7: 'S3' belongs to an M3 in its line"},
      {"G28 X1",
       "refused: p.nc:1:1: 'G28' takes no X, Y or Z here: write the motion in a line of its own"},
      {"G0 X#1", "refused: p.nc:1:4: 'X#1': a word is a letter and a number, as in X12.5"},
      {"G0 X1,5", "refused: p.nc:1:6: ',5': a word is a letter and a number, as in X12.5"},
      {"G0 X[1+2]", "refused: p.nc:1:4: 'X[1+2]': a word is a letter and a number, as in X12.5"},
      {"G0 Xnan", "refused: p.nc:1:4: 'Xnan': a word is a letter and a number, as in X12.5"},
      {"G0 X1e9", "refused: p.nc:1:6: 'e9' is no word that is read here: G M X Y Z F P S N are"},
      {"G0 X99999999", "refused: p.nc:1:4: 'X99999999' is beyond any machine"},
      {"G0 (half", "refused: p.nc:1:4: a remark begins with ( and has no )"},
      {"M2\nG0 X1", "refused: p.nc:2:1: 'G0' stands behind the end of the program (M2, M30)"},
      {"F0", "refused: p.nc:1:1: 'F0' is no speed: F is above 0, mm or inches a minute"},
      {"M3 S3", "refused: p.nc:1:4: 'S3' says nothing to a pump that is on or off"},
  };
  for (const auto& c : kCases) EXPECT_EQ(rows(c.text), c.complaint) << c.text;
  EXPECT_EQ(rows("M3", "puma560"),
            "refused: p.nc:1:1: 'M3' has no meaning for the tool of puma560");
  EXPECT_EQ(rows("M3", "learm"), "refused: p.nc:1:1: 'M3' needs S, the width between the jaws, mm");
}

TEST(Gcode, whatever_is_read_is_a_program) {
  int read = 0, programs = 0;
  test::for_random_cases(5'000, [&](test::Random& random) {
    constexpr const char* kWords[] = {"G0 ",    "G1",    "G90",      "G91 ", "G20", "G21", "X10",
                                      "Y-3.5 ", "Z+2",   "F600",     "\n",   "\n",  "M3",  "M5",
                                      "G4 P1",  "(why)", "; so\n",   "N5 ",  "%",   "G28", "G93",
                                      "G94",    "e",     "\xC3\xA4", "M2",   "X"};
    std::string text = "G0 F9\n";
    const double noise = random.chance(0.7) ? 0 : 0.1;
    for (auto words = random.integer(0, 12); words > 0; --words) {
      text += kWords[random.integer(0, noise == 0 ? 21 : std::ssize(kWords) - 1)];
      if (random.chance(0.5)) text += '\n';
      if (random.chance(noise)) text += '\0';
    }
    const auto out = rows_of_gcode(text, "p", test::robot("maxarm"));
    if (!out) {
      ASSERT_FALSE(out.error().empty());
      return;
    }
    ++read;
    const auto program = parse(out->text, "p", test::robot("maxarm"));
    ASSERT_TRUE(program) << to_text(program.error().front()) << "\n"
                         << out->text << "\nof\n"
                         << text;
    programs += program->steps.empty() ? 0 : 1;
  });
  EXPECT_GT(read, 500);
  EXPECT_GT(programs, 300);
}

TEST(SequenceRows, sequence_comes_back_step_by_step) {
  const RobotModel& robot = test::robot("bigrobotarm");
  const auto& device = robot.device.settings.get<BigRobotArmDevice>();
  test::for_random_cases(1'000, [&](test::Random& random) {
    std::string text = "S1\n";
    bool open = false;
    int commands = 0;
    for (auto lines = random.integer(1, 12); lines > 0; --lines) {
      if (!open && random.chance(0.2)) {
        text += "BEGIN I" + std::to_string(random.integer(1, 127)) + "\n";
        open = true;
        commands = 0;
      }
      if (random.chance(0.8)) {
        text += "G0";
        for (const char* letter : {"B", "S", "E", "WR", "W"}) {
          text += std::string(" ") + letter + std::to_string(random.integer(-8000, 8000));
        }
        text += "\n";
      } else {
        text += random.chance(0.5) ? "G1 E0 P0\n"
                                   : "G1 E1 P" + std::to_string(random.integer(0, 180)) + "\n";
      }
      if (open && (++commands == 15 || random.chance(0.3))) {
        text += "END\n";
        open = false;
      }
    }
    if (open) text += "END\n";
    const auto sequence = sequence::parse(text, "s.txt", device);
    ASSERT_TRUE(sequence) << to_text(sequence.error().front()) << text;
    RobotModel on_text = robot;
    on_text.device.settings.get<BigRobotArmDevice>().wire = BigRobotArmWire::kText;
    const Rows out = rows_of_sequence(*sequence, on_text);
    const auto program = parse(out.text, "p", robot);
    ASSERT_TRUE(program) << to_text(program.error().front()) << out.text;
    ASSERT_EQ(out.lines.size(), static_cast<std::size_t>(std::ranges::count(out.text, '\n')));
    const auto again = sequence_of_rows(*program, robot);
    ASSERT_TRUE(again) << to_text(again.error().front()) << out.text;
    ASSERT_EQ(sequence::to_text(*again), sequence::to_text(*sequence));
  });
}

/// The document's own counts: 72.2 steps a degree of the base, 27.8 of the shoulder.
TEST(SequenceRows, zero_is_where_the_last_reset_was) {
  const RobotModel& robot = test::robot("bigrobotarm");
  const auto rows = [&](const char* text) {
    const auto& device = robot.device.settings.get<BigRobotArmDevice>();
    return rows_of_sequence(*sequence::parse(text, "s.txt", device), robot).text;
  };
  EXPECT_EQ(rows("S1\nG0 B6500\nG92\nG0 B-6500\nG28"),
            "joint base=90deg\njoint base=0deg\n"
            "joint base=90deg d.shoulder=0deg d.elbow=0deg d.wrist_rotate=0deg d.wrist=0deg\n");
  // Where it was is not known: differences, and a block's rounds differ.
  EXPECT_EQ(rows("S1\nG92\nBEGIN I2\nG0 B650\nG0 B0\nG92\nEND"),
            "joint d.base=9deg\njoint d.base=-9deg\njoint d.base=9deg\njoint d.base=-9deg\n");
}

TEST(SequenceRows, speeds_are_shares_of_the_joints_limits) {
  const RobotModel& robot = test::robot("bigrobotarm");
  const auto& device = robot.device.settings.get<BigRobotArmDevice>();
  const auto rows = rows_of_sequence(
      *sequence::parse("S1\nM203 B100 S50\nM201 B300\nG0 B650", "s.txt", device), robot);
  EXPECT_EQ(rows.text.substr(0, rows.text.find('\n')), "velocity base=50.01% shoulder=50%");
  ASSERT_EQ(rows.notes.size(), 1U);
  EXPECT_EQ(rows.notes[0].line, 3);
  EXPECT_EQ(
      rows.notes[0].sentence,
      "M201 300 is 132.9 deg/s2 of base, more than the 88.6 of the robot's file: no board has "
      "shown it");
  EXPECT_NE(rows.text.find("\nacceleration base=150.0"), std::string::npos) << rows.text;
  const auto slow = read_form(*text_form("sequence"), "S1\nM203 B20\nG0 B3250", "s.txt", robot);
  ASSERT_TRUE(slow);
  EXPECT_EQ(slow->steps[0].line, 3);
  const auto plan = make_plan(*slow, robot, home_joints(robot));
  ASSERT_TRUE(plan);
  // 45 degrees at 8.86 a second.
  EXPECT_NEAR(plan->duration, 45 / 8.86, 0.4);
}

TEST(SequenceRows, what_the_other_form_cannot_say_is_told_with_its_line) {
  const RobotModel& robot = test::robot("bigrobotarm");
  const auto& device = robot.device.settings.get<BigRobotArmDevice>();
  const auto notes = [&](const char* text) {
    return rows_of_sequence(*sequence::parse(text, "s.txt", device), robot).notes;
  };
  EXPECT_TRUE(notes("S1\nG0 B100 S0 E0 WR0 W0").empty());
  ASSERT_EQ(notes("\nG0 B100 S0 E0 WR0 W0\nG0 B200").size(), 1U);
  EXPECT_EQ(notes("\nG0 B100 S0 E0 WR0 W0")[0].line, 2);
  const auto of_rows = [&](const char* text) {
    const auto program = parse(text, "p.sinew", robot);
    EXPECT_TRUE(program) << first_complaint(program);
    return first_complaint(sequence_of_rows(*program, robot));
  };
  EXPECT_EQ(of_rows("joint base=10deg\njoint d.base=5deg\nloop 3\ngripper 40deg\nend"), "");
  EXPECT_EQ(of_rows("wait 1s"),
            "p.sinew:1:1: no command of a sequence says this row: it has joint, gripper and loop");
  EXPECT_EQ(of_rows("joint base=1deg speed=50%"),
            "p.sinew:1:1: G0 has no speed=, accel=, blend= or time=");
  EXPECT_EQ(of_rows("loop 2\njoint d.base=1deg\nend"),
            "p.sinew:2:1: a difference goes elsewhere in each round; G0 says places");
  EXPECT_EQ(of_rows("loop 3\njoint base=10deg\nend"),
            "p.sinew:2:1: in a loop a row names all joints: the others may stand elsewhere in the "
            "next round, and a G0 says them all");
  EXPECT_EQ(of_rows("gripper 90deg\nloop 3\ngripper on\ngripper 30deg\nend"),
            "p.sinew:3:1: in a loop gripper says its angle: the next round may begin elsewhere");
  EXPECT_EQ(of_rows("loop 200\ngripper off\nend"),
            "p.sinew:1:1: a block of a sequence has 127 rounds at most");
  EXPECT_EQ(of_rows("loop 2\nloop 2\ngripper off\nend\nend"),
            "p.sinew:2:1: blocks of a sequence are not nested");
  EXPECT_EQ(of_rows("gripper on"),
            "p.sinew:1:1: G1 says an angle, and no row before this one does");
  EXPECT_EQ(of_rows("gripper 40deg\ngripper off\ngripper on"), "");
  EXPECT_EQ(of_rows("gripper 40.5deg"), "p.sinew:1:1: G1 takes whole degrees of the gripper");
}

}  // namespace
}  // namespace sinew::program
