#include <gtest/gtest.h>

#include <algorithm>
#include <cstdio>
#include <fstream>
#include <iterator>

#include "firmware/emulation_stm8/encoder_board.h"
#include "firmware/emulation_stm8/node_on_host.h"
#include "sinew/wire/board_image.h"

// The image of the encoder node on an emulated STM8S103. Each test holds every answer to what the
// node's program gives on this computer for the same readings.

namespace sinew::emulation {
namespace {

constexpr std::uint64_t kMs = EncoderBoard::kClocksPerMs;
constexpr std::uint64_t kByte = 1390;  // clocks of a byte at 115200 baud
/// uCsim's TIM4 leaves out one count of the prescaler and one of the counter: 63 x 249 clocks are a
/// millisecond of the node here, 64 x 250 on the chip.
constexpr double kShortTick = 63.0 * 249 / (64 * 250);
// What an image may need.
constexpr std::uint64_t kCycleMost = kMs * 6 / 10;
constexpr std::size_t kStackFreeLeast = 512;
constexpr std::uint64_t kAnswerMost = kMs * 3 / 2;
// Bits of STATUS, docs/wires/encoder_link.md.
constexpr int kFresh = 1, kMagnet = 2, kTooWeak = 4, kBusError = 16, kRestarted = 32, kSettled = 64;

/// From a request's last byte until the driver releases the line, and how it held it meanwhile.
struct Answer {
  std::uint64_t asked = 0, driven = 0, first = 0, last = 0, released = 0;
};

std::vector<Answer> answers_in(const std::vector<Event>& events) {
  std::vector<Answer> answers;
  std::uint64_t received = 0;
  bool driving = false;
  for (const Event& event : events) {
    if (event.act == Act::kReceives && !driving) received = event.clock;
    if (event.act == Act::kSends) {
      EXPECT_TRUE(driving) << "a byte on a line that is not driven";
      if (answers.empty()) continue;
      Answer& answer = answers.back();
      if (answer.first == 0) answer.first = event.clock;
      answer.last = event.clock;
    }
    if (event.act != Act::kPortD) continue;
    const bool drives = (event.value & 0x10) != 0;
    if (drives && !driving) answers.push_back({received, event.clock, 0, 0, 0});
    if (!drives && driving) answers.back().released = event.clock;
    driving = drives;
  }
  return answers;
}

/// Clocks from the start of each reading until the watchdog is fed behind it.
std::uint64_t longest_cycle(const std::vector<Event>& events) {
  std::uint64_t longest = 0;
  std::uint64_t begun = 0;
  for (const Event& event : events) {
    if (event.act == Act::kBusControl && (event.value & 1) != 0 && begun == 0) begun = event.clock;
    if (event.act != Act::kWatchdogKey || begun == 0) continue;
    longest = std::max(longest, event.clock - begun);
    begun = 0;
  }
  return longest;
}

struct Recoveries {
  int whole = 0;   ///< nine clocks with data released, then a stop
  int broken = 0;  ///< stops behind another number of clocks
};

Recoveries recoveries_in(const std::vector<Event>& events) {
  Recoveries found;
  int clocks = 0;
  std::uint32_t before = 0;
  for (const Event& event : events) {
    if (event.act != Act::kPortB) continue;
    const bool clock = (event.value & 0x10) != 0;
    const bool data = (event.value & 0x20) != 0;
    const bool clock_fell = !clock && (before & 0x10) != 0;
    const bool stop = data && clock && (before & 0x30) == 0x10;
    // The tenth clock is the stop's own.
    if (clock_fell) ++clocks;
    if (stop) ++(clocks == 10 ? found.whole : found.broken);
    if (stop) clocks = 0;
    before = event.value;
  }
  return found;
}

int changes_of_lamp(const std::vector<Event>& events, std::uint64_t since) {
  int changes = 0;
  std::uint32_t before = 8;
  for (const Event& event : events) {
    if (event.act != Act::kPortA) continue;
    if ((event.value & 8) != before && event.clock >= since) ++changes;
    before = event.value & 8;
  }
  return changes;
}

class EncoderImage : public testing::Test {
 protected:
  void TearDown() override {
    EXPECT_EQ(sent_, replies_on_host(board_.events()));
    EXPECT_EQ(board_.bus_faults(), 0U);
    for (const Answer& answer : answers_in(board_.events())) {
      EXPECT_LT(answer.released - answer.asked, kAnswerMost);
    }
  }

  Bytes ask(std::uint8_t name) {
    const Bytes reply = board_.ask(name);
    sent_.insert(sent_.end(), reply.begin(), reply.end());
    return reply;
  }
  /// Of an answer; a failure where it is none.
  int value_of(std::uint8_t name) {
    const Bytes reply = ask(name);
    if (reply.size() != 5) {
      ADD_FAILURE() << "no answer to register " << int{name};
      return -1;
    }
    EXPECT_EQ(reply, (Bytes{0xAA, name, reply[2], reply[3], 0x55}));
    return reply[2] | reply[3] << 8;
  }
  int signed_value_of(std::uint8_t name) { return static_cast<std::int16_t>(value_of(name)); }
  void expect_silence_on_1_to_3() {
    for (const std::uint8_t name : Bytes{1, 2, 3}) EXPECT_TRUE(ask(name).empty()) << int{name};
  }

