#include "sinew/devices/feetech/feetech_wire.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <string>
#include <vector>

#include "support/property.h"

namespace sinew::test {
namespace {

using namespace feetech;
using Result = PacketDecoder::Result;

std::string hex(const Bytes& bytes) {
  std::string text;
  for (const std::uint8_t byte : bytes) {
    constexpr const char* kDigits = "0123456789ABCDEF";
    if (!text.empty()) text += ' ';
    text += {kDigits[byte >> 4], kDigits[byte & 15]};
  }
  return text;
}

std::optional<Packet> only_packet(const Bytes& bytes) {
  PacketDecoder decoder;
  std::optional<Packet> packet;
  for (const std::uint8_t byte : bytes) {
    if (decoder.push(byte) == Result::kPacket) packet = decoder.packet();
  }
  return decoder.at_boundary() ? packet : std::nullopt;
}

/// Frames that the makers' papers print.
TEST(FeetechWire, makes_the_packets_of_the_makers_papers) {
  EXPECT_EQ(hex(encode(Ping{1})), "FF FF 01 02 01 FB");
  EXPECT_EQ(hex(encode(Reply{1, 0, {}})), "FF FF 01 02 00 FC");
  EXPECT_EQ(hex(encode(Read{1, 0x38, 2})), "FF FF 01 04 02 38 02 BE");
  EXPECT_EQ(hex(encode(Reply{1, 0, {0x18, 0x05}})), "FF FF 01 04 00 18 05 DD");
  EXPECT_EQ(hex(encode(Write{1, 0x29, {0x32, 0xE8, 0x03, 0, 0, 0xE8, 0x03}, false})),
            "FF FF 01 0A 03 29 32 E8 03 00 00 E8 03 C0");
  EXPECT_EQ(hex(encode(Write{kBroadcast, 0x37, {0}, false})), "FF FF FE 04 03 37 00 C3");
  EXPECT_EQ(hex(encode(Action{})), "FF FF FE 02 05 FA");
  EXPECT_EQ(hex(encode(SyncRead{0x38, 8, {1, 2}})), "FF FF FE 06 82 38 08 01 02 36");
  SyncWrite all{0x2A, {}};
  for (std::uint8_t id = 1; id <= 4; ++id) all.parts.push_back({id, {0, 8, 0, 0, 0xE8, 3}});
  EXPECT_EQ(hex(encode(all)),
            "FF FF FE 20 83 2A 06 01 00 08 00 00 E8 03 02 00 08 00 00 E8 03 03 00 08 00 00 E8 03 "
            "04 00 08 00 00 E8 03 58");
}

TEST(FeetechWire, reads_the_replies_of_the_makers_papers) {
  const Bytes two{0xFF, 0xFF, 1, 0x0A, 0, 0, 8, 0, 0, 0, 0, 0x79, 0x1E, 0x55};
  const auto packet = only_packet(two);
  ASSERT_TRUE(packet);
  const auto reply = decode_reply(*packet);
  ASSERT_TRUE(reply);
  EXPECT_EQ(reply->id, 1);
  const std::span data(reply->data.data(), reply->data.size());
  EXPECT_EQ(word_at(data, 0, std::endian::little), 2048);
  EXPECT_EQ(data[6], 121);
  EXPECT_EQ(data[7], 30);
}

TEST(FeetechWire, numbers_have_magnitude_and_sign) {
  EXPECT_EQ(signed_word(0x8005, kPositionSign), -5);
  EXPECT_EQ(signed_word(0x0405, kLoadSign), -5);
  EXPECT_EQ(signed_word(0x07FF, kOffsetSign), 2047);
  EXPECT_EQ(sign_and_magnitude(-5, kPositionSign), 0x8005);
  EXPECT_EQ(sign_and_magnitude(-5000, kOffsetSign), 0x0FFF) << "held to what there is room for";
  Data data;
  put_word(data, 0x1234, std::endian::little);
  put_word(data, 0x1234, std::endian::big);
  EXPECT_EQ(data, (Data{0x34, 0x12, 0x12, 0x34}));
  EXPECT_EQ(word_at({data.data(), data.size()}, 2, std::endian::big), 0x1234);
}

Request any_request(Random& random) {
  const auto byte = [&](std::uint64_t most) {
    return static_cast<std::uint8_t>(random.integer(0, static_cast<std::int64_t>(most)));
  };
  const auto data = [&](std::size_t most) {
    Data bytes;
    const std::size_t count = static_cast<std::size_t>(random.integer(1, most));
    for (std::size_t i = 0; i < count; ++i) bytes.push_back(byte(255));
    return bytes;
  };
  switch (random.integer(0, 6)) {
    case 0:
      return Ping{byte(254)};
    case 1:
      return Read{byte(254), byte(255), byte(255)};
    case 2:
      return Write{byte(254), byte(255), data(kDataMax), random.chance(0.5)};
    case 3:
      return Action{byte(254)};
    case 4:
      return SetMiddle{byte(254)};
    case 5: {
      SyncRead read{byte(255), byte(255), {}};
      const auto count = static_cast<std::size_t>(random.integer(1, kServosMax));
      for (std::size_t i = 0; i < count; ++i) {
        read.ids.push_back(byte(253));
      }
      return read;
    }
    default: {
      SyncWrite write{byte(255), {}};
      const Data first = data(10);
      const std::size_t parts = static_cast<std::size_t>(random.integer(1, kServosMax));
      for (std::size_t i = 0; i < parts; ++i) {
        SyncWrite::Part part{byte(253), first};
        for (std::uint8_t& one : part.data) one = byte(255);
        write.parts.push_back(part);
      }
      return write;
    }
  }
}

TEST(FeetechWire, any_request_is_heard_behind_noise) {
  for_random_cases(20'000, [](Random& random) {
    const Request request = any_request(random);
    PacketDecoder decoder;
    const auto noise = random.integer(0, 19);
    for (std::int64_t i = 0; i < noise; ++i) {
      // No header, or nothing tells where the noise ends.
      decoder.push(static_cast<std::uint8_t>(random.integer(0, 254)));
    }
    std::optional<Request> heard;
    for (const std::uint8_t byte : encode(request)) {
      if (decoder.push(byte) == Result::kPacket) heard = decode_request(decoder.packet());
    }
    ASSERT_TRUE(heard);
    ASSERT_TRUE(*heard == request);
  });
}

TEST(FeetechWire, no_single_flipped_bit_passes) {
  const Bytes whole = encode(Write{3, 42, {0, 8, 0, 0, 0xE8, 3}, false});
  for (std::size_t bit = 0; bit < 8 * whole.size(); ++bit) {
    Bytes damaged = whole;
    damaged[bit / 8] ^= static_cast<std::uint8_t>(1U << (bit % 8));
    EXPECT_FALSE(only_packet(damaged)) << bit;
  }
}

TEST(FeetechWire, a_packet_behind_a_damaged_one_is_heard) {
  Bytes damaged = encode(Read{1, 56, 2});
  damaged[4] ^= 1;
  PacketDecoder decoder;
  int packets = 0;
  for (const Bytes& bytes : {damaged, encode(Read{2, 56, 2}), encode(Read{3, 56, 2})}) {
    for (const std::uint8_t byte : bytes) packets += decoder.push(byte) == Result::kPacket ? 1 : 0;
  }
  EXPECT_EQ(packets, 2);
}

TEST(FeetechWire, what_fits_no_table_is_no_request) {
  EXPECT_FALSE(decode_request({1, 2, {56}})) << "a read without a count";
  EXPECT_FALSE(decode_request({1, 3, {56}})) << "a write of nothing";
  EXPECT_FALSE(decode_request({0xFE, 0x82, {56, 2}})) << "of no servo";
  EXPECT_FALSE(decode_request({0xFE, 0x83, {42, 2, 1, 0}})) << "cut short";
  EXPECT_FALSE(decode_request({0xFE, 0x83, {42, 0, 1, 2}})) << "no bytes each";
  EXPECT_FALSE(decode_request({1, 99, {}}));
  EXPECT_FALSE(decode_reply({0xFE, 0, {}})) << "no servo has this number";
}

}  // namespace
}  // namespace sinew::test
