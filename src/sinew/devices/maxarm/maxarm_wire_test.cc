#include "sinew/devices/maxarm/maxarm_wire.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <stdexcept>
#include <string>
#include <vector>

#include "support/allocation_guard.h"
#include "support/golden.h"
#include "support/property.h"

namespace sinew::maxarm {
namespace {

using Bytes = std::vector<std::uint8_t>;

Bytes bytes_of(const FrameBytes& frame) {
  return {frame.begin(), frame.end()};
}

Request request_of(const std::string& meaning) {
  const auto words = test::words_in(meaning);
  const auto number = [&](std::size_t i) { return std::stoi(words.at(i)); };
  const auto u16 = [&](std::size_t i) { return static_cast<std::uint16_t>(number(i)); };
  const auto i16 = [&](std::size_t i) { return static_cast<std::int16_t>(number(i)); };
  if (words[0] == "angle") return SetAngle{{u16(1), u16(2), u16(3)}, u16(4)};
  if (words[0] == "xyz") return SetXyz{{i16(1), i16(2), i16(3)}, u16(4)};
  if (words[0] == "pwm") return SetPwmServo{u16(1), u16(2)};
  if (words[0] == "suction") return SetSuction{static_cast<std::uint8_t>(number(1))};
  if (words[0] == "read-angle") return ReadAngle{};
  if (words[0] == "read-xyz") return ReadXyz{};
  throw std::runtime_error("no such request: " + meaning);
}

ReplyFrame reply_of(const std::string& meaning) {
  const auto words = test::words_in(meaning);
  std::array<std::int16_t, 3> numbers{};
  for (std::size_t i = 0; i < 3; ++i) {
    numbers[i] = static_cast<std::int16_t>(std::stoi(words.at(i + 1)));
  }
  const Reply reply = words[0] == "angles" ? Reply{Angles{numbers}} : Reply{Position{numbers}};
  return {reply, words.at(4) == "spec" ? Checksum::kSpec : Checksum::kWithHeader};
}

template <class Decoder>
auto decode(Decoder& decoder, std::span<const std::uint8_t> bytes) {
  std::vector<typename decltype(decoder.push(0))::value_type> results;
  for (const std::uint8_t byte : bytes) {
    if (const auto result = decoder.push(byte)) results.push_back(*result);
  }
  return results;
}

Request random_request(test::Random& random) {
  const auto u16 = [&] { return static_cast<std::uint16_t>(random.integer(0, 65535)); };
  const auto i16 = [&] { return static_cast<std::int16_t>(random.integer(-32768, 32767)); };
  switch (random.integer(1, 6)) {
    case 1:
      return SetAngle{{u16(), u16(), u16()}, u16()};
    case 2:
      return SetXyz{{i16(), i16(), i16()}, u16()};
    case 3:
      return SetPwmServo{u16(), u16()};
    case 4:
      return SetSuction{static_cast<std::uint8_t>(random.integer(0, 255))};
    case 5:
      return ReadAngle{};
    default:
      return ReadXyz{};
  }
}

ReplyFrame random_reply(test::Random& random) {
  const auto i16 = [&] { return static_cast<std::int16_t>(random.integer(-32768, 32767)); };
  const std::array<std::int16_t, 3> words{i16(), i16(), i16()};
  return {random.chance(0.5) ? Reply{Angles{words}} : Reply{Position{words}},
          random.chance(0.5) ? Checksum::kSpec : Checksum::kWithHeader};
}

TEST(MaxArmWire, every_golden_request_is_read_and_written) {
  int count = 0;
  for (const auto& golden : test::read_goldens("maxarm.txt")) {
    if (golden.who == "device") continue;
    ++count;
    const Bytes bytes = test::from_hex(golden.bytes);
    const Request meaning = request_of(golden.meaning);
    EXPECT_EQ(bytes_of(encode_request(meaning)), bytes) << golden.where;
    RequestDecoder decoder;
    EXPECT_EQ(decode(decoder, bytes), std::vector<Request>{meaning}) << golden.where;
    EXPECT_TRUE(decoder.at_boundary()) << golden.where;
  }
  EXPECT_EQ(count, 35);
}

TEST(MaxArmWire, every_golden_reply_is_read_and_written) {
  int count = 0;
  for (const auto& golden : test::read_goldens("maxarm.txt")) {
    if (golden.who != "device") continue;
    ++count;
    const Bytes bytes = test::from_hex(golden.bytes);
    const ReplyFrame meaning = reply_of(golden.meaning);
    EXPECT_EQ(bytes_of(encode_reply(meaning.reply, meaning.checksum)), bytes) << golden.where;
    ReplyDecoder decoder;
    EXPECT_EQ(decode(decoder, bytes), std::vector<ReplyFrame>{meaning}) << golden.where;
    EXPECT_EQ(decoder.skipped(), 0U) << golden.where;
  }
  EXPECT_EQ(count, 22);
}

TEST(MaxArmWire, a_doubled_head_loses_a_request_and_keeps_a_reply) {
  Bytes request = bytes_of(encode_request(ReadAngle{}));
  request.insert(request.begin(), 0xAA);
  RequestDecoder device;
  EXPECT_TRUE(decode(device, request).empty());
  Bytes reply = bytes_of(encode_reply(Angles{{1, 2, 3}}, Checksum::kSpec));
  reply.insert(reply.begin(), 0xAA);
  ReplyDecoder host;
  EXPECT_EQ(decode(host, reply).size(), 1U);
  EXPECT_EQ(host.skipped(), 1U);
}

TEST(MaxArmWire, a_good_reply_that_begins_inside_a_broken_one_is_found) {
  const Bytes good = bytes_of(encode_reply(Angles{{864, 410, 713}}, Checksum::kSpec));
  for (std::size_t cut = 1; cut < good.size(); ++cut) {
    Bytes stream(good.begin(), good.begin() + static_cast<std::ptrdiff_t>(cut));
    stream.insert(stream.end(), good.begin(), good.end());
    ReplyDecoder decoder;
    EXPECT_EQ(decode(decoder, stream).size(), 1U) << cut;
    EXPECT_EQ(decoder.skipped(), cut);
  }
}

TEST(MaxArmWire, repeated_broken_heads_never_grow_the_host_s_buffer) {
  // Six heads with a wrong length, then one with a right one: a byte too many for a fixed array.
  Bytes stream;
  for (int i = 0; i < 6; ++i) {
    for (const int byte : {0xAA, 0x55, 0x11, 0x05})
      stream.push_back(static_cast<std::uint8_t>(byte));
  }
  const Bytes good = bytes_of(encode_reply(Angles{{1, 2, 3}}, Checksum::kWithHeader));
  stream.insert(stream.end(), good.begin(), good.end());
  ReplyDecoder decoder;
  EXPECT_EQ(decode(decoder, stream),
            (std::vector<ReplyFrame>{{Angles{{1, 2, 3}}, Checksum::kWithHeader}}));
}

TEST(MaxArmWire, wrong_function_length_and_sum_are_dropped_without_a_word) {
  for (const Bytes& bad : {Bytes{0xAA, 0x55, 0x15, 0x00, 0xEA}, Bytes{0xAA, 0x55, 0x11, 0x01, 0xED},
                           Bytes{0xAA, 0x55, 0x11, 0x00, 0xEF}, Bytes{0x55, 0x55, 0x11, 0x00}}) {
    RequestDecoder decoder;
    EXPECT_TRUE(decode(decoder, bad).empty());
    while (!decoder.at_boundary()) (void)decoder.push(0);
    EXPECT_EQ(decode(decoder, bytes_of(encode_request(ReadXyz{}))).size(), 1U);
  }
}

TEST(MaxArmWire, a_frame_cut_between_two_looks_deafens_until_sixteen_zeros) {
  const Bytes move = bytes_of(encode_request(SetAngle{{500, 500, 500}, 1000}));
  const Bytes question = bytes_of(encode_request(ReadAngle{}));
  // Cut behind its first data byte, the sum fills it up and only one question is lost.
  for (std::size_t cut = 6; cut < 12; ++cut) {
    RequestDecoder decoder;
    decoder.begin_poll();
    (void)decode(decoder, std::span(move).first(cut));
    decoder.begin_poll();
    EXPECT_TRUE(decode(decoder, std::span(move).subspan(cut)).empty()) << cut;
    for (int i = 0; i < 10; ++i) {
      decoder.begin_poll();
      EXPECT_TRUE(decode(decoder, question).empty()) << "deaf, cut at " << cut;
    }
    // The burst itself may fall into two looks.
    for (std::size_t first = 0; first <= 16; ++first) {
      RequestDecoder other = decoder;
      other.begin_poll();
      EXPECT_TRUE(decode(other, Bytes(first)).empty());
      other.begin_poll();
      EXPECT_TRUE(decode(other, Bytes(16 - first)).empty());
      other.begin_poll();
      EXPECT_EQ(decode(other, question).size(), 1U) << cut << " " << first;
    }
  }
}

/// What a device takes of a damaged frame with a question behind it, beyond the question.
std::vector<Request> taken(Bytes stream) {
  const Bytes question = bytes_of(encode_request(ReadAngle{}));
  for (int i = 0; i < 3; ++i) stream.insert(stream.end(), question.begin(), question.end());
  RequestDecoder decoder;
  std::vector<Request> all = decode(decoder, stream);
  std::erase(all, Request{ReadAngle{}});
  return all;
}

TEST(MaxArmWire, a_sturdy_frame_survives_every_single_fault_and_others_are_told_apart) {
  int sturdy = 0;
  int fragile = 0;
  test::for_random_cases(20'000, [&](test::Random& random) {
    const Request request = random_request(random);
    const FrameBytes frame = encode_request(request);
    const Bytes bytes = bytes_of(frame);
    bool mistaken = false;
    const auto check = [&](const Bytes& damaged) {
      for (const Request& r : taken(damaged)) mistaken = mistaken || !(r == request);
    };
    for (std::size_t i = 0; i < bytes.size(); ++i) {
      Bytes less = bytes;
      less.erase(less.begin() + static_cast<std::ptrdiff_t>(i));
      check(less);
      Bytes more = bytes;
      more.insert(more.begin() + static_cast<std::ptrdiff_t>(i), bytes[i]);
      check(more);
      for (unsigned bit = 0; bit < 8; ++bit) {
        Bytes flipped = bytes;
        flipped[i] = static_cast<std::uint8_t>(flipped[i] ^ 1U << bit);
        check(flipped);
      }
    }
    if (survives_one_fault(frame)) {
      ++sturdy;
      EXPECT_FALSE(mistaken) << "request " << request.index();
    } else {
      fragile += mistaken ? 1 : 0;
    }
  });
  EXPECT_GT(sturdy, 10'000);
  EXPECT_GT(fragile, 100) << "the rule must refuse what is really mistaken";
}

TEST(MaxArmWire, a_look_in_the_middle_of_a_frame_can_make_another_of_it) {
  // The first two data bytes add up to FF: cut behind them, the question's 55 fits as the sum.
  const FrameBytes fragile = encode_request(SetAngle{{510, 500, 500}, 1000});
  EXPECT_FALSE(survives_a_look(fragile));
  RequestDecoder decoder;
  Bytes stream = bytes_of(fragile);
  for (const std::uint8_t byte : encode_request(ReadAngle{})) stream.push_back(byte);
  EXPECT_TRUE(decode(decoder, std::span(stream).first(6)).empty());
  decoder.begin_poll();
  const auto mistaken = decode(decoder, std::span(stream).subspan(6));
  ASSERT_EQ(mistaken.size(), 1U);
  EXPECT_EQ(std::get<SetAngle>(mistaken[0]).pulses, (std::array<std::uint16_t, 3>{500, 500, 1000}));
  EXPECT_TRUE(survives_a_look(encode_request(SetAngle{{511, 500, 500}, 1000})));
}

TEST(MaxArmWire, random_messages_come_back_as_they_were_sent_whatever_the_cut) {
  test::for_random_cases(20'000, [](test::Random& random) {
    const Request request = random_request(random);
    RequestDecoder requests;
    EXPECT_EQ(decode(requests, encode_request(request)), std::vector<Request>{request});
    Bytes stream;
    std::vector<ReplyFrame> sent;
    for (int i = 0; i < 3; ++i) {
      sent.push_back(random_reply(random));
      const auto frame = encode_reply(sent.back().reply, sent.back().checksum);
      stream.insert(stream.end(), frame.begin(), frame.end());
    }
    const auto cut = static_cast<std::size_t>(random.integer(0, 33));
    ReplyDecoder first;
    auto read = decode(first, std::span(stream).first(cut));
    ReplyDecoder second = first;
    for (const auto& frame : decode(second, std::span(stream).subspan(cut))) read.push_back(frame);
    EXPECT_EQ(read, sent);
    EXPECT_EQ(second.skipped(), 0U);
  });
}

TEST(MaxArmWire, encoding_and_decoding_do_not_allocate) {
  RequestDecoder requests;
  ReplyDecoder replies;
  const test::AllocationCounter allocations;
  for (const std::uint8_t byte : encode_request(SetAngle{{1, 2, 3}, 4})) (void)requests.push(byte);
  for (const std::uint8_t byte : encode_reply(Angles{{1, 2, 3}}, Checksum::kSpec)) {
    (void)replies.push(byte);
  }
  EXPECT_EQ(allocations.count(), 0U);
}

}  // namespace
}  // namespace sinew::maxarm
