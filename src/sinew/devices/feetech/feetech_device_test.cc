#include "sinew/devices/feetech/feetech_device.h"

#include <gtest/gtest.h>

#include <vector>

#include "support/property.h"

namespace sinew::sim {
namespace {

using namespace std::chrono_literals;
using namespace feetech;

class Bench {
 public:
  explicit Bench(FeetechSeries series = FeetechSeries::kSts) : bus(series, ids_, now) {
    for (std::size_t i = 0; i < 2; ++i) sense(i, 2000);
  }

  std::vector<Reply> ask(const Request& request) {
    const Bytes bytes = encode(request);
    bus.receive({bytes.data(), bytes.size()}, now);
    std::uint8_t out[256];
    std::vector<Reply> replies;
    PacketDecoder decoder;
    while (const std::size_t count = bus.take_output(out)) {
      for (std::size_t i = 0; i < count; ++i) {
        if (decoder.push(out[i]) != PacketDecoder::Result::kPacket) continue;
        replies.push_back(decode_reply(decoder.packet()).value());
      }
    }
    return replies;
  }
  std::uint8_t byte(std::uint8_t id, std::uint8_t address) {
    return ask(Read{id, address, 1}).at(0).data[0];
  }
  int word(std::uint8_t id, std::uint8_t address, int sign = 15) {
    const Data data = ask(Read{id, address, 2}).at(0).data;
    return signed_word(word_at({data.data(), data.size()}, 0, std::endian::little), sign);
  }
  void sense(std::size_t i, double units, double volts = 7.4, double heat = 30) {
    bus.servo(i).sense({.units = units, .volts = volts, .heat = heat});
  }
  void run_for(Duration time) {
    const Instant end = now + time;
    while (now < end) {
      now += 1ms;
      for (std::size_t i = 0; i < 2; ++i) bus.servo(i).advance(now);
    }
  }

  Instant now{};
  FeetechBusDevice bus;

