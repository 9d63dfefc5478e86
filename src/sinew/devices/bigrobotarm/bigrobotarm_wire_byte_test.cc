#include "sinew/devices/bigrobotarm/bigrobotarm_wire_byte.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <vector>

#include "sinew/devices/bigrobotarm/bigrobotarm_golden_test_support.h"
#include "support/allocation_guard.h"
#include "support/property.h"

namespace sinew::bigrobotarm::byte {
namespace {

using Bytes = std::vector<std::uint8_t>;

Words random_words(test::Random& random) {
  Words words{};
  // Small, line-end-like and arbitrary numbers, each often enough to meet the others.
  for (auto& word : words) {
    const std::int64_t kind = random.integer(0, 2);
    if (kind == 0) word = static_cast<std::int32_t>(random.integer(-300, 300));
    if (kind == 1) word = static_cast<std::int32_t>(random.bits());
    if (kind == 2) word = 0x0A0DC80D;
  }
  return words;
}

Request random_request(test::Random& random) {
  const auto any_byte = static_cast<std::uint8_t>(random.integer(0, 255));
  switch (random.integer(1, 8)) {
    case 1:
      return Goto{random_words(random)};
    case 2:
      return Home{};
    case 3:
      return Reset{};
    case 4:
      return SetSpeeds{random_words(random)};
    case 5:
      return SetAccelerations{random_words(random)};
    case 6:
      return SetGripper{random.chance(0.5), any_byte};
    case 7:
      return SetSync{random.chance(0.5)};
    default:
      return ReadStatus{};
  }
}

/// One exchange: a motion gives two messages.
std::vector<Reply> random_replies(test::Random& random) {
  const Gripper gripper{random.chance(0.5), static_cast<std::uint8_t>(random.integer(0, 255))};
  switch (random.integer(1, 9)) {
    case 1:
      return {MotionStarted{RequestId::kGoto}, GotoDone{random_words(random)}};
    case 2:
      return {MotionStarted{RequestId::kHome}, HomeDone{random_words(random)}};
    case 3:
      return {ResetDone{random_words(random)}};
    case 4:
      return {Speeds{random_words(random)}};
    case 5:
      return {Accelerations{random_words(random)}};
    case 6:
      return {gripper};
    case 7:
      return {Sync{random.chance(0.5)}};
    case 8:
      return {Invalid{}};
    default:
      return {Status{random_words(random), random_words(random), random_words(random), gripper,
                     random.chance(0.5)}};
  }
}

void append(Bytes& bytes, const Reply& reply) {
  const ReplyBytes encoded = encode_reply(reply);
  bytes.insert(bytes.end(), encoded.begin(), encoded.end());
}

struct Decoded {
  std::vector<Reply> replies;
  std::vector<Garbage> garbage;
};

Decoded decode(ReplyDecoder& decoder, std::span<const std::uint8_t> bytes) {
  Decoded decoded;
  for (const std::uint8_t byte : bytes) {
    const auto result = decoder.push(byte);
    if (!result) continue;
    if (*result) {
      decoded.replies.push_back(**result);
    } else {
      decoded.garbage.push_back(result->error());
    }
  }
  return decoded;
}

TEST(BigRobotArmByte, every_golden_request_is_read_and_written) {
  int count = 0;
  for (const auto& golden : test::read_goldens("bigrobotarm_byte.txt")) {
    if (!golden.from_host()) continue;
    ++count;
    const Bytes bytes = test::from_hex(golden.bytes);
    const Request meaning = test::request_of(golden.meaning);
    const RequestBytes encoded = encode_request(meaning);
    EXPECT_EQ(Bytes(encoded.begin(), encoded.end()), bytes) << golden.where;
    RequestDecoder decoder;
    for (std::size_t i = 0; i < bytes.size(); ++i) {
      const auto result = decoder.push(bytes[i]);
      EXPECT_EQ(result.has_value(), i + 1 == bytes.size()) << golden.where;
      if (result) {
        EXPECT_EQ(result->value(), meaning) << golden.where;
      }
    }
  }
  EXPECT_EQ(count, 10);
}

TEST(BigRobotArmByte, every_golden_reply_is_read_and_written) {
  int count = 0;
  for (const auto& golden : test::read_goldens("bigrobotarm_byte.txt")) {
    if (golden.from_host()) continue;
    ++count;
    const Bytes bytes = test::from_hex(golden.bytes);
    std::vector<Reply> meaning;
    for (const auto& part : test::split(golden.meaning, ';')) {
      meaning.push_back(test::reply_of(part));
    }
    Bytes encoded;
    for (const Reply& reply : meaning) append(encoded, reply);
    EXPECT_EQ(encoded, bytes) << golden.where;
    ReplyDecoder decoder;
    const Decoded decoded = decode(decoder, bytes);
    EXPECT_EQ(decoded.replies, meaning) << golden.where;
    EXPECT_TRUE(decoded.garbage.empty() && decoder.at_boundary()) << golden.where;
  }
  EXPECT_EQ(count, 15);
}

TEST(BigRobotArmByte, every_golden_cut_is_read_as_the_firmware_does) {
  int count = 0;
  for (const auto& golden : test::read_goldens("bigrobotarm_cut.txt")) {
    ++count;
    std::vector<std::expected<Request, Invalid>> meaning;
    for (const auto& part : test::split(golden.meaning, ';')) {
      if (part == "invalid") {
        meaning.emplace_back(std::unexpected(Invalid{}));
      } else {
        meaning.emplace_back(test::request_of(part));
      }
    }
    CutRequestDecoder decoder;
    std::vector<std::expected<Request, Invalid>> decoded;
    for (const std::uint8_t byte : test::from_hex(golden.bytes)) {
      if (const auto result = decoder.push(byte)) decoded.push_back(*result);
    }
    EXPECT_EQ(decoded, meaning) << golden.where;
  }
  EXPECT_EQ(count, 9);
}

TEST(BigRobotArmByte, sendable_requests_are_the_same_to_the_document_and_to_the_firmware) {
  test::for_random_cases(20'000, [](test::Random& random) {
    const Request request = random_request(random);
    if (!sendable(request)) return random.discard();
    CutRequestDecoder decoder;
    for (const std::uint8_t byte : encode_request(request)) EXPECT_FALSE(decoder.push(byte));
    const auto result = decoder.push(kTerminator);
    ASSERT_TRUE(result && *result);
    EXPECT_EQ(**result, request);
  });
}

TEST(BigRobotArmByte, bytes_beyond_fifty_are_dropped) {
  CutRequestDecoder decoder;
  EXPECT_FALSE(decoder.push(8));
  for (int i = 0; i < 1000; ++i) EXPECT_FALSE(decoder.push(1));
  EXPECT_EQ(decoder.push(kTerminator)->value(), Request{ReadStatus{}});
  EXPECT_FALSE(decoder.push(kTerminator)->has_value()) << "nothing of it is left";
}

TEST(BigRobotArmByte, replies_survive_every_cut_of_the_stream) {
  test::Random random(test::seed());
  Bytes stream;
  std::vector<Reply> sent;
  for (int i = 0; i < 40; ++i) {
    for (const Reply& reply : random_replies(random)) {
      sent.push_back(reply);
      append(stream, reply);
    }
  }
  for (std::size_t cut = 0; cut <= stream.size(); ++cut) {
    ReplyDecoder decoder;
    const std::span<const std::uint8_t> bytes(stream);
    Decoded decoded = decode(decoder, bytes.first(cut));
    const Decoded rest = decode(decoder, bytes.subspan(cut));
    decoded.replies.insert(decoded.replies.end(), rest.replies.begin(), rest.replies.end());
    ASSERT_EQ(decoded.replies, sent) << "cut at " << cut;
  }
}

TEST(BigRobotArmByte, request_right_behind_a_request_needs_no_terminator) {
  RequestDecoder decoder;
  const Bytes bytes{8, 0x0D, 7, 0x0D, 8, 6, 1, 0x0D, 0x0D, 2};
  std::vector<Request> requests;
  for (const std::uint8_t byte : bytes) {
    if (const auto result = decoder.push(byte)) requests.push_back(result->value());
  }
  const std::vector<Request> expected{ReadStatus{}, SetSync{true}, ReadStatus{},
                                      SetGripper{true, 13}, Home{}};
  EXPECT_EQ(requests, expected);
}

TEST(BigRobotArmByte, unknown_id_is_invalid_up_to_its_terminator) {
  RequestDecoder decoder;
  // The line feed behind 08 0d is the first byte of the next command.
  const Bytes bytes{8, 0x0D, 0x0A, 8, 8, 0x0D, 0x0D, 9, 0x0D, 8};
  std::string seen;
  for (const std::uint8_t byte : bytes) {
    const auto result = decoder.push(byte);
    if (result) seen += result->has_value() ? 'S' : 'I';
    if (!result) seen += '.';
  }
  EXPECT_EQ(seen, "S....II.IS");
}

TEST(BigRobotArmByte, a_byte_0d_anywhere_in_a_word_makes_it_unsendable) {
  for (const std::int32_t word : {13, 269, 3328, 3400, 3583, -243, 0x0D0000, 0x0D000000}) {
    EXPECT_FALSE(sendable(word)) << word;
    EXPECT_FALSE(sendable(Goto{{0, 0, word, 0, 0}})) << word;
    EXPECT_FALSE(sendable(SetSpeeds{{word, 1, 1, 1, 1}})) << word;
  }
  for (const std::int32_t word : {0, 12, 14, 268, 270, 3327, 3584, -13, 0xD0}) {
    EXPECT_TRUE(sendable(word)) << word;
  }
  EXPECT_FALSE(sendable(SetGripper{true, 13}));
  EXPECT_TRUE(sendable(SetGripper{true, 200}));
  // As counted over the arm's travel: 1.3 % of all positions.
  int count = 0;
  for (std::int32_t word = -14000; word <= 14000; ++word) count += sendable(word) ? 0 : 1;
  EXPECT_EQ(count, 364);
}

TEST(BigRobotArmByte, garbage_is_told_once_and_the_next_ready_ends_it) {
  Bytes stream{4, 0x0D, 0x0B};  // 0A was due
  append(stream, Sync{true});
  append(stream, Speeds{{1, 2, 3, 4, 5}});
  ReplyDecoder decoder;
  const Decoded decoded = decode(decoder, stream);
  ASSERT_EQ(decoded.garbage.size(), 1U);
  EXPECT_EQ(decoded.garbage[0], (Garbage{0x0B, 0x0A}));
  EXPECT_EQ(decoded.replies, (std::vector<Reply>{Speeds{{1, 2, 3, 4, 5}}}));
}

TEST(BigRobotArmByte, random_messages_come_back_as_they_were_sent) {
  test::for_random_cases(100'000, [](test::Random& random) {
    const Request request = random_request(random);
    RequestDecoder requests;
    const RequestBytes bytes = encode_request(request);
    for (std::size_t i = 0; i < bytes.size(); ++i) {
      const auto result = requests.push(bytes[i]);
      ASSERT_EQ(result.has_value(), i + 1 == bytes.size());
      if (result) {
        EXPECT_EQ(result->value(), request);
      }
    }
    EXPECT_FALSE(requests.push(kTerminator).has_value());
    const auto sent = random_replies(random);
    Bytes stream;
    for (const Reply& reply : sent) append(stream, reply);
    ReplyDecoder replies;
    EXPECT_EQ(decode(replies, stream).replies, sent);
  });
}