  EncoderBoard board_;
  Bytes sent_;
};

TEST_F(EncoderImage, carries_its_label) {
  std::ifstream file(encoder_image() + ".bin", std::ios::binary);
  const Bytes bytes{std::istreambuf_iterator<char>(file), {}};
  const auto image = read_image(bytes);
  ASSERT_TRUE(image);
  EXPECT_EQ(image->board_name(), "encoder-stm8s103");
  EXPECT_EQ(image->size, 8192U) << "filled up to the end of the flash";
  EXPECT_EQ(bytes.size(), 8192U);
}

TEST_F(EncoderImage, answers_the_position_of_the_shaft) {
  board_.set_shaft(1450);
  board_.run_ms(5);
  EXPECT_EQ(ask(1), (Bytes{0xAA, 0x01, 0xAA, 0x05, 0x55}));
  EXPECT_TRUE(ask(2).empty()) << "not settled";
  EXPECT_EQ(value_of(4), kFresh | kMagnet | kRestarted);
  EXPECT_EQ(value_of(4), kFresh | kMagnet) << "it was read";
  for (const int position : {0, 1, 0x0AA5, 4095}) {
    board_.set_shaft(position);
    board_.run_ms(2);
    EXPECT_EQ(value_of(1), position);
  }
}

TEST_F(EncoderImage, says_how_fast_the_shaft_turns) {
  board_.set_shaft(4000, 3000);
  board_.run_ms(250);
  EXPECT_NEAR(signed_value_of(2), 3000 * kShortTick, 15);
  EXPECT_NEAR(signed_value_of(3), 0, 700);
  EXPECT_EQ(value_of(4), kFresh | kMagnet | kSettled | kRestarted);
  board_.set_shaft(100, -19342);
  board_.run_ms(150);
  EXPECT_NEAR(signed_value_of(2), -19342 * kShortTick, 40);
  ask(3);
}

TEST_F(EncoderImage, is_silent_without_a_magnet_and_says_why) {
  board_.set_chip_status(0x10);
  board_.run_ms(10);
  expect_silence_on_1_to_3();
  EXPECT_EQ(value_of(4), kTooWeak | kRestarted);
  board_.set_chip_status(EncoderBoard::kMagnet);
  board_.set_shaft(2000);
  board_.run_ms(3);
  EXPECT_EQ(value_of(1), 2000);
  board_.set_chip_status(0);
  board_.run_ms(8);
  expect_silence_on_1_to_3();
  EXPECT_EQ(value_of(4), kRestarted) << "turns may have been lost since";
}

TEST_F(EncoderImage, frees_the_bus_of_a_chip_that_does_not_acknowledge) {
  board_.set_chip_present(false);
  board_.run_ms(8);
  expect_silence_on_1_to_3();
  const int status = value_of(4);
  EXPECT_EQ(status & 0xFF, kBusError | kRestarted);
  const Recoveries recoveries = recoveries_in(board_.events());
  EXPECT_EQ(recoveries.broken, 0);
  // Once at its start, and behind each failure; the last ones came behind the answer.
  EXPECT_GT(status >> 8, 15);
  EXPECT_NEAR(recoveries.whole, 1 + (status >> 8), 4);
  EXPECT_LT(longest_cycle(board_.events()), kCycleMost);
  board_.set_chip_present(true);
  board_.set_shaft(77);
  board_.run_ms(3);
  EXPECT_EQ(value_of(1), 77);
}

TEST_F(EncoderImage, answers_in_time_while_the_bus_is_held) {
  board_.hold_bus(true);
  board_.run_ms(8);
  for (int i = 0; i < 3; ++i) EXPECT_NE(value_of(4) & kBusError, 0);
  const std::uint64_t cycle = longest_cycle(board_.events());
  std::printf("  a reading that fails: %.0f us\n", static_cast<double>(cycle) / 16);
  EXPECT_LT(cycle, kCycleMost);
  board_.hold_bus(false);
  board_.set_shaft(3000);
  board_.run_ms(3);
  EXPECT_EQ(value_of(1), 3000);
}

TEST_F(EncoderImage, coasts_over_readings_that_fail) {
  board_.set_shaft(0, 5000);
  board_.run_ms(200);
  board_.set_chip_present(false);
  EXPECT_NE(value_of(2), 0);
  board_.set_chip_present(true);
  board_.run_ms(20);
  EXPECT_EQ(value_of(4) & (kFresh | kSettled), kFresh | kSettled);
  EXPECT_NEAR(signed_value_of(2), 5000 * kShortTick, 60);
}

TEST_F(EncoderImage, finds_a_request_behind_rubbish) {
  board_.set_shaft(10);
  board_.run_ms(3);
  board_.send({0xAA, 0xAA, 0x01, 0x00, 0x55, 0xAA, 0x55, 0xFF});
  EXPECT_EQ(value_of(1), 10);
  for (const std::uint8_t name : Bytes{0x00, 0x05, 0x55, 0xAA, 0xFF}) {
    EXPECT_TRUE(ask(name).empty()) << int{name};
  }
  // A pause of more than 3 ms ends what was begun.
  board_.send({0xAA, 0x01});
  board_.run_ms(8);
  board_.send({0x55});
  board_.run_ms(3);
  EXPECT_TRUE(board_.take_output().empty());
  EXPECT_EQ(value_of(1), 10);
}

TEST_F(EncoderImage, drives_the_line_while_it_sends_and_no_longer) {
  board_.run_ms(3);
  EXPECT_TRUE(answers_in(board_.events()).empty()) << "off from the start";
  for (int i = 0; i < 4; ++i) value_of(i % 2 == 0 ? 1 : 4);
  const auto answers = answers_in(board_.events());
  ASSERT_EQ(answers.size(), 4U);
  for (const Answer& answer : answers) {
    EXPECT_LE(answer.driven, answer.first);
    EXPECT_LT(answer.first - answer.driven, 2 * kByte);
    EXPECT_GE(answer.last - answer.first, 4 * (kByte - 50));
    EXPECT_LT(answer.last - answer.first, 5 * kByte);
    EXPECT_GE(answer.released - answer.last, kByte - 139) << "before the last stop bit";
    EXPECT_LT(answer.released - answer.last, kByte + 139) << "long behind the last stop bit";
  }
}

TEST_F(EncoderImage, its_lamp_is_lit_while_there_is_a_position) {
  board_.run_ms(300);
  EXPECT_EQ(changes_of_lamp(board_.events(), 0), 1);
  board_.set_chip_status(0);
  board_.run_ms(10);
  const std::uint64_t since = board_.clock();
  board_.run_ms(1000);
  EXPECT_NEAR(changes_of_lamp(board_.events(), since), 4, 1) << "two flashes a second";
}

TEST_F(EncoderImage, its_watchdog_bites_where_the_program_hangs) {
  board_.set_shaft(5);
  board_.run_ms(20);
  // 2 x 16 x 256 periods of 128 kHz: RM0016 14.2.
  EXPECT_EQ(board_.peek(0x50E1), 2U);
  EXPECT_EQ(board_.peek(0x50E2), 0xFFU);
  std::vector<std::uint32_t> keys;
  for (const Event& event : board_.events()) {
    if (event.act == Act::kWatchdogKey) keys.push_back(event.value);
  }
  ASSERT_GT(keys.size(), 20U);
  EXPECT_EQ(keys[0], 0xCCU) << "started";
  EXPECT_EQ(keys[1], 0x55U);
  EXPECT_EQ(value_of(4) & kRestarted, kRestarted);
  board_.hang();
  const std::uint64_t hung = board_.clock();
  board_.run_ms(70);
  const auto bite = std::ranges::find(board_.events(), Act::kBite, &Event::act);
  ASSERT_NE(bite, board_.events().end());
  EXPECT_LT(bite->clock - hung, 66 * kMs);
  board_.reset();
  sent_.clear();
  EXPECT_EQ(board_.peek(0x500F) & 0x10, 0U) << "the line is released";
  board_.run_ms(5);
  EXPECT_EQ(value_of(1), 5);
  EXPECT_EQ(value_of(4) & kRestarted, kRestarted);
}

TEST_F(EncoderImage, needs_little_of_its_time_and_of_its_memory) {
  board_.set_shaft(4000, 30000);
  board_.run_ms(160);
  for (int i = 0; i < 2; ++i) {
    for (const std::uint8_t name : Bytes{1, 2, 3, 4}) value_of(name);
  }
  board_.set_chip_present(false);
  board_.run_ms(5);
  value_of(4);
  std::uint64_t slowest = 0;
  std::uint64_t soonest = kMs;
  for (const Answer& answer : answers_in(board_.events())) {
    slowest = std::max(slowest, answer.released - answer.asked);
    soonest = std::min(soonest, answer.driven - answer.asked);
  }
  const std::uint64_t cycle = longest_cycle(board_.events());
  const std::size_t unused = board_.untouched_ram();
  std::printf(
      "  longest reading with its filter: %.0f us; answers within %.0f us, the line driven "
      "%.0f us or more behind the request; RAM never used: %zu bytes\n",
      static_cast<double>(cycle) / 16, static_cast<double>(slowest) / 16,
      static_cast<double>(soonest) / 16, unused);
  EXPECT_LT(cycle, kCycleMost);
  EXPECT_GE(unused, kStackFreeLeast);
}

}  // namespace
}  // namespace sinew::emulation
