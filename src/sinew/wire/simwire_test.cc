#include "sinew/wire/simwire.h"

#include <gtest/gtest.h>

#include <memory>

#include "support/golden.h"
#include "support/property.h"

namespace sinew::simwire {
namespace {

using test::Random;

std::string hex_of(const Bytes& bytes) {
  std::string text;
  char digits[3];
  for (const std::uint8_t byte : bytes) {
    std::snprintf(digits, sizeof digits, "%02x", byte);
    text += digits;
  }
  return text;
}

std::string words_of(const BusSettings& settings) {
  return std::to_string(settings.bus) + " " + std::to_string(settings.device) + " " +
         std::to_string(settings.clock_hz) + " " + std::to_string(settings.mode);
}

/// The request in the words of the golden file, made from the struct alone.
std::string spelled(const Request& request) {
  const std::string time = std::to_string(request.time_us) + " ";
  const auto& action = request.action;
  if (const auto* hello = std::get_if<Hello>(&action)) {
    return time + "hello " + std::to_string(hello->version);
  }
  if (const auto* direction = std::get_if<Direction>(&action)) {
    constexpr const char* kPulls[] = {" up", " down", " off"};
    return time + "dir " + std::to_string(direction->pin) + (direction->output ? " out" : " in") +
           kPulls[static_cast<int>(direction->pull)];
  }
  if (const auto* set = std::get_if<SetPin>(&action)) {
    return time + "set " + std::to_string(set->pin) + (set->high ? " 1" : " 0");
  }
  if (const auto* get = std::get_if<GetPin>(&action)) {
    return time + "get " + std::to_string(get->pin);
  }
  if (const auto* open = std::get_if<Open>(&action)) {
    return time + "open " + words_of(open->settings);
  }
  if (const auto* exchange = std::get_if<Exchange>(&action)) {
    return time + "xfer " + words_of(exchange->settings) + " " + hex_of(exchange->mosi);
  }
  if (const auto* close = std::get_if<Close>(&action)) {
    return time + "close " + std::to_string(close->bus) + " " + std::to_string(close->device);
  }
  if (std::holds_alternative<Statistics>(action)) return time + "stat";
  if (std::holds_alternative<Dump>(action)) return time + "dump";
  if (const auto* poke = std::get_if<Poke>(&action)) {
    return time + "poke " + std::to_string(poke->reg) + " " + hex_of(poke->value);
  }
  if (const auto* fault = std::get_if<Fault>(&action)) {
    return time + "fault " + std::string(view(fault->text));
  }
  return time + "bye";
}

std::string spelled(const Reply& reply) {
  if (const auto* ok = std::get_if<Ok>(&reply)) {
    return ok->text.empty() ? "ok" : "ok " + std::string(view(ok->text));
  }
  if (const auto* level = std::get_if<Level>(&reply)) return level->high ? "level 1" : "level 0";
  if (const auto* miso = std::get_if<Miso>(&reply)) return "miso " + hex_of(miso->bytes);
  if (const auto* report = std::get_if<Report>(&reply)) {
    return (report->dump ? "dump " : "stat ") + std::string(view(report->text));
  }
  return "err " + std::string(view(std::get<Refused>(reply).text));
}

TEST(Simwire, every_golden_line_is_read_and_written_back) {
  for (const test::Golden& golden : test::read_goldens("simwire.txt")) {
    if (golden.from_host()) {
      const auto request = decode_request(golden.bytes);
      ASSERT_EQ(request.has_value(), golden.meaning != "bad") << golden.where;
      if (!request) continue;
      EXPECT_EQ(spelled(*request), golden.meaning) << golden.where;
      EXPECT_EQ(view(encode_request(*request)), golden.bytes) << golden.where;
    } else {
      const auto reply = decode_reply(golden.bytes);
      ASSERT_TRUE(reply) << golden.where;
      EXPECT_EQ(spelled(*reply), golden.meaning) << golden.where;
      EXPECT_EQ(view(encode_reply(*reply)), golden.bytes) << golden.where;
    }
  }
}

TEST(Simwire, what_is_wrong_is_said_in_words) {
  EXPECT_EQ(decode_request("x STAT").error(), "a request begins with its time in microseconds");
  EXPECT_EQ(decode_request("1 SET 5").error(), "write SET <pin> 0|1");
  EXPECT_EQ(decode_request("1 XFER 0 0 1 0 0g").error(),
            "write XFER <bus> <dev> <hz> <mode> <mosi as lower-case hex>");
  EXPECT_TRUE(decode_request("1 JUMP").error().starts_with("unknown request; known are HELLO"));
  EXPECT_EQ(decode_request("1  STAT").error().substr(0, 15), "unknown request");
  EXPECT_EQ(decode_request("1 STAT ").error(), "one space between words");
}

TEST(Simwire, random_transfers_come_back_as_they_were_sent) {
  test::for_random_cases(20'000, [](Random& random) {
    auto exchange = std::make_unique<Exchange>();
    exchange->settings = {static_cast<std::uint32_t>(random.integer(0, 9)),
                          static_cast<std::uint32_t>(random.integer(0, 9)),
                          static_cast<std::uint32_t>(random.integer(0, 50'000'000)),
                          static_cast<std::uint32_t>(random.integer(0, 3))};
    for (auto size = random.integer(1, random.chance(0.01) ? 4096 : 40); size > 0; --size) {
      exchange->mosi.push_back(static_cast<std::uint8_t>(random.integer(0, 255)));
    }
    const Request request{random.bits() >> 10, *exchange};
    const Line line = encode_request(request);
    const auto back = decode_request(view(line));
    ASSERT_TRUE(back);
    EXPECT_EQ(*back, request);
    const auto reply = decode_reply(view(encode_reply(Miso{exchange->mosi})));
    ASSERT_TRUE(reply);
    EXPECT_EQ(std::get<Miso>(*reply).bytes, exchange->mosi);
  });
}

TEST(LineReader, endless_line_is_dropped_and_told_and_the_next_one_is_read) {
  auto reader = std::make_unique<LineReader>();
  for (std::size_t i = 0; i < kLineMax + 1000; ++i) {
    ASSERT_EQ(reader->push('a'), LineReader::Result::kMore);
  }
  EXPECT_EQ(reader->push('\n'), LineReader::Result::kTooLong);
  for (const char c : std::string_view("1 STAT"))
    EXPECT_EQ(reader->push(c), LineReader::Result::kMore);
  EXPECT_EQ(reader->push('\n'), LineReader::Result::kLine);
  EXPECT_EQ(reader->line(), "1 STAT");
}

}  // namespace
}  // namespace sinew::simwire
