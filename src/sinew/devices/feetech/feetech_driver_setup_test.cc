#include "sinew/devices/feetech/feetech_driver_setup.h"

#include <gtest/gtest.h>

#include "sinew/devices/feetech/feetech_device.h"

namespace sinew {
namespace {

using namespace feetech;

/// Simulated servos that reply at once.
class Line : public FeetechLine {
 public:
  Line(FeetechSeries series, std::initializer_list<std::uint8_t> ids)
      : bus_(series, {ids.begin(), ids.size()}, Instant{}) {
    for (std::size_t i = 0; i < ids.size(); ++i) sense(i, 1500 + 10.0 * static_cast<double>(i));
  }
  std::optional<Reply> ask(const Read& read) override {
    const auto replies = exchange(read);
    garbled_ = replies.size() > 1;
    return replies.size() == 1 ? std::optional(replies[0]) : std::nullopt;
  }
  void write(const Request& request) override {
    exchange(request);
    ++writes;
    for (std::size_t i = 0; i < turned_.size(); ++i) sense(i, turned_[i]);
  }
  bool garbled() const override { return garbled_; }
  void sense(std::size_t i, double units) {
    turned_[i] = units;
    bus_.servo(i).sense({.units = units, .volts = 7.4, .heat = 30});
  }
  sim::FeetechBusDevice& bus() { return bus_; }
  int writes = 0;

 private:
  std::vector<Reply> exchange(const Request& request) {
    const Bytes bytes = encode(request);
    bus_.receive({bytes.data(), bytes.size()}, Instant{});
    std::uint8_t out[512];
    std::vector<Reply> replies;
    PacketDecoder decoder;
    while (const std::size_t count = bus_.take_output(out)) {
      for (std::size_t i = 0; i < count; ++i) {
        if (decoder.push(out[i]) != PacketDecoder::Result::kPacket) continue;
        replies.push_back(decode_reply(decoder.packet()).value());
      }
    }
    return replies;
  }

  sim::FeetechBusDevice bus_;
  std::array<double, 2> turned_{};
  bool garbled_ = false;
};

constexpr auto kGoOn = [](std::uint8_t) { return true; };

TEST(FeetechSetup, lists_who_replies_and_numbers_that_two_have) {
  Line line(FeetechSeries::kSts, {1, 7});
  const FoundServos found = find_servos(line, 20, kGoOn);
  ASSERT_EQ(found.servos.size(), 2U);
  EXPECT_EQ(found.servos[1].id, 7);
  EXPECT_EQ(found.servos[1].model, 777);
  EXPECT_EQ(found.servos[1].position, 1510);
  EXPECT_NEAR(found.servos[0].volts, 7.4, 1e-9);
  EXPECT_EQ(line.writes, 0);
  Line twice(FeetechSeries::kScs, {1, 1});
  const FoundServos both = find_servos(twice, 5, kGoOn);
  EXPECT_TRUE(both.servos.empty());
  EXPECT_EQ(both.garbled, std::vector<std::uint8_t>{1});
  EXPECT_EQ(find_servos(line, 20, [](std::uint8_t id) { return id < 5; }).servos.size(), 1U);
}

TEST(FeetechSetup, a_number_is_changed_for_good_and_only_to_a_free_one) {
  for (const FeetechSeries series : {FeetechSeries::kSts, FeetechSeries::kScs}) {
    Line line(series, {1, 2});
    const auto changed = change_id(line, 1, 5);
    ASSERT_TRUE(changed) << changed.error();
    EXPECT_EQ(changed->id, 5);
    line.bus().power_cycle(Instant{});
    EXPECT_EQ(line.bus().servo(0).id(), 5);
    EXPECT_FALSE(change_id(line, 1, 6)) << "gone";
    const int before = line.writes;
    EXPECT_TRUE(change_id(line, 5, 2).error().contains("already"));
    EXPECT_EQ(line.writes, before);
    EXPECT_TRUE(change_id(line, 9, 10).error().contains("does not reply"));
  }
}

TEST(FeetechSetup, of_two_servos_with_one_number_none_is_changed) {
  Line line(FeetechSeries::kSts, {1, 1});
  const auto refused = change_id(line, 1, 5);
  ASSERT_FALSE(refused);
  EXPECT_TRUE(refused.error().contains("garbled")) << refused.error();
  EXPECT_EQ(line.writes, 0);
}

TEST(FeetechSetup, the_middle_is_where_the_servo_is_and_stays_so) {
  Line line(FeetechSeries::kSts, {1, 2});
  for (const double units : {1500.0, 3900.0, 2048.0, 1.0}) {
    line.sense(0, units);
    const auto set = set_middle(line, 1);
    ASSERT_TRUE(set) << set.error() << " " << units;
    EXPECT_EQ(set->position, 2048);
    EXPECT_FALSE(set->motor_on);
  }
  line.bus().power_cycle(Instant{});
  line.sense(0, 1.0);
  EXPECT_EQ(find_servo(line, 1)->position, 2048);
  Line scs(FeetechSeries::kScs, {1, 2});
  EXPECT_TRUE(set_middle(scs, 1).error().contains("SCS"));
}

}  // namespace
}  // namespace sinew
