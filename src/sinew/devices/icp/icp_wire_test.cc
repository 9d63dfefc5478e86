#include "sinew/devices/icp/icp_wire.h"

#include <gtest/gtest.h>

#include <bit>
#include <map>
#include <set>
#include <stdexcept>
#include <vector>

#include "support/allocation_guard.h"
#include "support/golden.h"
#include "support/property.h"

namespace sinew::icp {
namespace {

using Bytes = std::vector<std::uint8_t>;

Request request_of(const std::string& meaning) {
  const auto words = test::words_in(meaning);
  const auto motor = [&] { return static_cast<std::uint8_t>(std::stoi(words.at(1))); };
  if (words[0] == "init") return Init{};
  if (words[0] == "sync") return Sync{};
  if (words[0] == "wake") return Wake{};
  if (words[0] == "kill") return Kill{};
  if (words[0] == "request") return StatusRequest{};
  if (words[0] == "step") return Step{motor(), words.at(2) == "1"};
  if (words[0] == "select") return Select{motor()};
  throw std::runtime_error("no such request: " + meaning);
}

Status status_of(const std::vector<std::string>& words) {
  Status status;
  status.one.address = static_cast<std::uint8_t>(std::stoi(words.at(1), nullptr, 16));
  status.two.address = status.one.address;
  status.one.parameters = kMotorParameters;
  status.one.flags.step_loss = words.at(2) == "step-loss";
  status.one.flags.vdd_reset = words.at(2) == "vdd-reset";
  if (status.one.flags.vdd_reset) status.one.parameters = {};
  if (status.one.flags.step_loss) status.one.motion = tmc222::Motion::kNotAtTarget;
  status.two.actual = static_cast<std::int16_t>(std::stoi(words.at(3)));
  status.two.target = static_cast<std::int16_t>(std::stoi(words.at(4)));
  return status;
}

Reply reply_of(const std::string& meaning) {
  const auto words = test::words_in(meaning);
  if (words[0] == "ack") return Ack{};
  if (words[0] == "error") {
    return Refused{words.at(1) == "parity" ? Refusal::kParity : Refusal::kOnes};
  }
  if (words[0] == "status") return status_of(words);
  throw std::runtime_error("no such reply: " + meaning);
}

/// A decoder in the place where a request of this kind is read.
RequestDecoder decoder_before(const Request& request) {
  RequestDecoder decoder;
  if (std::holds_alternative<Init>(request)) return decoder;
  decoder.push(kInit);
  if (std::holds_alternative<Select>(request)) decoder.push(kRequest);
  return decoder;
}

TEST(Icp, every_golden_request_is_read_and_written) {
  int count = 0;
  for (const auto& golden : test::read_goldens("icp.txt")) {
    if (!golden.from_host()) continue;
    ++count;
    const Request meaning = request_of(golden.meaning);
    const std::uint8_t byte = test::from_hex(golden.bytes).at(0);
    EXPECT_EQ(encode_request(meaning), byte) << golden.where;
    const auto read = decoder_before(meaning).push(byte);
    ASSERT_TRUE(read && *read) << golden.where;
    EXPECT_EQ(**read, meaning) << golden.where;
  }
  EXPECT_EQ(count, 23);
}

TEST(Icp, every_golden_refusal_is_given) {
  const std::map<std::string, Refusal> whys{
      {"11", Refusal::kOnes}, {"22", Refusal::kParity}, {"no-motor", Refusal::kNoMotor}};
  int count = 0;
  for (const auto& golden : test::read_goldens("icp.txt")) {
    if (golden.who != "refused") continue;
    ++count;
    RequestDecoder decoder;
    decoder.push(kInit);
    const auto read = decoder.push(test::from_hex(golden.bytes).at(0));
    ASSERT_TRUE(read && !*read) << golden.where;
    EXPECT_EQ(read->error(), whys.at(golden.meaning)) << golden.where;
  }
  EXPECT_EQ(count, 7);
}

TEST(Icp, every_golden_reply_is_read_and_written) {
  int count = 0;
  for (const auto& golden : test::read_goldens("icp.txt")) {
    if (golden.who != "device") continue;
    ++count;
    const Bytes bytes = test::from_hex(golden.bytes);
    const Reply meaning = reply_of(golden.meaning);
    const ReplyBytes written = encode_reply(meaning);
    EXPECT_EQ(Bytes(written.begin(), written.end()), bytes) << golden.where;
    ReplyDecoder decoder;
    using Due = ReplyDecoder::Due;
    decoder.expect(bytes.size() == 1 ? Due::kByte : Due::kBlock);
    for (std::size_t i = 0; i < bytes.size(); ++i) {
      const auto read = decoder.push(bytes[i]);
      ASSERT_EQ(read.has_value(), i + 1 == bytes.size()) << golden.where;
      if (read) {
        EXPECT_EQ(read->value(), meaning) << golden.where;
      }
    }
    EXPECT_EQ(decoder.due(), Due::kNothing);
  }
  EXPECT_EQ(count, 8);
}

TEST(Icp, census_of_all_256_bytes_in_the_commands_place) {
  std::map<std::string, int> census;
  int ones_and_parity = 0;
  for (int value = 0; value < 256; ++value) {
    const auto byte = static_cast<std::uint8_t>(value);
    RequestDecoder decoder(Dialect{.knows_wake = false});
    decoder.push(kInit);
    const auto read = decoder.push(byte);
    ASSERT_TRUE(read);
    if (*read) {
      ++census[std::holds_alternative<Step>(**read) ? "step" : "command"];
    } else if (read->error() == Refusal::kOnes) {
      ++census["11"];
      ones_and_parity += std::popcount(static_cast<unsigned>(value)) % 2;
    } else {
      ++census[read->error() == Refusal::kParity ? "22" : "no motor"];
    }
  }
  EXPECT_EQ(census, (std::map<std::string, int>{
                        {"step", 12}, {"no motor", 4}, {"22", 16}, {"11", 221}, {"command", 3}}));
  EXPECT_EQ(ones_and_parity, 110);
}

std::set<std::uint8_t> all_steps() {
  std::set<std::uint8_t> steps;
  for (std::uint8_t motor = 1; motor <= kMotors; ++motor) {
    for (const bool direction : {false, true}) steps.insert(encode_step({motor, direction}));
  }
  return steps;
}

/// What `byte` does in the command's place.
std::string effect(std::uint8_t byte) {
  RequestDecoder decoder(Dialect{.knows_wake = false});
  decoder.push(kInit);
  const auto read = decoder.push(byte);
  if (!*read) {
    if (read->error() == Refusal::kNoMotor) return "no motor";
    return read->error() == Refusal::kOnes ? "11" : "22";
  }
  if (std::holds_alternative<Step>(**read)) return "step";
  if (std::holds_alternative<Sync>(**read)) return "sync";
  return std::holds_alternative<Kill>(**read) ? "kill" : "request";
}

TEST(Icp, flipped_bits_of_a_step_do_what_is_known_of_them) {
  std::array<std::map<std::string, int>, 4> effects;
  for (const std::uint8_t step : all_steps()) {
    for (unsigned mask = 1; mask < 256; ++mask) {
      const int flips = std::popcount(mask);
      if (flips > 3) continue;
      ++effects.at(static_cast<std::size_t>(flips))[effect(static_cast<std::uint8_t>(step ^ mask))];
    }
  }
  EXPECT_EQ(effects[1], (std::map<std::string, int>{{"11", 81}, {"22", 12}, {"sync", 3}}));
  EXPECT_EQ(effects[2]["step"], 54);
  EXPECT_EQ(effects[2]["no motor"], 12);
  EXPECT_EQ(effects[3]["kill"], 6);
}

TEST(Icp, no_single_flip_makes_a_step_of_what_the_host_sends_beside_steps) {
  const auto steps = all_steps();
  for (const std::uint8_t byte : Bytes{kInit, kWake, kKill, kRequest, 1, 2, 3, 4, 5, 6}) {
    for (unsigned bit = 0; bit < 8; ++bit) {
      const auto flipped = static_cast<std::uint8_t>(byte ^ 1U << bit);
      // 01, 02 and 04 are one bit from 11, 12 and 14: a selector leaves only behind F0's ACK, when
      // no byte is a step.
      if (byte >= 1 && byte <= 6) continue;
      EXPECT_EQ(steps.count(flipped), 0U) << int{byte} << " bit " << bit;
    }
  }
  // The sync byte is the one that may not be sent where a step is read.
  int strays = 0;
  for (unsigned bit = 0; bit < 8; ++bit) {
    strays += static_cast<int>(steps.count(static_cast<std::uint8_t>(kSync ^ 1U << bit)));
  }
  EXPECT_EQ(strays, 3);
}

TEST(Icp, sync_leaves_every_place_and_kill_leaves_none) {
  using State = RequestDecoder::State;
  RequestDecoder decoder;
  EXPECT_FALSE(decoder.push(kSync)) << "the loop ignores it";
  decoder.push(kInit);
  EXPECT_EQ(decoder.push(kSync)->value(), Request{Sync{}});
  EXPECT_EQ(decoder.state(), State::kLoop);
  decoder.push(kInit);
  decoder.push(kRequest);
  EXPECT_EQ(decoder.state(), State::kSelector);
  EXPECT_EQ(decoder.push(kSync)->value(), Request{Sync{}});
  EXPECT_EQ(decoder.state(), State::kLoop);
  decoder.push(kInit);
  decoder.push(kKill);
  for (int byte = 0; byte < 256; ++byte) {
    EXPECT_FALSE(decoder.push(static_cast<std::uint8_t>(byte)));
  }
  EXPECT_EQ(decoder.state(), State::kDead);
}

TEST(Icp, selector_is_read_by_its_three_lowest_bits_or_checked_in_full) {
  for (int value = 0; value < 256; ++value) {
    const auto byte = static_cast<std::uint8_t>(value);
    if (byte == kSync) continue;
    RequestDecoder lax;
    RequestDecoder strict(Dialect{.checks_selector = true});
    for (RequestDecoder* decoder : {&lax, &strict}) {
      decoder->push(kInit);
      decoder->push(kRequest);
    }
    const auto read = *lax.push(byte);
    EXPECT_EQ(read.has_value(), (byte & 7) != 0 && (byte & 7) != 7);
    if (read) {
      EXPECT_EQ(*read, (Request{Select{static_cast<std::uint8_t>(byte & 7)}}));
    }
    EXPECT_EQ(strict.push(byte)->has_value(), all_steps().count(byte) == 1);
  }
}

TEST(Icp, wake_is_a_refused_byte_for_the_other_firmware) {
  RequestDecoder decoder(Dialect{.knows_wake = false});
  decoder.push(kInit);
  EXPECT_EQ(decoder.push(kWake)->error(), Refusal::kOnes);
}

TEST(Icp, reply_that_was_not_asked_for_is_garbage) {
  ReplyDecoder decoder;
  EXPECT_EQ(decoder.push(kAck)->error(), (Garbage{kAck}));
  decoder.expect(ReplyDecoder::Due::kByte);
  EXPECT_EQ(decoder.push(0x01)->error(), (Garbage{0x01}));
  EXPECT_EQ(decoder.push(kAck)->error(), (Garbage{kAck})) << "garbage ends what was due";
}

TEST(Icp, status_block_that_is_off_by_one_byte_is_garbage) {
  const ReplyBytes status = encode_reply(Status{.one = {.parameters = kMotorParameters}});
  ReplyDecoder decoder;
  decoder.expect(ReplyDecoder::Due::kBlock);
  EXPECT_FALSE(decoder.push(kAck)) << "a stale ACK";
  for (std::size_t i = 0; i + 2 < status.size(); ++i) EXPECT_FALSE(decoder.push(status[i]));
  const auto last = decoder.push(status[status.size() - 2]);
  ASSERT_TRUE(last);
  EXPECT_FALSE(*last);
}

TEST(Icp, any_status_comes_back_through_its_twelve_bytes) {
  test::for_random_cases(20'000, [](test::Random& random) {
    StatusBytes bytes{};
    for (auto& byte : bytes) byte = static_cast<std::uint8_t>(random.bits());
    const auto read = decode_status(bytes);
    const bool fixed =
        (bytes[0] & 0xE0) == 0xE0 && (bytes[5] & 2) != 0 && (bytes[11] & 0xF8) == 0xF8;
    ASSERT_EQ(read.has_value(), fixed);
    bytes[0] |= 0xE0;
    bytes[5] |= 2;
    bytes[11] |= 0xF8;
    const auto again = decode_status(bytes);
    ASSERT_TRUE(again);
    EXPECT_EQ(encode_status(*again), bytes);
  });
}

TEST(Icp, no_allocation) {
  const test::AllocationCounter allocations;
  RequestDecoder decoder;
  ReplyDecoder replies;
  for (int byte = 0; byte < 256; ++byte) {
    (void)decoder.push(static_cast<std::uint8_t>(byte));
    replies.expect(ReplyDecoder::Due::kBlock);
    (void)replies.push(static_cast<std::uint8_t>(byte));
  }
  EXPECT_EQ(allocations.count(), 0U);
}

}  // namespace
}  // namespace sinew::icp
