#include "sinew/program/language/program_part.h"

#include <gtest/gtest.h>

#include <cmath>

#include "sinew/core/units.h"
#include "sinew/model/joint_lookup.h"
#include "sinew/program/plans/program_plan.h"
#include "support/robots.h"

namespace sinew::program {
namespace {

Program read(std::string_view text) {
  Surroundings around;
  around.load = [](std::string_view name) -> std::expected<CalledFile, std::string> {
    return CalledFile{std::string(name) + ".sinew", "wait 7s\nwait 8s\n"};
  };
  const auto program = parse(text, "main.sinew", test::robot("learm"), around);
  EXPECT_TRUE(program);
  return program.value_or(Program{});
}

constexpr const char* kWholeText =
    "wait 1s\n"
    "loop 2\n"
    "  wait 2s\n"
    "  if base>1deg\n"
    "    wait 3s\n"
    "  else\n"
    "    wait 4s\n"
    "  end\n"
    "end\n"
    "\n"
    "call other\n"
    "wait 5s\n";

std::string refusal(int line) {
  const auto part = from_line(read(kWholeText), line);
  return part ? "" : part.error();
}

double waits(const Program& program) {
  const RobotModel& robot = test::robot("learm");
  const auto plan = make_plan(program, robot, home_joints(robot));
  EXPECT_TRUE(plan);
  return plan ? plan->duration : 0;
}

TEST(FromLine, what_stands_before_it_is_left_out) {
  const Program whole = read(kWholeText);
  EXPECT_NEAR(waits(whole), 1 + 2 * (2 + 4) + 15 + 5, 1e-9);
  EXPECT_NEAR(waits(*from_line(whole, 1)), waits(whole), 1e-9);
  EXPECT_NEAR(waits(*from_line(whole, 2)), waits(whole) - 1, 1e-9);
  EXPECT_NEAR(waits(*from_line(whole, 11)), 15 + 5, 1e-9) << "a call";
  EXPECT_NEAR(waits(*from_line(whole, 12)), 5, 1e-9);
  const auto twice = from_line(*from_line(whole, 2), 11);
  ASSERT_TRUE(twice);
  EXPECT_NEAR(waits(*twice), 20, 1e-9);
  EXPECT_EQ(twice->steps[0].file, 1);
}

TEST(FromLine, blocks_are_not_entered_and_empty_rows_begin_nothing) {
  EXPECT_EQ(refusal(3), "line 3 is inside the loop of line 2: begin there, or behind its end");
  EXPECT_EQ(refusal(7), "line 7 is inside the loop of line 2: begin there, or behind its end");
  EXPECT_EQ(refusal(9), "line 9 is inside the loop of line 2: begin there, or behind its end");
  EXPECT_EQ(refusal(10), "line 10 has no row that does something");
  EXPECT_EQ(refusal(13), "line 13 has no row that does something");
  EXPECT_EQ(refusal(-1), "line -1 has no row that does something");
}

TEST(Slowed, joints_and_tool_get_their_share_and_no_less_than_can_be_planned) {
  const Program program = read("joint base=20deg\nmove z=1mm speed=50% speed=80mm/s\nwait 1s\n");
  const Program slow = slowed(program, 0.3);
  EXPECT_NEAR(motion_of(slow.steps[0])->joint_share, 0.3, 1e-12);
  EXPECT_FALSE(std::isfinite(motion_of(slow.steps[0])->tool_speed));
  EXPECT_NEAR(motion_of(slow.steps[1])->joint_share, 0.15, 1e-12);
  EXPECT_NEAR(motion_of(slow.steps[1])->tool_speed, 0.024, 1e-12);
  EXPECT_EQ(motion_of(slowed(program, 1e-9).steps[0])->joint_share, 1e-3);
}

}  // namespace
}  // namespace sinew::program
