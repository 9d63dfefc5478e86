#include "sinew/devices/bigrobotarm/bigrobotarm_wire_text.h"

#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "sinew/devices/bigrobotarm/bigrobotarm_golden_test_support.h"
#include "support/allocation_guard.h"
#include "support/property.h"

namespace sinew::bigrobotarm::text {
namespace {

Line line_of(const std::string& meaning) {
  const auto [name, rest] = test::name_and_rest(meaning);
  if (name == "begin") return {Begin{static_cast<std::int8_t>(std::stoi(rest))}};
  if (name == "end") return {End{}};
  if (name == "queue-goto") return {QueueGoto{test::words_of(rest)}};
  if (name == "queue-flush") return {QueueFlush{}};
  if (name == "queue-clear") return {QueueClear{}};
  if (name == "goto-partial") {
    const auto given = test::split(rest, ' ').size();
    return {Request{Goto{test::words_of(rest, given)}}, static_cast<std::uint8_t>(given)};
  }
  return {test::request_of(meaning)};
}

ReplyLine reply_line_of(const std::string& meaning) {
  const auto [name, rest] = test::name_and_rest(meaning);
  if (name == "free-memory") return FreeMemory{std::stoi(rest)};
  if (name == "echo") return Echo{FixedVector<char, kLineBuffer>(std::span<const char>(rest))};
  if (name == "moving-to") return MovingTo{};
  if (name == "positions") return PositionLine{test::words_of(rest)};
  if (name == "speeds") return Speeds{test::words_of(rest)};
  if (name == "accelerations") return Accelerations{test::words_of(rest)};
  if (name == "gripper") return test::gripper_of(rest);
  if (name == "sync") return Sync{test::flag_of(rest)};
  if (name == "invalid") return Invalid{};
  if (name == "ready") return Ready{};
  if (name == "queued-to") return QueuedTo{};
  if (name == "queue-full") return QueueFull{};
  if (name == "queue-drained") return QueueDrained{};
  if (name == "queue-cleared") return QueueCleared{};
  throw std::runtime_error("no such line: " + meaning);
}

std::vector<Reply> decode(std::string_view text, int* garbage = nullptr) {
  ReplyDecoder decoder;
  std::vector<Reply> replies;
  for (const char character : text) {
    const auto result = decoder.push(character);
    if (!result) continue;
    if (*result) {
      replies.push_back(**result);
    } else if (garbage != nullptr) {
      ++*garbage;
    } else {
      ADD_FAILURE() << "garbage in " << text;
    }
  }
  EXPECT_TRUE(decoder.at_boundary() || garbage != nullptr);
  return replies;
}

std::string preamble(const std::string& line) {
  return "Free mem: 5214\r\nProcess command: " + line + "\r\n";
}

const std::string kReadyLine = "BigRobotArm::READY\r\n";

TEST(BigRobotArmText, every_golden_line_is_read_and_written) {
  int host = 0;
  int device = 0;
  for (const auto& golden : test::read_goldens("bigrobotarm_text.txt")) {
    if (golden.from_host()) {
      ++host;
      const Line meaning = line_of(golden.meaning);
      EXPECT_EQ(view(encode_line(meaning)), golden.bytes) << golden.where;
      EXPECT_EQ(decode_line(golden.bytes), meaning) << golden.where;
    } else {
      ++device;
      const ReplyLine meaning = reply_line_of(golden.meaning);
      EXPECT_EQ(view(encode_reply_line(meaning)), golden.bytes) << golden.where;
      EXPECT_EQ(decode_reply_line(golden.bytes), meaning) << golden.where;
    }
  }
  EXPECT_EQ(host, 18);
  EXPECT_EQ(device, 15);
}

TEST(BigRobotArmText, host_lines_are_read_by_place_and_not_by_letter) {
  EXPECT_EQ(decode_line("G0 x1 y2 z3 ab4 c5 G40"), (Line{Request{Goto{{1, 2, 3, 4, 5}}}}));
  EXPECT_EQ(decode_line("G0 B1 S2 E3 W456"), (Line{Request{Goto{{1, 2, 3, 56, 0}}}, 4}));
  EXPECT_EQ(decode_line("  G0   B-7x "), (Line{Request{Goto{{-7, 0, 0, 0, 0}}}, 1}));
  EXPECT_EQ(decode_line("G0"), (Line{Request{Goto{}}, 0}));
  EXPECT_EQ(decode_line("G00 X5"), (Line{Request{Goto{{5, 0, 0, 0, 0}}}, 1}));
  EXPECT_EQ(decode_line("G01 E1 P7"), (Line{Request{SetGripper{true, 7}}}));
  EXPECT_EQ(decode_line("G028"), Line{Request{Home{}}});
  EXPECT_EQ(decode_line("M0503"), Line{Request{ReadStatus{}}});
  EXPECT_EQ(decode_line("G"), std::nullopt);
  EXPECT_EQ(decode_line("G000x"), std::nullopt);
  EXPECT_EQ(decode_line("S 1"), Line{Request{SetSync{false}}});
  EXPECT_EQ(decode_line("Sx1"), Line{Request{SetSync{false}}});
  EXPECT_EQ(decode_line("BEGIN I200"), Line{Begin{-56}});
  EXPECT_EQ(decode_line("G1 E1 P300"), (Line{Request{SetGripper{true, 255}}}));
  EXPECT_EQ(decode_line("G0 B99999999999"), (Line{Request{Goto{{2147483647, 0, 0, 0, 0}}}, 1}));
  EXPECT_EQ(decode_line("G0 B-99999999999"), (Line{Request{Goto{{-2147483647 - 1}}}, 1}));
  for (const char* unknown : {"", " ", "g0 B1", "G02", "M114", "\nM503", "END1", "begin I2"}) {
    EXPECT_FALSE(decode_line(unknown)) << unknown;
  }
}

TEST(BigRobotArmText, device_line_has_one_spelling) {
  for (const char* line :
       {"BigRobotArm::POSITION: B1 S2 E3 WR4", "BigRobotArm::POSITION: B1 S2 E3 WR4 W5 ",
        "BigRobotArm::POSITION: B01 S2 E3 WR4 W5", "BigRobotArm::POSITION: B1 S2 E3 W4 W5",
        "BigRobotArm::SYNC-MOTORS: 2", "BigRobotArm::GRIPPER: E1 P256", "BigRobotArm::ready",
        "Free mem: ", "", "BigRobotArm::POSITION: B-0 S2 E3 WR4 W5"}) {
    EXPECT_FALSE(decode_reply_line(line)) << line;
  }
}

TEST(BigRobotArmText, line_reader_keeps_fifty_characters) {
  LineReader reader;
  for (int i = 0; i < 60; ++i) EXPECT_FALSE(reader.push(static_cast<char>('0' + i % 10)));
  EXPECT_TRUE(reader.push('\r'));
  EXPECT_EQ(reader.line().size(), kLineBuffer);
  EXPECT_FALSE(reader.push('S'));
  EXPECT_TRUE(reader.push('\r'));
  EXPECT_EQ(reader.line(), "S");
  EXPECT_TRUE(reader.push('\r'));
  EXPECT_EQ(reader.line(), "");
  EXPECT_TRUE(sendable(Line{Request{Goto{{-14000, -14000, -14000, -14000, -14000}}}}));
  EXPECT_FALSE(sendable(Line{Request{Goto{{-14000000, -14000000, -14000000, -1400000, -14000}}}}));
}

TEST(BigRobotArmText, replies_are_told_apart_by_their_lines) {
  const std::string positions = "BigRobotArm::POSITION: B1 S2 E3 WR4 W5\r\n";
  const std::string speeds = "BigRobotArm::SPEED: B5 S4 E3 WR2 W1\r\n";
  const std::string accelerations = "BigRobotArm::ACCELERATION: B9 S8 E7 WR6 W5\r\n";
  const std::string moving = "BigRobotArm::MOVING-TO\r\n";
  const Words words{1, 2, 3, 4, 5};
  using Replies = std::vector<Reply>;
  EXPECT_EQ(decode(preamble("G0 B1 S2 E3 WR4 W5") + moving + positions + kReadyLine),
            (Replies{MotionStarted{RequestId::kGoto}, GotoDone{words}}));
  EXPECT_EQ(decode(preamble("G92") + positions + kReadyLine), (Replies{ResetDone{words}}));
  EXPECT_EQ(decode(preamble("M203 B5") + speeds + kReadyLine), (Replies{Speeds{{5, 4, 3, 2, 1}}}));
  EXPECT_EQ(decode(preamble("BEGIN I2") + kReadyLine), (Replies{Accepted{}}));
  EXPECT_EQ(decode("BigRobotArm::INVALID-COMMAND\r\n" + kReadyLine), (Replies{Invalid{}}));
  EXPECT_EQ(decode(preamble("x") + "BigRobotArm::INVALID-COMMAND\r\n" + kReadyLine),
            (Replies{Invalid{}}));
  EXPECT_EQ(decode(preamble("M503") + moving + positions + accelerations + speeds +
                   "BigRobotArm::SYNC-MOTORS: 1\r\n" + kReadyLine),
            (Replies{Status{words, {9, 8, 7, 6, 5}, {5, 4, 3, 2, 1}, std::nullopt, true}}));
}

TEST(BigRobotArmText, replies_of_the_queue_are_told_apart) {
  const std::string q0 = preamble("Q0 B1 S2 E3 WR4 W5");
  const std::string head = "BigRobotArm::QUEUE";
  using Replies = std::vector<Reply>;
  EXPECT_EQ(decode(q0 + head + "D-TO\r\nBigRobotArm::POSITION: B1 S2 E3 WR4 W5\r\n" + kReadyLine),
            (Replies{Queued{{1, 2, 3, 4, 5}}}));
  EXPECT_EQ(decode(q0 + head + "-FULL\r\n" + kReadyLine), (Replies{QueueFull{}}));
  EXPECT_EQ(decode(preamble("QFLUSH") + head + "-DRAINED\r\n" + kReadyLine),
            (Replies{QueueDrained{}}));
  EXPECT_EQ(decode(preamble("QCLEAR") + head + "-CLEARED\r\n" + kReadyLine),
            (Replies{QueueCleared{}}));
  int garbage = 0;
  EXPECT_TRUE(decode(q0 + head + "D-TO\r\n" + kReadyLine, &garbage).empty());
  EXPECT_EQ(garbage, 1) << "queued, and nobody says where to";
}

TEST(BigRobotArmText, garbage_is_told_once_and_ready_ends_it) {
  int garbage = 0;
  const auto replies = decode(preamble("G92") + "noise\r\nmore\n" + kReadyLine + preamble("S1") +
                                  "BigRobotArm::SYNC-MOTORS: 1\r\n" + kReadyLine,
                              &garbage);
  EXPECT_EQ(garbage, 1);
  EXPECT_EQ(replies, (std::vector<Reply>{Sync{true}}));
  garbage = 0;
  EXPECT_TRUE(decode(std::string(500, 'x'), &garbage).empty());
  EXPECT_GE(garbage, 1);
}

TEST(BigRobotArmText, random_lines_come_back_as_they_were_sent) {
  test::for_random_cases(100'000, [](test::Random& random) {
    Words words{};
    for (auto& word : words) {
      word = static_cast<std::int32_t>(static_cast<std::int32_t>(random.bits()) >>
                                       random.integer(0, 31));
    }
    const auto given = static_cast<std::uint8_t>(random.integer(0, 5));
    for (std::size_t i = given; i < kJoints; ++i) words[i] = 0;
    const auto any_byte = static_cast<std::uint8_t>(random.bits() & 0xFF);
    const std::vector<Line> lines{{Request{Goto{words}}, given},
                                  {Request{SetSpeeds{words}}, given},
                                  {Request{SetAccelerations{words}}, given},
                                  {Request{SetGripper{random.chance(0.5), any_byte}}},
                                  {Begin{static_cast<std::int8_t>(any_byte)}}};
    for (const Line& line : lines) EXPECT_EQ(decode_line(view(encode_line(line))), line);
    const std::vector<ReplyLine> replies{PositionLine{words}, Speeds{words}, Accelerations{words},
                                         FreeMemory{words[0]}, Gripper{true, any_byte}};
    for (const ReplyLine& line : replies) {
      EXPECT_EQ(decode_reply_line(view(encode_reply_line(line))), line);
    }
  });
}

TEST(BigRobotArmText, any_noise_is_survived_without_an_allocation) {
  test::Random random(test::seed());
  const test::AllocationCounter allocations;
  ReplyDecoder replies;
  LineReader reader;
  int lines = 0;
  for (int i = 0; i < 300'000; ++i) {
    auto character = static_cast<char>(random.integer(0, 127));
    if (random.chance(0.1)) character = '\n';
    if (random.chance(0.05)) character = '\r';
    (void)replies.push(character);
    if (!reader.push(character)) continue;
    ++lines;
    if (const auto line = decode_line(reader.line())) (void)encode_line(*line);
  }
  EXPECT_GT(lines, 1000);
  EXPECT_EQ(allocations.count(), 0U);
}

}  // namespace
}  // namespace sinew::bigrobotarm::text