 private:
  static constexpr std::uint8_t ids_[] = {1, 2};
};

TEST(FeetechServos, reply_to_what_is_for_them_and_to_nothing_else) {
  Bench bench;
  EXPECT_EQ(bench.ask(Ping{1}).size(), 1U);
  EXPECT_EQ(bench.ask(Ping{3}).size(), 0U);
  EXPECT_EQ(bench.ask(Ping{kBroadcast}).size(), 2U);
  EXPECT_EQ(bench.ask(Write{1, Register::kGoal, {0, 8}, false}).size(), 1U);
  EXPECT_EQ(bench.ask(Write{kBroadcast, Register::kGoal, {0, 8}, false}).size(), 0U);
  EXPECT_EQ(bench.ask(Read{1, 60, 20}).size(), 0U) << "beyond its registers";
  EXPECT_EQ(bench.word(1, Register::kModel), 777);
  const auto both = bench.ask(SyncRead{Register::kPosition, 2, {2, 1}});
  ASSERT_EQ(both.size(), 2U);
  EXPECT_EQ(both[0].id, 2) << "in the order that was asked for";
  bench.bus.plug(1, false);
  EXPECT_EQ(bench.ask(SyncRead{Register::kPosition, 2, {2, 1}}).size(), 0U);
  EXPECT_EQ(bench.ask(SyncRead{Register::kPosition, 2, {1, 2}}).size(), 1U);
}

TEST(FeetechServos, a_damaged_packet_has_no_reply) {
  Bench bench;
  Bytes bytes = encode(Ping{1});
  bytes[5] ^= 1;
  bench.bus.receive({bytes.data(), bytes.size()}, bench.now);
  std::uint8_t out[16];
  EXPECT_EQ(bench.bus.take_output(out), 0U);
}

TEST(FeetechServos, go_to_a_goal_no_faster_than_they_are_told_and_inside_their_limits) {
  Bench bench;
  bench.bus.servo(0).set_word(Register::kHighest, 3000);
  Data data{0};
  for (const int word : {3500, 0, 500}) {
    put_word(data, static_cast<std::uint16_t>(word), std::endian::little);
  }
  bench.ask(Write{1, Register::kAcceleration, data, false});
  bench.run_for(500ms);
  EXPECT_NEAR(bench.bus.servo(0).command().units, 2250, 2);
  bench.run_for(5s);
  EXPECT_NEAR(bench.bus.servo(0).command().units, 3000, 1);
  EXPECT_EQ(bench.word(1, Register::kGoal), 3500) << "the register keeps what was written";
}

TEST(FeetechServos, a_write_that_waits_happens_at_the_action) {
  Bench bench;
  bench.ask(Write{1, Register::kGoal, {0, 8}, true});
  EXPECT_EQ(bench.byte(1, Register::kTorque), 0);
  bench.ask(Action{});
  EXPECT_EQ(bench.byte(1, Register::kTorque), 1);
  EXPECT_EQ(bench.word(1, Register::kGoal), 2048);
}

TEST(FeetechServos, settings_outlive_the_power_only_while_the_lock_is_open) {
  Bench bench;
  bench.ask(Write{1, Register::kId, {7}, false});
  EXPECT_EQ(bench.ask(Ping{7}).size(), 1U);
  bench.ask(Write{7, Register::kLockSts, {1}, false});
  bench.ask(Write{7, Register::kHighest, {0, 8}, false});
  EXPECT_EQ(bench.word(7, Register::kHighest), 2048);
  bench.ask(Write{7, Register::kTorque, {1}, false});
  bench.bus.power_cycle(bench.now);
  EXPECT_EQ(bench.word(7, Register::kHighest), 4095);
  EXPECT_EQ(bench.byte(7, Register::kTorque), 0);
  EXPECT_EQ(bench.word(7, Register::kTorqueLimit), 1000);
}

TEST(FeetechServos, the_middle_can_be_where_they_are) {
  Bench bench;
  bench.sense(0, 1900);
  bench.ask(SetMiddle{1});
  bench.sense(0, 1900);
  EXPECT_EQ(bench.word(1, Register::kPosition), 2048);
  EXPECT_EQ(bench.word(1, Register::kOffset, kOffsetSign), 1900 - 2048);
  bench.ask(Write{2, Register::kTorque, {128}, false});
  bench.sense(1, 2000);
  EXPECT_EQ(bench.word(2, Register::kPosition), 2048);
}

TEST(FeetechServos, an_overload_leaves_a_fifth_of_the_torque_until_the_motor_was_off) {
  Bench bench;
  bench.bus.servo(0).hold();
  bench.bus.servo(0).sense({.units = 2000, .duty = 0.9, .volts = 7.4, .heat = 30});
  bench.run_for(1900ms);
  EXPECT_EQ(bench.bus.servo(0).command().torque, 1);
  bench.run_for(200ms);
  EXPECT_NEAR(bench.bus.servo(0).command().torque, 0.2, 1e-9);
  EXPECT_EQ(bench.ask(Ping{1}).at(0).trouble, Trouble::kOverload);
  bench.bus.servo(0).sense({.units = 2000, .duty = 0.1, .volts = 7.4, .heat = 30});
  bench.ask(Write{1, Register::kTorque, {0}, false});
  bench.ask(Write{1, Register::kTorque, {1}, false});
  bench.run_for(10ms);
  EXPECT_EQ(bench.ask(Ping{1}).at(0).trouble, 0);
  EXPECT_EQ(bench.bus.servo(0).command().torque, 1);
}

TEST(FeetechServos, complain_of_their_supply_and_switch_off_when_they_are_hot) {
  Bench bench;
  bench.bus.servo(0).hold();
  bench.sense(0, 2000, 12);
  bench.run_for(1ms);
  EXPECT_EQ(bench.ask(Ping{1}).at(0).trouble, Trouble::kVoltage);
  EXPECT_EQ(bench.byte(1, Register::kTorque), 1);
  bench.sense(0, 2000, 7.4, 71);
  bench.run_for(1ms);
  EXPECT_EQ(bench.ask(Ping{1}).at(0).trouble, Trouble::kHeat);
  EXPECT_EQ(bench.byte(1, Register::kTorque), 0);
}

TEST(FeetechServos, an_scs_servo_has_its_bytes_the_other_way_round_and_no_common_read) {
  Bench bench(FeetechSeries::kScs);
  EXPECT_EQ(bench.byte(1, 2), 1);
  EXPECT_EQ(bench.ask(SyncRead{Register::kPosition, 2, {1, 2}}).size(), 0U);
  const Data data = bench.ask(Read{1, Register::kHighest, 2}).at(0).data;
  EXPECT_EQ(data, (Data{3, 0xFF}));
}

TEST(FeetechServos, any_bytes_are_survived) {
  test::for_random_cases(300, [](test::Random& random) {
    Bench bench(random.chance(0.5) ? FeetechSeries::kSts : FeetechSeries::kScs);
    for (int i = 0; i < 200; ++i) {
      const auto byte = [&] { return static_cast<std::uint8_t>(random.integer(0, 255)); };
      const auto id = static_cast<std::uint8_t>(random.integer(1, 3));
      Data data;
      const auto count = random.integer(1, 8);
      for (std::int64_t k = 0; k < count; ++k) data.push_back(byte());
      const auto address = static_cast<std::uint8_t>(random.integer(5, 75));
      bench.ask(Write{id, address, data, random.chance(0.2)});
      if (random.chance(0.1)) bench.ask(Action{});
      bench.run_for(5ms);
      const double units = bench.bus.servo(0).command().units;
      ASSERT_TRUE(std::isfinite(units));
      bench.sense(0, std::clamp(units, -100.0, 4200.0));
    }
  });
}

}  // namespace
}  // namespace sinew::sim
