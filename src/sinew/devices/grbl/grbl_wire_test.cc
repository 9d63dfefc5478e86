#include "sinew/devices/grbl/grbl_wire.h"

#include <gtest/gtest.h>

#include <cmath>
#include <string>

#include "support/property.h"

namespace sinew::grbl {
namespace {

using test::Random;
using Result = LineDecoder::Result;

std::string text_of(const Line& line) {
  return {line.begin(), line.end()};
}
std::string_view without_end(const std::string& line) {
  return std::string_view(line).substr(0, line.size() - 1);
}

/// As three decimals have it.
double value_of(Random& random, double most) {
  return std::round(random.uniform(-most, most) * 1000) / 1000;
}
Values values_of(Random& random, std::int64_t axes) {
  Values values;
  for (std::int64_t i = 0; i < axes; ++i) values.push_back(value_of(random, kValueMax));
  return values;
}

Request request_of(Random& random) {
  const auto axis = static_cast<std::size_t>(random.integer(0, kAxesMax - 1));
  const double rate = std::round(random.uniform(1, 6e4) * 1000) / 1000;
  switch (random.integer(0, 5)) {
    case 0:
      return random.chance(0.5) ? Request(Jog{axis, value_of(random, kValueMax), rate})
                                : Request(Probe{axis, value_of(random, kValueMax), rate});
    case 1:
      return Home{static_cast<AxisMask>(random.integer(0, 63))};
    case 2:
      return random.chance(0.5)   ? Request(Unlock{})
             : random.chance(0.5) ? Request(Modes{})
                                  : Request(ToolOffset{value_of(random, kValueMax)});
    case 3:
      return random.chance(0.5) ? Request(AskSettings{}) : Request(AskBuild{});
    default:
      break;
  }
  const double decades = random.uniform(std::log10(kDurationMin), std::log10(kDurationMax));
  return Move{values_of(random, random.integer(1, kAxesMax)), std::pow(10, decades)};
}

Reply reply_of(Random& random) {
  const auto code = static_cast<std::uint16_t>(random.integer(0, 65535));
  switch (random.integer(0, 8)) {
    case 0:
      return Ok{};
    case 1:
      return Refused{code};
    case 2:
      return Alarm{code};
    case 3:
      return Setting{code, value_of(random, 1e6)};
    case 4:
      return Build{code, code, static_cast<std::uint8_t>(random.integer(0, 6))};
    case 5:
      return Welcome{static_cast<Firmware>(random.integer(0, 2)), code, code};
    case 6:
      return Probed{values_of(random, random.integer(1, kAxesMax)), random.chance(0.5)};
    default:
      break;
  }
  const std::int64_t axes = random.integer(1, kAxesMax);
  Status status{.state = static_cast<State>(random.integer(0, 9)),
                .detail = static_cast<std::uint16_t>(random.integer(0, 3)),
                .work = random.chance(0.3),
                .position = values_of(random, axes)};
  if (random.chance(0.3)) status.offset = values_of(random, axes);
  if (random.chance(0.5)) status.room = {code, code};
  if (random.chance(0.3)) {
    status.pins = Pins{.limits = static_cast<AxisMask>(random.integer(0, 63)),
                       .probe = random.chance(0.5),
                       .emergency_stop = random.chance(0.5)};
  }
  return status;
}

TEST(GrblWire, lines_of_a_host_are_these) {
  EXPECT_EQ(text_of(encode(Request(Move{{1, -2.5, 0, 90, 0.001, -180}, 2}))),
            "G53G93G1X1.000Y-2.500Z0.000A90.000B0.001C-180.000F30.00000\n");
  EXPECT_EQ(text_of(encode(Request(Jog{4, -0.25, 300}))), "$J=G21G91B-0.250F300.000\n");
  EXPECT_EQ(text_of(encode(Request(Probe{1, 5, 72}))), "G21G91G94G38.3Y5.000F72.000\n");
  EXPECT_EQ(text_of(encode(Request(Home{}))), "$H\n");
  EXPECT_EQ(text_of(encode(Request(Home{0b100001}))), "$HXC\n");
  EXPECT_EQ(text_of(encode(Request(Modes{}))), "G21G90G94\n");
  EXPECT_EQ(text_of(encode(Request(ToolOffset{-1.5}))), "G43.1Z-1.500\n");
  EXPECT_EQ(text_of(encode(Request(Unlock{}))), "$X\n");
  EXPECT_EQ(text_of(encode(Request(AskSettings{}))), "$$\n");
  EXPECT_EQ(text_of(encode(Request(AskBuild{}))), "$I\n");
}

// Lines as the three firmwares' documents show them.
TEST(GrblWire, reports_of_each_firmware_are_read) {
  const auto grbl = decode_reply("<Idle|MPos:0.000,-10.000,5.125|FS:0,0|WCO:0.000,1.000,2.000>");
  EXPECT_EQ(
      grbl,
      Reply(Status{.state = State::kIdle, .position = {0, -10, 5.125}, .offset = Values{0, 1, 2}}));
  const auto full = decode_reply(
      "<Hold:1|MPos:1.000,2.000,3.000,4.000,5.000,6.000|Bf:35,1024|Ln:7|FS:500,0|Pn:PXC|"
      "Ov:100,100,100|A:SF>");
  EXPECT_EQ(full, Reply(Status{.state = State::kHold,
                               .detail = 1,
                               .position = {1, 2, 3, 4, 5, 6},
                               .room = Status::Room{35, 1024},
                               .pins = Pins{.limits = 0b100001, .probe = true}}));
  const auto work = decode_reply("<Run|WPos:1.000,2.000,3.000|FS:500,0>");
  EXPECT_EQ(work, Reply(Status{.state = State::kRun, .work = true, .position = {1, 2, 3}}));
  const auto alarm = decode_reply("<Alarm:11|MPos:0.000,0.000,0.000|Pn:E>");
  EXPECT_EQ(alarm, Reply(Status{.state = State::kAlarm,
                                .detail = 11,
                                .position = {0, 0, 0},
                                .pins = Pins{.emergency_stop = true}}));
}

TEST(GrblWire, a_board_says_what_it_is) {
  EXPECT_EQ(decode_reply("Grbl 1.1f ['$' for help]"), Reply(Welcome{Firmware::kGrbl, 1, 1}));
  EXPECT_EQ(decode_reply("GrblHAL 1.1f ['$' or '$HELP' for help]"),
            Reply(Welcome{Firmware::kGrblHal, 1, 1}));
  EXPECT_EQ(decode_reply("Grbl 3.7 [FluidNC v3.7.8 (wifi) '$' for help]"),
            Reply(Welcome{Firmware::kFluidNc, 3, 7}));
  EXPECT_EQ(decode_reply("[OPT:V,15,128]"), Reply(Build{15, 128, 0}));
  EXPECT_EQ(decode_reply("[OPT:VNMSL,35,1024,3,0]"), Reply(Build{35, 1024, 3}));
  EXPECT_EQ(decode_reply("[PRB:1.000,-2.500,0.000:1]"), Reply(Probed{{1, -2.5, 0}, true}));
  EXPECT_EQ(decode_reply("[PRB:0.000:0]"), Reply(Probed{{0}, false}));
  EXPECT_EQ(decode_reply("$110=500.000"), Reply(Setting{110, 500}));
  EXPECT_EQ(decode_reply("$0=10"), Reply(Setting{0, 10}));
}

TEST(GrblWire, other_lines_are_notes) {
  for (const char* line : {"[MSG:Caution: Unlocked]", "[VER:1.1f.20170801:]", "$N0=G54", "$N1=",
                           "$I=text", "$Stepping/IdleMs=250", ">G54:ok", "[GC:G0 G54]", "okay"}) {
    EXPECT_EQ(decode_reply(line), Reply(Note{})) << line;
  }
}

TEST(GrblWire, what_begins_like_a_reply_and_is_damaged_is_none) {
  for (const char* line : {"<Idle|MPos:0.000,0.000,0.000",
                           "<Idle>",
                           "<Idle|FS:0,0>",
                           "<Idel|MPos:1.000>",
                           "<Idle|MPos:1.000,>",
                           "<Idle|MPos:1.000,2.0x0>",
                           "<Idle|MPos:nan>",
                           "<Idle|MPos:inf,1.000>",
                           "<Idle|MPos:1e3>",
                           "<Idle|MPos:1,2,3,4,5,6,7>",
                           "<Idle|MPos:1.000,2.000|WCO:1.000>",
                           "<Idle|MPos:1.000|Bf:15>",
                           "<Idle|MPos:1.000|Bf:15,70000>",
                           "<Hold:x|MPos:1.000>",
                           "error:",
                           "error:2x",
                           "error:70000",
                           "ALARM:",
                           "ALARM:-1",
                           "Grbl ",
                           "Grbl 1",
                           "[OPT:V,15]",
                           "[OPT:V,x,128]",
                           "[PRB:]",
                           "[PRB:1.000,2.000]",
                           "[PRB:1.000:2]",
                           "[PRB:1.000:1",
                           "[PRB:1,2,3,4,5,6,7:1]"}) {
    EXPECT_FALSE(decode_reply(line)) << line;
  }
}

TEST(GrblWire, lines_that_no_host_of_ours_says_are_refused) {
  for (const char* line :
       {"", "G0X1", "G53G93G1", "G53G93G1X1.000", "G53G93G1Y1.000F30", "G53G93G1X1.000X2.000F30",
        "G53G93G1X1.000F0", "G53G93G1X1.000F-1", "G53G93G1X1.000F30M3", "$J=G21G91", "$J=G21G91X1",
        "$J=G21G91W1F30", "G38.3X1F30", "G21G91G94G38.3X1", "$HQ", "$Hx", "$XX"}) {
    EXPECT_FALSE(decode_request(line)) << line;
  }
}

TEST(GrblWire, every_line_of_a_host_fits_a_board_and_comes_back) {
  test::for_random_cases(20'000, [](Random& random) {
    const Request request = request_of(random);
    const std::string line = text_of(encode(request));
    ASSERT_LE(line.size(), kLineMax + 1) << line;
    const auto back = decode_request(without_end(line));
    ASSERT_TRUE(back) << line;
    const auto* move = std::get_if<Move>(&request);
    if (move == nullptr) {
      ASSERT_EQ(*back, request) << line;
      return;
    }
    // Nine characters of a duration: half a unit of the last one.
    const Move& read = std::get<Move>(*back);
    ASSERT_EQ(read.to, move->to) << line;
    ASSERT_NEAR(read.duration, move->duration, 6e-5 * move->duration) << line;
  });
}

TEST(GrblWire, the_longest_line_fits) {
  Values far;
  for (std::size_t i = 0; i < kAxesMax; ++i) far.push_back(-kValueMax);
  for (const double duration : {kDurationMin, 1.0, 60.0, kDurationMax}) {
    EXPECT_LE(encode(Request(Move{far, duration})).size(), kLineMax + 1) << duration;
  }
}

TEST(GrblWire, every_reply_comes_back) {
  test::for_random_cases(20'000, [](Random& random) {
    const Reply reply = reply_of(random);
    const std::string line = text_of(encode(reply));
    ASSERT_LE(line.size(), kReplyMax) << line;
    ASSERT_EQ(decode_reply(without_end(line)), reply) << line;
  });
}

