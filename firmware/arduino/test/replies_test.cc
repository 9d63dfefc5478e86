#include <gtest/gtest.h>
#include <maxarm_replies.h>

#include <optional>

#include "sinew/devices/maxarm/maxarm_wire.h"
#include "support/golden.h"
#include "support/property.h"

namespace sinew {
namespace {

using Bytes = std::vector<std::uint8_t>;

std::vector<sinew_maxarm::Reply> replies_in(const Bytes& bytes) {
  sinew_maxarm::ReplyParser parser;
  std::vector<sinew_maxarm::Reply> replies;
  sinew_maxarm::Reply reply{};
  for (const std::uint8_t byte : bytes) {
    if (parser.push(byte, reply)) replies.push_back(reply);
  }
  return replies;
}

Bytes operator+(Bytes left, const Bytes& right) {
  left.insert(left.end(), right.begin(), right.end());
  return left;
}

const Bytes kGood = test::from_hex("AA 55 11 06 60 03 9A 01 C9 02 1F");

void expect_good(const std::vector<sinew_maxarm::Reply>& replies) {
  ASSERT_EQ(replies.size(), 1U);
  EXPECT_EQ(replies[0].function, 0x11);
  EXPECT_EQ(replies[0].values[0], 864);
  EXPECT_EQ(replies[0].values[1], 410);
  EXPECT_EQ(replies[0].values[2], 713);
}

TEST(ArduinoReplies, every_documented_reply_is_read_with_its_checksum) {
  int count = 0;
  for (const test::Golden& golden : test::read_goldens("maxarm.txt")) {
    if (golden.who != "device") continue;
    const auto words = test::words_in(golden.meaning);
    const auto replies = replies_in(test::from_hex(golden.bytes));
    ASSERT_EQ(replies.size(), 1U) << golden.where;
    EXPECT_EQ(replies[0].function, words[0] == "angles" ? 0x11 : 0x13) << golden.where;
    for (std::size_t i = 0; i < 3; ++i) {
      EXPECT_EQ(replies[0].values[i], std::stoi(words[1 + i])) << golden.where;
    }
    EXPECT_EQ(replies[0].checksum,
              words[4] == "spec" ? ReplyChecksum::kSpec : ReplyChecksum::kWithHeader)
        << golden.where;
    ++count;
  }
  EXPECT_GE(count, 20);
}

TEST(ArduinoReplies, aa_aa_55_is_a_beginning) {
  expect_good(replies_in(Bytes{0xAA} + kGood));
  expect_good(replies_in(Bytes{0xAA, 0xAA, 0xAA} + kGood));
  expect_good(replies_in(Bytes{0xAA, 0x55, 0xAA} + kGood));
}

TEST(ArduinoReplies, six_partial_frames_before_a_reply_lose_nothing) {
  Bytes stale;
  for (int i = 0; i < 6; ++i) stale = stale + test::from_hex("AA 55 11 05");
  stale = stale + test::from_hex("AA 55 11 06 77");
  EXPECT_EQ(stale.size(), 29U);
  expect_good(replies_in(stale + kGood));
}

TEST(ArduinoReplies, reply_behind_a_cut_one_or_a_wrong_sum_is_found) {
  for (std::size_t cut = 0; cut < kGood.size(); ++cut) {
    expect_good(replies_in(Bytes(kGood.begin(), kGood.begin() + static_cast<long>(cut)) + kGood));
  }
  Bytes wrong = kGood;
  wrong.back() ^= 0x40;
  expect_good(replies_in(wrong + kGood));
}

TEST(ArduinoReplies, no_single_flipped_bit_passes_with_the_settled_checksum) {
  for (std::size_t bit = 0; bit < 8 * kGood.size(); ++bit) {
    Bytes flipped = kGood;
    flipped[bit / 8] ^= static_cast<std::uint8_t>(1U << bit % 8);
    for (const auto& reply : replies_in(flipped)) {
      EXPECT_EQ(reply.checksum, ReplyChecksum::kWithHeader) << bit;
    }
  }
}

TEST(ArduinoReplies, any_stream_is_read_as_the_product_reads_it) {
  test::for_random_cases(3000, [](test::Random& random) {
    constexpr std::array<std::uint8_t, 6> kLikely{0xAA, 0x55, 0x11, 0x13, 0x06, 0x05};
    Bytes stream;
    while (stream.size() < 80) {
      if (random.chance(0.3)) {
        const auto value = [&] { return static_cast<std::int16_t>(random.integer(-5, 1005)); };
        const maxarm::Angles angles{{value(), value(), value()}};
        const maxarm::Position position{{value(), value(), value()}};
        const auto frame = maxarm::encode_reply(
            random.chance(0.5) ? maxarm::Reply{angles} : maxarm::Reply{position},
            random.chance(0.5) ? maxarm::Checksum::kSpec : maxarm::Checksum::kWithHeader);
        stream.insert(stream.end(), frame.begin(), frame.end());
      } else {
        stream.push_back(random.chance(0.8) ? kLikely[random.bits() % kLikely.size()]
                                            : static_cast<std::uint8_t>(random.bits()));
      }
    }
    sinew_maxarm::ReplyParser parser;
    maxarm::ReplyDecoder decoder;
    for (const std::uint8_t byte : stream) {
      sinew_maxarm::Reply reply{};
      const bool found = parser.push(byte, reply);
      const auto expected = decoder.push(byte);
      ASSERT_EQ(found, expected.has_value());
      if (!found) continue;
      const auto* angles = std::get_if<maxarm::Angles>(&expected->reply);
      const auto& values =
          angles != nullptr ? angles->pulses : std::get<maxarm::Position>(expected->reply).xyz_mm;
      EXPECT_EQ(reply.function, angles != nullptr ? 0x11 : 0x13);
      EXPECT_TRUE(std::equal(values.begin(), values.end(), reply.values));
      EXPECT_EQ(reply.checksum == ReplyChecksum::kSpec,
                expected->checksum == maxarm::Checksum::kSpec);
    }
  });
}

TEST(ArduinoReplies, checksum_is_settled_by_two_and_changed_by_three_in_a_row) {
  using enum ReplyChecksum;
  sinew_maxarm::ChecksumWatch watch;
  EXPECT_EQ(watch.checksum(), kUnknown);
  EXPECT_TRUE(watch.accept(kWithHeader));
  EXPECT_TRUE(watch.accept(kSpec)) << "one reply settles nothing";
  EXPECT_TRUE(watch.accept(kSpec));
  EXPECT_EQ(watch.checksum(), kSpec);
  EXPECT_FALSE(watch.accept(kWithHeader));
  EXPECT_FALSE(watch.accept(kWithHeader));
  EXPECT_TRUE(watch.accept(kSpec)) << "two others were noise";
  EXPECT_FALSE(watch.accept(kWithHeader));
  EXPECT_FALSE(watch.accept(kWithHeader));
  EXPECT_EQ(watch.changes(), 0);
  EXPECT_TRUE(watch.accept(kWithHeader));
  EXPECT_EQ(watch.checksum(), kWithHeader);
  EXPECT_EQ(watch.changes(), 1);
  EXPECT_FALSE(watch.accept(kSpec));
}

}  // namespace
}  // namespace sinew
