#include <gtest/gtest.h>

#include <utility>
#include <vector>

#include "sinew/devices/lsc/lsc_device.h"
#include "sinew/devices/lsc/lsc_settings.h"

namespace sinew {
namespace {

using namespace lsc;
using namespace std::chrono_literals;

/// A bus board and what it said. Its servos are where the test puts them.
struct Bench {
  void tell(const Request& request) {
    board.receive(encode(request), now);
    std::array<std::uint8_t, 64> piece{};
    while (const std::size_t count = board.take_output(piece)) {
      for (std::size_t i = 0; i < count; ++i) {
        if (const auto frame = decoder.push(piece[i])) replies.push_back(*decode_reply(*frame));
      }
    }
  }
  void wait(Duration duration) {
    now += duration;
    board.advance(now);
  }
  std::vector<Reply> said() { return std::exchange(replies, {}); }

  LscBoard board{LscProfile::kBus, Instant{}};
  Instant now{};
  FrameDecoder decoder;
  std::vector<Reply> replies;
};

/// Positions 100..900, 5 to 10 V, 70 C, LED off, warnings for heat only.
const Parameters kWrite{3, 100, 0, 0x84, 3, 0x88, 0x13, 0x10, 0x27, 70, 0, 1, 1};

TEST(LscBusServos, the_answer_to_28_is_id_limits_and_what_the_servo_senses) {
  Bench bench;
  bench.board.sense_supply(7.5);
  bench.board.sense_position(1, 321.4);
  bench.tell(AdjustBusOffset{1, -10, true});
  bench.board.sense_position(1, 311.4);
  bench.tell(ReadBusInfo{});
  const auto said = bench.said();
  ASSERT_EQ(said.size(), 1U);
  // id 1, 0..1000, 4500..12000 mV, 85 C, LED lit, three warnings; -10, 321, 30 C, 7500 mV.
  EXPECT_EQ(std::get<BusInfo>(said[0]).parameters,
            (Parameters{1, 0, 0, 0xE8, 3, 0x94, 0x11, 0xE0, 0x2E, 85, 0, 0, 7, 0xF6, 0x41, 1, 30,
                        0x4C, 0x1D}));
}

TEST(LscBusServos, writing_27_is_silent_and_reaches_every_servo_that_is_attached) {
  Bench bench;
  bench.tell(WriteBusInfo{kWrite});
  EXPECT_TRUE(bench.said().empty());
  EXPECT_EQ(bench.board.beeps(), 0U);
  for (std::uint8_t id = 1; id <= LscBoard::kServos; ++id) {
    EXPECT_EQ(bench.board.limits(id), (BusServoLimits{100, 900, 5000, 10'000, 70, 1, 1}));
  }
  bench.tell(Move{100, {{6, 1000}, {5, 20}}});
  bench.wait(1s);
  EXPECT_EQ(bench.board.commanded(6), 900);
  EXPECT_EQ(bench.board.commanded(5), 100);
  bench.board.power_cycle(bench.now);
  EXPECT_EQ(bench.board.limits(2).position_max, 900) << "kept in the servo";
}

TEST(LscBusServos, limits_that_are_none_are_refused_with_a_beep) {
  for (const std::size_t wrong : {0U, 2U, 4U}) {
    Bench bench;
    Parameters bytes = kWrite;
    bytes[wrong] = 0xEE;  // no such servo; a minimum above its maximum; a maximum above 1000
    bench.tell(WriteBusInfo{bytes});
    EXPECT_EQ(bench.board.beeps(), 1U) << wrong;
    EXPECT_EQ(bench.board.limits(3), BusServoLimits{}) << wrong;
  }
  Bench bench;
  bench.tell(WriteBusInfo{Parameters{3, 100}});
  EXPECT_EQ(bench.board.beeps(), 1U);
}

TEST(LscBusServos, motor_mode_turns_on_and_on_and_follows_no_move_until_it_is_a_servo_again) {
  Bench bench;
  bench.board.sense_position(2, 400);
  bench.tell(SetMode{2, 1, -500});
  EXPECT_TRUE(bench.said().empty()) << "no answer";
  bench.wait(20ms);
  EXPECT_TRUE(bench.board.moving());
  EXPECT_NEAR(bench.board.command(2).units, 400 - 0.5 * 1560 * 0.02, 1e-9);
  bench.wait(10s);
  EXPECT_GT(bench.board.command(2).units, 300) << "pushed on from where it is, not wound up";
  bench.tell(Move{100, {{2, 800}}});
  bench.wait(1s);
  EXPECT_LT(bench.board.command(2).units, 400);
  bench.board.sense_position(2, 380);
  bench.tell(SetMode{2, 0, 0});
  EXPECT_FALSE(bench.board.moving());
  EXPECT_EQ(bench.board.command(2).units, 380) << "it holds where it is";
  bench.tell(Move{100, {{2, 800}}});
  bench.wait(1s);
  EXPECT_EQ(bench.board.command(2).units, 800);
}

TEST(LscBusServos, motor_mode_ends_with_unload_and_without_power) {
  for (const bool power : {false, true}) {
    Bench bench;
    bench.board.sense_position(2, 400);
    bench.tell(SetMode{2, 1, 1000});
    if (power) {
      bench.board.power_cycle(bench.now);
    } else {
      bench.tell(Unload{{2}});
    }
    EXPECT_FALSE(bench.board.command(2).driven);
    bench.tell(Move{100, {{2, 600}}});
    bench.wait(1s);
    EXPECT_EQ(bench.board.command(2).units, 600);
  }
}

TEST(LscBusServos, a_mode_that_is_none_is_refused_with_a_beep) {
  for (const SetMode& wrong :
       {SetMode{0, 1, 10}, SetMode{7, 1, 10}, SetMode{1, 2, 10}, SetMode{1, 1, 1001}}) {
    Bench bench;
    bench.tell(wrong);
    EXPECT_EQ(bench.board.beeps(), 1U);
    EXPECT_FALSE(bench.board.command(1).driven);
  }
}

}  // namespace
}  // namespace sinew