TEST(GrblWire, lines_end_with_either_end_and_blank_ones_are_none) {
  LineDecoder decoder;
  std::vector<std::string> lines;
  for (const char c : std::string_view("\r\nok\r\n\r\n\nerror:9\nok")) {
    const Result result = decoder.push(static_cast<std::uint8_t>(c));
    EXPECT_NE(result, Result::kDamaged);
    if (result == Result::kLine) lines.emplace_back(decoder.line());
  }
  EXPECT_EQ(lines, (std::vector<std::string>{"ok", "error:9"}));
  EXPECT_FALSE(decoder.at_boundary());
}

TEST(GrblWire, a_line_that_is_too_long_or_has_control_characters_is_damaged_and_the_next_is_not) {
  for (const std::string& damaged : {std::string(kReplyMax + 1, 'x'), std::string("o\x01k"),
                                     std::string("\0", 1), std::string("ok\x7F")}) {
    LineDecoder decoder;
    Result last = Result::kMore;
    for (const char c : damaged + "\n") last = decoder.push(static_cast<std::uint8_t>(c));
    EXPECT_EQ(last, Result::kDamaged);
    EXPECT_TRUE(decoder.at_boundary());
    for (const char c : std::string_view("ok\n")) last = decoder.push(static_cast<std::uint8_t>(c));
    EXPECT_EQ(last, Result::kLine);
    EXPECT_EQ(decoder.line(), "ok");
  }
}

TEST(GrblWire, what_is_read_of_a_damaged_line_can_be_said_and_is_read_again) {
  test::for_random_cases(20'000, [](Random& random) {
    std::string line = random.chance(0.5) ? text_of(encode(reply_of(random)))
                                          : text_of(encode(request_of(random)));
    for (std::int64_t i = random.integer(1, 4); i > 0; --i) {
      const auto at =
          static_cast<std::size_t>(random.integer(0, static_cast<std::int64_t>(line.size()) - 1));
      line[at] = static_cast<char>(random.integer(0x20, 0x7E));
    }
    // What is read can be said, and is read again.
    const auto reply = decode_reply(line);
    ASSERT_TRUE(!reply || decode_reply(without_end(text_of(encode(*reply))))) << line;
  });
}

}  // namespace
}  // namespace sinew::grbl
