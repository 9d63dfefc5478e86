#include "sinew/program/formats/text_forms.h"

#include <gtest/gtest.h>

#include "support/robots.h"

namespace sinew::program {
namespace {

std::string rows(const char* form, std::string_view text, const char* robot) {
  const auto made = rows_of(*text_form(form), text, "the file", test::robot(robot));
  if (made) return made->text;
  const NoForm& why = made.error();
  return "no: " + (why.complaints.empty() ? why.sentence : to_text(why.complaints.front()));
}

std::string other(const char* form, std::string_view text, const char* robot) {
  const RobotModel& model = test::robot(robot);
  const auto program = parse(text, "program", model);
  EXPECT_TRUE(program) << text;
  const auto made = text_of(*text_form(form), *program, model);
  if (made) return *made;
  const NoForm& why = made.error();
  if (why.refusal) return "no: row " + std::to_string(why.refusal->line);
  return "no: " + (why.complaints.empty() ? why.sentence : to_text(why.complaints.front()));
}

TEST(TextForms, what_they_make_comes_back_the_same) {
  const std::string sequence = "S1\nBEGIN I5\nG0 B100 S200 E300 WR400 W300\nG1 E1 P40\nEND\n";
  const std::string program = rows("sequence", sequence, "bigrobotarm");
  EXPECT_NE(program.find("loop 5\n"), std::string::npos) << program;
  EXPECT_EQ(other("sequence", program, "bigrobotarm"), sequence);
  const std::string row = "move x=-3mm y=2mm z=252mm rx=-0.5deg ry=1deg rz=-2deg\n";
  EXPECT_TRUE(rows("pos", other("pos", row, "hexapod"), "hexapod").ends_with(row));
}

TEST(TextForms, what_another_program_cannot_say_is_told_with_its_place) {
  EXPECT_EQ(rows("sequence", "S1\n", "learm"),
            "no: sequences are the BigRobotArm's; learm is none");
  EXPECT_EQ(rows("pos", "1\n", "hexapod").substr(0, 13), "no: the file:");
  EXPECT_EQ(rows("gcode", "G1 Q3\n", "maxarm").substr(0, 14), "no: the file:1");
  EXPECT_EQ(other("pos", "joint base=1deg\n", "learm"),
            "no: .pos files are a platform's; learm is none");
  EXPECT_EQ(other("pos", "move z=252mm\nwait 1s\n", "hexapod"),
            "no: a .pos file is one pose: it takes a program of one row that moves");
  EXPECT_EQ(other("pos", "wait 1s\nmove z=900mm\n", "hexapod"), "no: row 2");
  EXPECT_NE(other("sequence", "wait 1s\n", "bigrobotarm").find("program:1"), std::string::npos);
}

/// Heads that are nobody's: each of them a little elsewhere than a platform could have it.
TEST(TextForms, heads_of_another_platform_are_none_of_this_one) {
  std::string text = other("pos", "move z=252mm\n", "hexapod");
  text.replace(0, text.find('\n'), "0");
  EXPECT_NE(rows("pos", text, "hexapod").find("no place of hexapod's platform"), std::string::npos);
}

}  // namespace
}  // namespace sinew::program