TEST(BigRobotArmByte, any_noise_is_survived_and_a_reset_ends_it) {
  test::for_random_cases(100'000, [](test::Random& random) {
    Bytes stream;
    for (int i = 0; i < 3; ++i) {
      for (const Reply& reply : random_replies(random)) append(stream, reply);
    }
    for (std::int64_t flips = random.integer(1, 8); flips > 0; --flips) {
      const auto last = static_cast<std::int64_t>(stream.size()) - 1;
      stream[static_cast<std::size_t>(random.integer(0, last))] ^=
          static_cast<std::uint8_t>(random.integer(1, 255));
    }
    ReplyDecoder replies;
    (void)decode(replies, stream);
    RequestDecoder requests;
    for (const std::uint8_t byte : stream) (void)requests.push(byte);
    replies.reset();
    const Bytes invalid{0xC9, 0x0D, 0x0A, 0xC8, 0x0D, 0x0A};
    EXPECT_EQ(decode(replies, invalid).replies, (std::vector<Reply>{Invalid{}}));
  });
}

TEST(BigRobotArmByte, coding_does_not_allocate) {
  test::Random random(test::seed());
  const Words words = random_words(random);
  const test::AllocationCounter allocations;
  const RequestBytes request = encode_request(Goto{words});
  RequestDecoder requests;
  for (const std::uint8_t byte : request) (void)requests.push(byte);
  ReplyDecoder replies;
  for (const std::uint8_t byte : encode_reply(Speeds{words})) (void)replies.push(byte);
  EXPECT_EQ(allocations.count(), 0U);
}

}  // namespace
}  // namespace sinew::bigrobotarm::byte
