#include "sinew/devices/encoder/encoder_wire.h"

#include <gtest/gtest.h>

#include <cmath>
#include <map>

#include "sinew/core/error_code.h"
#include "sinew/mcu/encoder_node.h"
#include "support/allocation_guard.h"
#include "support/golden.h"
#include "support/property.h"

namespace sinew::encoder_link {
namespace {

using std::chrono::milliseconds;

const std::map<std::string, Register> kNames{{"position", Register::kPosition},
                                             {"velocity", Register::kVelocity},
                                             {"acceleration", Register::kAcceleration},
                                             {"status", Register::kStatus}};

using Result = std::expected<Reply, ReplyFault>;

/// What comes out of a decoder while it takes the bytes.
std::vector<Result> read_all(Register asked, std::span<const std::uint8_t> bytes) {
  std::vector<Result> results;
  ReplyDecoder decoder(asked);
  for (const std::uint8_t byte : bytes) {
    if (const auto result = decoder.push(byte)) results.push_back(*result);
  }
  return results;
}

/// A node that has all three values.
EncoderNode settled_node() {
  EncoderNode node;
  encoder_node_start(&node);
  constexpr std::array<std::uint8_t, 3> kChip{0x20, 0x05, 0xAA};
  for (int i = 0; i < 200; ++i) encoder_node_sample(&node, kChip.data(), 1);
  return node;
}

/// What the node replies to the last byte.
std::optional<ReplyBytes> answer_of(EncoderNode& node, std::span<const std::uint8_t> bytes) {
  std::optional<ReplyBytes> last;
  for (const std::uint8_t byte : bytes) {
    ReplyBytes reply{};
    const bool answered = encoder_node_receive(&node, byte, reply.data());
    last = answered ? std::optional(reply) : std::nullopt;
  }
  return last;
}

TEST(EncoderLink, golden_requests_are_read_and_written) {
  int requests = 0;
  for (const test::Golden& golden : test::read_goldens("encoder_link.txt")) {
    if (!golden.from_host()) continue;
    const auto bytes = test::from_hex(golden.bytes);
    EncoderNode node = settled_node();
    const auto reply = answer_of(node, bytes);
    ++requests;
    if (golden.meaning == "bad") {
      EXPECT_FALSE(reply) << golden.where;
      continue;
    }
    const Register expected = kNames.at(golden.meaning);
    ASSERT_TRUE(reply) << golden.where;
    const auto results = read_all(expected, *reply);
    ASSERT_TRUE(results.size() == 1 && results[0]) << golden.where;
    EXPECT_TRUE(expected != Register::kPosition || results[0]->value == 0x5AA);
    const RequestBytes spelled = encode(Request{expected});
    EXPECT_EQ(bytes, std::vector<std::uint8_t>(spelled.begin(), spelled.end())) << golden.where;
  }
  EXPECT_EQ(requests, 8);
}

TEST(EncoderLink, golden_replies_are_read_and_written) {
  int replies = 0;
  for (const test::Golden& golden : test::read_goldens("encoder_link.txt")) {
    if (golden.from_host()) continue;
    ++replies;
    const auto words = test::words_in(golden.meaning);
    const bool bad = words.at(0) == "bad";
    const Register name = kNames.at(words.at(bad ? 1 : 0));
    const auto bytes = test::from_hex(golden.bytes);
    const auto results = read_all(name, bytes);
    ASSERT_EQ(results.size(), 1U) << golden.where;
    ASSERT_EQ(results[0].has_value(), !bad) << golden.where;
    if (bad) continue;
    const int value = std::stoi(words.at(1));
    const bool has_sign = name == Register::kVelocity || name == Register::kAcceleration;
    EXPECT_EQ(has_sign ? int{results[0]->as_signed()} : int{results[0]->value}, value)
        << golden.where;
    const ReplyBytes spelled = encode(Reply{name, static_cast<std::uint16_t>(value)});
    EXPECT_EQ(bytes, std::vector<std::uint8_t>(spelled.begin(), spelled.end())) << golden.where;
  }
  EXPECT_EQ(replies, 21);
}

TEST(EncoderLink, each_fault_of_a_reply_has_its_name) {
  const auto fault = [](ReplyBytes bytes, Register asked) {
    return read_all(asked, bytes).at(0).error();
  };
  EXPECT_EQ(fault({0xAB, 1, 0, 0, 0x55}, Register::kPosition), ReplyFault::kWrongStart);
  EXPECT_EQ(fault({0xAA, 2, 0, 0, 0x55}, Register::kPosition), ReplyFault::kWrongRegister);
  EXPECT_EQ(fault({0xAA, 1, 0, 0, 0xAA}, Register::kPosition), ReplyFault::kWrongEnd);
  EXPECT_EQ(fault({0xAA, 1, 0, 0x10, 0x55}, Register::kPosition), ReplyFault::kOutOfRange);
}

TEST(EncoderLink, every_reply_comes_back) {
  for (int value = 0; value <= 0xFFFF; ++value) {
    const Reply reply{Register::kVelocity, static_cast<std::uint16_t>(value)};
    const auto results = read_all(Register::kVelocity, encode(reply));
    ASSERT_TRUE(results.size() == 1 && results[0] == reply) << value;
  }
}

TEST(EncoderLink, request_is_found_behind_any_rubbish) {
  EncoderNode node = settled_node();
  test::for_random_cases(5'000, [&](test::Random& random) {
    for (std::int64_t i = random.integer(0, 12); i > 0; --i) {
      // Bytes that look like parts of requests more often than not.
      constexpr std::array<std::uint8_t, 5> kLikely{0xAA, 0x55, 1, 2, 9};
      answer_of(node, std::array{kLikely[static_cast<std::size_t>(random.integer(0, 4))]});
    }
    const Request request{static_cast<Register>(random.integer(1, 4))};
    const auto reply = answer_of(node, encode(request));
    ASSERT_TRUE(reply);
    EXPECT_EQ((*reply)[1], static_cast<std::uint8_t>(request.name));
  });
}

TEST(EncoderLink, half_a_request_before_a_pause_is_forgotten) {
  EncoderNode node = settled_node();
  constexpr std::array<std::uint8_t, 3> kChip{0x20, 0, 0};
  EXPECT_FALSE(answer_of(node, std::array<std::uint8_t, 2>{0xAA, 1}));
  for (int i = 0; i < 4; ++i) encoder_node_sample(&node, kChip.data(), 1);
  EXPECT_FALSE(answer_of(node, std::array<std::uint8_t, 1>{0x55}));
  EXPECT_TRUE(answer_of(node, std::array<std::uint8_t, 3>{0xAA, 1, 0x55}));
}

TEST(EncoderLinkUnwrap, counts_turns_both_ways_up_to_half_a_turn_a_reading) {
  Unwrap unwrap(200'000);
  Instant now{};
  std::int64_t truth = 100;
  EXPECT_EQ(unwrap.update(100, now), 100);
  test::Random random(test::seed());
  for (int i = 0; i < 20'000; ++i) {
    truth += random.integer(-1999, 1999);
    now += milliseconds(10);
    const auto position = static_cast<std::uint16_t>(((truth % 4096) + 4096) % 4096);
    ASSERT_EQ(unwrap.update(position, now), truth);
  }
  EXPECT_TRUE(unwrap.certain());
}

TEST(EncoderLinkUnwrap, single_flipped_bit_never_moves_the_position_by_more_than_the_shaft_can) {
  test::for_random_cases(2'000, [](test::Random& random) {
    constexpr double kSpeed = 19342;  // ticks/s: 100 deg/s behind 17:1
    Unwrap unwrap(kSpeed * 1.1);
    Instant now{};
    double truth = random.uniform(0, 4095);
    const double speed = random.uniform(-kSpeed, kSpeed);
    for (int i = 0; i < 200; ++i) {
      auto position =
          static_cast<std::uint16_t>(static_cast<std::int64_t>(std::floor(truth)) & 4095);
      const bool flipped = i > 0 && i % 7 == 3;
      if (flipped) position ^= static_cast<std::uint16_t>(1 << random.integer(0, 11));
      const auto ticks = unwrap.update(position, now);
      if (ticks) {
        EXPECT_LE(std::abs(static_cast<double>(*ticks) - truth), 0.018 * 1.1 * kSpeed + 8);
      }
      EXPECT_TRUE(ticks || flipped || i % 7 == 4);
      now += milliseconds(9);
      truth += speed * 9e-3;
    }
    EXPECT_TRUE(unwrap.certain());
  });
}

TEST(EncoderLinkUnwrap, gap_in_which_half_a_turn_was_possible_loses_the_turns) {
  Unwrap unwrap(20'000);
  unwrap.update(0, Instant{});
  unwrap.update(10, Instant{milliseconds(100)});
  EXPECT_TRUE(unwrap.certain());
  unwrap.update(20, Instant{milliseconds(203)});
  EXPECT_FALSE(unwrap.certain());
  unwrap.trust();
  EXPECT_TRUE(unwrap.certain());
}

TEST(EncoderLinkUnwrap, jump_that_stays_is_believed_the_second_time_and_costs_the_certainty) {
  Unwrap unwrap(20'000);
  unwrap.update(0, Instant{});
  EXPECT_EQ(unwrap.update(1500, Instant{milliseconds(10)}), std::nullopt);
  EXPECT_TRUE(unwrap.certain());
  EXPECT_EQ(unwrap.update(1510, Instant{milliseconds(20)}), 1510);
  EXPECT_FALSE(unwrap.certain());
}

class EncoderConversation : public testing::Test {
 protected:
  void wait(milliseconds time) { now_ += time; }
  std::vector<Expected<Reply>> answer(std::span<const std::uint8_t> bytes) {
    std::vector<Expected<Reply>> results;
    for (const std::uint8_t byte : bytes) {
      if (const auto result = link_.receive(byte, now_)) results.push_back(*result);
    }
    return results;
  }

  Conversation link_{Conversation::Timing{}};
  Instant now_{};
};

TEST_F(EncoderConversation, asks_hears_and_asks_again_at_once) {
  for (int i = 0; i < 3; ++i) {
    ASSERT_TRUE(link_.ready(now_));
    EXPECT_EQ(link_.ask(Register::kVelocity, now_), (RequestBytes{0xAA, 2, 0x55}));
    EXPECT_FALSE(link_.ready(now_));
    wait(milliseconds(9));
    const auto reply = answer(encode(Reply{Register::kVelocity, 0xFFFE}));
    ASSERT_TRUE(reply.size() == 1 && reply[0]);
    EXPECT_EQ(reply[0]->as_signed(), -2);
  }
}

TEST_F(EncoderConversation, silence_ends_after_its_time_and_a_late_answer_belongs_to_nobody) {
  link_.ask(Register::kPosition, now_);
  wait(milliseconds(14));
  EXPECT_FALSE(link_.poll(now_));
  wait(milliseconds(1));
  const auto result = link_.poll(now_);
  ASSERT_TRUE(result && !*result);
  EXPECT_EQ(result->error().code, ErrorCode::kDeviceSilent);
  EXPECT_FALSE(link_.ready(now_));
  wait(milliseconds(2));
  EXPECT_TRUE(answer(encode(Reply{Register::kPosition, 77})).empty());
  EXPECT_EQ(link_.stray_bytes(), 5U);
  EXPECT_FALSE(link_.ready(now_));
  wait(milliseconds(3));
  EXPECT_TRUE(link_.ready(now_));
}

TEST_F(EncoderConversation, stale_answer_to_another_question_is_no_answer) {
  link_.ask(Register::kPosition, now_);
  const auto result = answer(encode(Reply{Register::kVelocity, 77}));
  ASSERT_TRUE(result.size() == 1 && !result[0]);
  EXPECT_EQ(result[0].error().code, ErrorCode::kUnexpectedReply);
  EXPECT_FALSE(link_.ready(now_));
  wait(milliseconds(3));
  EXPECT_TRUE(link_.ready(now_));
}

TEST_F(EncoderConversation, lost_or_added_byte_is_never_read_as_a_position) {
  const ReplyBytes good = encode(Reply{Register::kPosition, 0x0555});
  for (std::size_t cut = 0; cut < good.size(); ++cut) {
    link_ = Conversation(Conversation::Timing{});
    link_.ask(Register::kPosition, now_);
    std::vector<std::uint8_t> rest(good.begin(), good.end());
    rest.erase(rest.begin() + static_cast<std::ptrdiff_t>(cut));
    EXPECT_TRUE(answer(rest).empty()) << "without byte " << cut;
    EXPECT_TRUE(link_.poll(now_ + milliseconds(15)).has_value());
  }
  for (int added = 0; added < 256; ++added) {
    link_ = Conversation(Conversation::Timing{});
    link_.ask(Register::kPosition, now_);
    std::vector<std::uint8_t> more(good.begin(), good.end());
    more.insert(more.begin(), static_cast<std::uint8_t>(added));
    const auto results = answer(more);
    ASSERT_EQ(results.size(), 1U);
    EXPECT_FALSE(results[0]) << added;
  }
}

TEST(EncoderLink, never_allocates) {
  Conversation link{Conversation::Timing{}};
  Unwrap unwrap(1e5);
  const test::AllocationCounter allocations;
  for (int i = 0; i < 100; ++i) {
    const Instant now{milliseconds(20 * i)};
    link.ask(Register::kPosition, now);
    for (const std::uint8_t byte : encode(Reply{Register::kPosition, 5})) link.receive(byte, now);
    unwrap.update(5, now);
  }
  EXPECT_EQ(allocations.count(), 0U);
}

}  // namespace
}  // namespace sinew::encoder_link
