#include "sinew/devices/ideal/ideal_wire.h"

#include <gtest/gtest.h>

#include <limits>

#include "support/property.h"

namespace sinew::ideal {
namespace {

using test::Random;
using Result = LineDecoder::Result;

std::string text_of(const Line& line) {
  return {line.begin(), line.end()};
}

/// The words of a line that comes as a whole; nothing where its sum is wrong.
std::optional<std::string> words_of(std::string_view line) {
  LineDecoder decoder;
  for (std::size_t i = 0; i < line.size(); ++i) {
    const Result result = decoder.push(static_cast<std::uint8_t>(line[i]));
    EXPECT_EQ(result == Result::kMore, i + 1 < line.size()) << line;
    if (result == Result::kLine) return std::string(decoder.words());
  }
  return std::nullopt;
}

std::int32_t any_number(Random& random) {
  const auto most = std::numeric_limits<std::int32_t>::max();
  return static_cast<std::int32_t>(random.integer(-most - 1LL, most));
}
void any_joints(Random& random, Numbers& q, Numbers& qd) {
  for (std::int64_t i = random.integer(1, kJointsMax); i > 0; --i) {
    q.push_back(any_number(random));
    qd.push_back(any_number(random));
  }
}

Request request_of(Random& random) {
  switch (random.integer(0, 5)) {
    case 0:
      return Hello{};
    case 1:
      return Ask{};
    case 2:
      return Stop{};
    case 3:
      return Clear{};
    case 4:
      return Jaws{any_number(random)};
    default:
      break;
  }
  Move move;
  move.number = static_cast<std::uint16_t>(random.integer(0, 65535));
  move.duration_us = static_cast<std::uint32_t>(random.integer(0, 0xFFFF'FFFF));
  any_joints(random, move.q, move.qd);
  return move;
}

Reply reply_of(Random& random) {
  const auto byte = [&] { return static_cast<std::uint8_t>(random.integer(0, 255)); };
  const auto word = [&] { return static_cast<std::uint16_t>(random.integer(0, 65535)); };
  switch (random.integer(0, 2)) {
    case 0:
      return Identity{byte(), byte(), word()};
    case 1:
      return Refusal{static_cast<Why>(random.integer(0, 4)), byte()};
    default:
      break;
  }
  State state;
  state.phase = static_cast<Phase>(random.integer(0, 3));
  state.held = static_cast<Held>(random.integer(0, 3));
  state.joint = byte();
  state.taken = word();
  state.done = word();
  state.jaws_um = any_number(random);
  any_joints(random, state.q, state.qd);
  return state;
}

std::uint16_t any_line(Random& random) {
  return static_cast<std::uint16_t>(random.integer(0, 65535));
}
Numbered<Request> any_request(Random& random) {
  return {any_line(random), request_of(random)};
}
Numbered<Reply> any_reply(Random& random) {
  return {any_line(random), reply_of(random)};
}

std::string said(const Request& request) {
  return text_of(encode(Numbered<Request>{7, request}));
}
std::string answered(const Reply& reply) {
  return text_of(encode(Numbered<Reply>{7, reply}));
}

TEST(IdealWire, lines_are_as_the_document_shows_them) {
  Move move;
  move.number = 7;
  move.duration_us = 20000;
  move.q = {1570796, -5};
  move.qd = {0, 250000};
  EXPECT_TRUE(said(move).starts_with("7 move 7 20000 1570796 0 -5 250000*"));
  EXPECT_EQ(said(Ask{}), "7 ask*5E3A158A\n");
  EXPECT_TRUE(answered(Identity{1, 6, 12}).starts_with("7 ideal 1 6 12*"));
  EXPECT_TRUE(answered(Refusal{Why::kLimit, 2}).starts_with("7 no limit 2*"));
  State state;
  state.phase = Phase::kHeld;
  state.held = Held::kBlocked;
  state.joint = 1;
  state.q = {3};
  state.qd = {0};
  EXPECT_TRUE(answered(state).starts_with("7 held blocked 1 0 0 -1 3 0*"));
}

TEST(IdealWire, what_is_said_is_read_again) {
  test::for_random_cases(20'000, [](Random& random) {
    const Numbered<Request> request = any_request(random);
    const auto asked = words_of(text_of(encode(request)));
    ASSERT_TRUE(asked);
    EXPECT_EQ(decode_request(*asked), std::optional(request)) << *asked;
    const Numbered<Reply> reply = any_reply(random);
    const auto answered = words_of(text_of(encode(reply)));
    ASSERT_TRUE(answered);
    EXPECT_EQ(decode_reply(*answered), std::optional(reply)) << *answered;
  });
}

TEST(IdealWire, a_line_with_flipped_bits_says_what_was_said_or_nothing) {
  test::for_random_cases(20'000, [](Random& random) {
    const Numbered<Request> request = any_request(random);
    std::string line = text_of(encode(request));
    const auto bits = static_cast<std::int64_t>(line.size()) * 8;
    for (std::int64_t i = random.integer(1, 4); i > 0; --i) {
      const auto bit = static_cast<std::size_t>(random.integer(0, bits - 1));
      line[bit / 8] = static_cast<char>(line[bit / 8] ^ 1 << bit % 8);
    }
    LineDecoder decoder;
    for (const char c : line) {
      if (decoder.push(static_cast<std::uint8_t>(c)) != Result::kLine) continue;
      EXPECT_EQ(decode_request(decoder.words()), std::optional(request)) << line;
    }
  });
}

TEST(IdealWire, words_that_are_no_message_are_none) {
  for (const char* words :
       {"", "hello ", " hello", "hello 1", "move", "move 1", "move 1 2", "move 1 2 3",
        "move 65536 2 3 4", "move 1 -2 3 4", "move 1 2 3.0 4", "move 1 2 3 4 5",
        "move 1 2 1 1 1 1 1 1 1 1 1 1 1 1 1 1 1 1 1 1", "move 1 2 3 2147483648", "jaws", "jaws x",
        "jaws 1 2", "MOVE 1 2 3 4", "rest - 0 0 0 -1 0 0"}) {
    EXPECT_EQ(decode_request(std::string("7 ") + words), std::nullopt) << words;
  }
  for (const char* words :
       {"", "ideal", "ideal 1 6", "ideal 256 6 0", "no", "no way 0", "no busy", "rest",
        "rest - 0 0 0 -1", "rest - 0 0 0 -1 0", "sleeping - 0 0 0 -1 0 0", "hello"}) {
    EXPECT_EQ(decode_reply(std::string("7 ") + words), std::nullopt) << words;
  }
}

TEST(IdealWire, a_line_needs_its_number) {
  for (const char* words : {"ask", "-1 ask", "65536 ask", "x ask", "7"}) {
    EXPECT_EQ(decode_request(words), std::nullopt) << words;
  }
  EXPECT_EQ(decode_request("65535 ask"), (Numbered<Request>{65535, Ask{}}));
}

TEST(IdealWire, after_any_noise_and_its_end_the_next_line_is_read) {
  test::for_random_cases(5'000, [](Random& random) {
    LineDecoder decoder;
    for (std::int64_t i = random.integer(0, 600); i > 0; --i) {
      static_cast<void>(decoder.push(static_cast<std::uint8_t>(random.integer(0, 255))));
    }
    static_cast<void>(decoder.push('\n'));
    EXPECT_TRUE(decoder.at_boundary());
    Result last = Result::kMore;
    for (const std::uint8_t byte : encode(Numbered<Request>{7, Stop{}})) last = decoder.push(byte);
    EXPECT_EQ(last, Result::kLine);
    EXPECT_EQ(decoder.words(), "7 stop");
  });
}

}  // namespace
}  // namespace sinew::ideal
