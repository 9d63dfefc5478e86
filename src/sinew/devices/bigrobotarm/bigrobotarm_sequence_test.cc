#include "sinew/devices/bigrobotarm/bigrobotarm_sequence.h"

#include <gtest/gtest.h>

#include "support/property.h"

namespace sinew::sequence {
namespace {

const BigRobotArmDevice kDevice{};

std::string complaint_of(std::string_view text) {
  const auto program = parse(text, "f", kDevice);
  if (program) return "accepted";
  EXPECT_EQ(program.error().size(), 1U) << text;
  return to_text(program.error()[0]);
}

TEST(SequenceFile, documented_sequence_is_one_block_of_two_moves) {
  const auto program = parse(
      "BEGIN I5\n"
      "G0 B100 S200 E300 WR400 W300\n"
      "G0 B0 S50 E5000 WR1500 W0\n"
      "END\n",
      "f", kDevice);
  ASSERT_TRUE(program);
  ASSERT_EQ(program->sections.size(), 1U);
  const Section& block = program->sections[0];
  EXPECT_TRUE(block.block);
  EXPECT_EQ(block.repeats, 5);
  ASSERT_EQ(block.steps.size(), 2U);
  EXPECT_EQ(block.steps[0].command, (Command{Move{{{100, 200, 300, 400, 300}}}}));
  EXPECT_EQ(block.steps[1].command, (Command{Move{{{0, 50, 5000, 1500, 0}}}}));
  EXPECT_EQ(block.steps[1].line, 3);
}

TEST(SequenceFile, every_command_stands_inside_and_outside_a_block) {
  const std::string commands =
      "G0 B-1 S2 E3 WR4 W5\nG28\nG92\nM203 B200 S100 E100 WR100 W300\nM201 B1\nG1 E1 P180\n"
      "G1 E0 P0\nS0\nS1\n";
  const auto program = parse(commands + "BEGIN I127\n" + commands + "END\n", "f", kDevice);
  ASSERT_TRUE(program);
  ASSERT_EQ(program->sections.size(), 10U);
  EXPECT_EQ(program->sections[9].steps.size(), 9U);
  EXPECT_EQ(program->sections[4].steps[0].command, (Command{Accelerations{{{1}, 1}}}));
  EXPECT_EQ(program->sections[8].steps[0].command, (Command{Synchronise{true}}));
  EXPECT_EQ(to_text(*program), commands + "BEGIN I127\n" + commands + "END\n");
}

TEST(SequenceFile, comments_blank_lines_tabs_and_crlf_are_no_commands) {
  const auto program =
      parse("\r\n# all\r\n  G0\tB1 S2   E3 WR4 W5 # there\r\n\r\nS1", "f", kDevice);
  ASSERT_TRUE(program);
  ASSERT_EQ(program->sections.size(), 2U);
  EXPECT_EQ(program->sections[0].line, 3);
  EXPECT_EQ(program->sections[1].line, 5);
}

TEST(SequenceFile, seventh_word_of_recorded_programs_is_ignored_as_the_arm_does) {
  const auto program = parse("G0 B1 S2 E3 WR4 W5 G40\n", "f", kDevice);
  ASSERT_TRUE(program);
  EXPECT_EQ(to_text(*program), "G0 B1 S2 E3 WR4 W5\n");
  EXPECT_EQ(complaint_of("M203 B1 S2 E3 WR4 W5 G40\n"),
            "f:1:22: M203 takes one to five words, B S E WR W in this order");
}

TEST(SequenceFile, each_mistake_has_its_place_and_its_remedy) {
  EXPECT_EQ(complaint_of("G0 B1 E3"),
            "f:1:7: 'E3' stands where S is due: the arm reads by place, B S E WR W");
  EXPECT_EQ(complaint_of("G0 B1 S2 E3 W4"),
            "f:1:13: 'W4' stands where WR is due: the arm reads by place, B S E WR W");
  EXPECT_EQ(complaint_of("\n  G0 B1x"),
            "f:2:7: 'B1x': a position in steps is a whole number, as in B100");
  EXPECT_EQ(complaint_of("G0 B"), "f:1:5: 'B': a position in steps is a whole number, as in B100");
  EXPECT_EQ(complaint_of("G0 B16777216"),
            "f:1:5: 'B16777216': a position in steps must be -16777215..16777215");
  EXPECT_EQ(complaint_of("G0"), "f:1:3: G0 takes one to five words, B S E WR W in this order");
  EXPECT_EQ(complaint_of("g0 B1"), "f:1:1: unknown command 'g0': did you mean G0?");
  EXPECT_EQ(complaint_of("M20 B1"), "f:1:1: unknown command 'M20': did you mean M203?");
  EXPECT_EQ(complaint_of("DANCE"),
            "f:1:1: unknown command 'DANCE': commands are G0 G28 G92 M203 M201 G1 S0 S1 BEGIN END");
  EXPECT_EQ(complaint_of("M503"),
            "f:1:1: M503 asks for the status, which a program has no use for; remove the line");
  EXPECT_EQ(complaint_of("M203 B0"), "f:1:7: 'B0': a speed must be 1..300");
  EXPECT_EQ(complaint_of("M201 B1 S301"), "f:1:10: 'S301': an acceleration must be 1..300");
  EXPECT_EQ(complaint_of("M201 B99999999999"),
            "f:1:7: 'B99999999999': an acceleration must be 1..300");
  EXPECT_EQ(complaint_of("G1 E1 P181"), "f:1:8: 'P181': a gripper position must be 0..180");
  EXPECT_EQ(complaint_of("G1 E2 P18"), "f:1:5: 'E2': the gripper's switch must be 0..1");
  EXPECT_EQ(complaint_of("G1 P18"), "f:1:1: G1 takes E0 or E1 and a position, as in G1 E1 P90");
  EXPECT_EQ(complaint_of("G28 X"), "f:1:5: G28 stands alone; remove 'X'");
}

TEST(SequenceFile, blocks_are_whole_short_and_flat) {
  EXPECT_EQ(complaint_of("S0\nBEGIN I2\nS1\n"),
            "f:2:1: BEGIN without END: write END behind the last command of the block");
  EXPECT_EQ(complaint_of("END"), "f:1:1: END without BEGIN: remove it, or write BEGIN I1 above");
  EXPECT_EQ(complaint_of("BEGIN I1\nBEGIN I1\nEND\n"),
            "f:2:1: BEGIN inside the block of line 1: blocks do not nest; write END first");
  EXPECT_EQ(complaint_of("BEGIN\nEND\n"),
            "f:1:6: BEGIN takes the number of rounds, as in BEGIN I5");
  EXPECT_EQ(complaint_of("BEGIN I0\nEND\n"), "f:1:8: 'I0': the number of rounds must be 1..127");
  EXPECT_EQ(complaint_of("BEGIN I128\nEND\n"),
            "f:1:8: 'I128': the number of rounds must be 1..127");
  std::string long_block = "BEGIN I1\n";
  for (int i = 0; i < 20; ++i) long_block += "G28\n";
  EXPECT_EQ(complaint_of(long_block + "END\n"), "accepted");
  EXPECT_EQ(complaint_of(long_block + "G28\nG28\nEND\n"),
            "f:22:1: a block holds at most 20 commands: end it above and begin another");
}

TEST(SequenceFile, all_complaints_come_at_once_in_the_order_of_the_lines) {
  const auto program = parse("BEGIN I0\nG0 B1 X2 E3 W4\nfoo\nM203 B0 S0\n", "f", kDevice);
  ASSERT_FALSE(program);
  std::vector<std::pair<int, int>> places;
  for (const auto& complaint : program.error()) {
    places.emplace_back(complaint.line, complaint.column);
  }
  EXPECT_EQ(places, (std::vector<std::pair<int, int>>{
                        {1, 1}, {1, 8}, {2, 7}, {2, 13}, {3, 1}, {4, 7}, {4, 10}}));
  std::string many;
  for (int i = 0; i < 1000; ++i) many += "?\n";
  EXPECT_EQ(parse(many, "f", kDevice).error().size(), kComplaintMax);
}

TEST(SequenceFile, limits_come_from_the_robot) {
  BigRobotArmDevice device;
  device.multiplier_max = 500;
  device.gripper_max = 150;
  EXPECT_TRUE(parse("M203 B500\n", "f", device));
  EXPECT_FALSE(parse("M203 B501\n", "f", device));
  EXPECT_FALSE(parse("G1 E1 P151\n", "f", device));
}

GivenWords random_words(test::Random& random, std::int64_t lower, std::int64_t upper) {
  GivenWords given{.count = static_cast<std::size_t>(random.integer(1, 5))};
  for (std::size_t i = 0; i < given.count; ++i) {
    given.words[i] = static_cast<std::int32_t>(random.integer(lower, upper));
  }
  return given;
}

Command random_command(test::Random& random) {
  switch (random.integer(0, 6)) {
    case 0:
      return Home{};
    case 1:
      return Reset{};
    case 2:
      return Speeds{random_words(random, 1, 300)};
    case 3:
      return Accelerations{random_words(random, 1, 300)};
    case 4:
      return Gripper{random.chance(0.5), static_cast<std::int32_t>(random.integer(0, 180))};
    case 5:
      return Synchronise{random.chance(0.5)};
    default:
      return Move{random_words(random, -14000, 14000)};
  }
}

TEST(SequenceFile, any_program_is_written_and_read_back_unchanged) {
  test::for_random_cases(20'000, [](test::Random& random) {
    Program program;
    for (std::int64_t i = random.integer(0, 5); i > 0; --i) {
      Section section{.block = random.chance(0.5), .line = 0, .repeats = 1, .steps = {}};
      if (section.block) section.repeats = static_cast<int>(random.integer(1, kRepeatsMax));
      const std::int64_t count = section.block ? random.integer(0, 20) : 1;
      for (std::int64_t k = 0; k < count; ++k) {
        section.steps.push_back({0, random_command(random)});
      }
      program.sections.push_back(section);
    }
    const auto again = parse(to_text(program), "f", kDevice);
    ASSERT_TRUE(again) << to_text(program);
    EXPECT_TRUE(same(program, *again)) << to_text(program);
  });
}

}  // namespace
}  // namespace sinew::sequence
