#include "sinew/sim/simwire_server.h"

#include <gtest/gtest.h>

#include <memory>
#include <string>
#include <vector>

namespace sinew::sim {
namespace {

using namespace std::chrono_literals;

/// Notes what its pins see, answers each byte with its complement.
class PlainBoards : public SpiMachine {
 public:
  void advance(Instant now) override {
    EXPECT_GE(now, now_) << "time ran back";
    now_ = now;
  }
  std::optional<Instant> next_event() const override { return std::nullopt; }
  Truth truth() const override {
    Truth truth;
    truth.joints.push_back({.q = 0.5, .believed = 0.25});
    return truth;
  }
  void disturb(const Disturbance& /*what*/) override {}
  void select(std::uint8_t mask, Instant now) override {
    advance(now);
    if (mask != mask_) edges_.push_back(mask);
    mask_ = mask;
  }
  void shift(std::span<const std::uint8_t> mosi, std::span<std::uint8_t> miso,
             std::uint32_t /*clock_hz*/, Instant now) override {
    advance(now);
    for (std::size_t i = 0; i < mosi.size(); ++i) {
      miso[i] = static_cast<std::uint8_t>(~mosi[i]);
    }
    shifted_ += mosi.size();
  }
  bool ready_pin(std::size_t axis) const override { return axis == 1; }

  std::uint8_t mask_ = 0;
  std::vector<int> edges_;
  std::size_t shifted_ = 0;
  Instant now_{};
};

struct Bench {
  Bench() {
    std::vector<AxisBoard> boards;
    boards.reserve(2);
    for (std::uint8_t i = 0; i < 2; ++i) {
      boards.push_back(
          {0, 0, static_cast<std::uint8_t>(5 + i), static_cast<std::uint8_t>(22 + i), 0});
    }
    server = std::make_unique<SimwireServer>(machine, boards, "sinew");
  }
  std::string ask(const std::string& line) const {
    const auto reply = simwire::encode_reply(server->answer(line));
    return std::string(simwire::view(reply));
  }
  PlainBoards machine;
  std::unique_ptr<SimwireServer> server;
};

TEST(SimwireServer, a_whole_transaction_is_answered_line_by_line) {
  Bench bench;
  EXPECT_EQ(bench.ask("1000 HELLO 1"), "OK simwire 1 sinew");
  EXPECT_EQ(bench.ask("1001 DIR 5 OUT OFF"), "OK");
  EXPECT_EQ(bench.machine.mask_, 1) << "an output begins at its latch, which is 0";
  EXPECT_EQ(bench.ask("1002 SET 5 1"), "OK");
  EXPECT_EQ(bench.ask("1003 DIR 23 IN UP"), "OK");
  EXPECT_EQ(bench.ask("1004 GET 23"), "LVL 1");
  EXPECT_EQ(bench.ask("1005 OPEN 0 0 500000 0"), "OK");
  EXPECT_EQ(bench.ask("1006 SET 5 0"), "OK");
  EXPECT_EQ(bench.ask("1206 XFER 0 0 500000 0 97ff"), "MISO 6800");
  EXPECT_EQ(bench.ask("1300 SET 5 1"), "OK");
  EXPECT_EQ(bench.ask("1301 CLOSE 0 0"), "OK");
  EXPECT_EQ(bench.ask("1302 BYE"), "OK");
  EXPECT_TRUE(bench.server->finished());
  EXPECT_EQ(bench.machine.edges_, (std::vector<int>{1, 0, 1, 0}));
  EXPECT_EQ(bench.machine.now_, Instant{} + 302us);
}

TEST(SimwireServer, time_is_the_hosts_and_a_transfer_takes_its_own) {
  Bench bench;
  bench.ask("5000000 HELLO 1");
  EXPECT_EQ(bench.server->now(), Instant{});
  bench.ask("5000100 OPEN 0 0 500000 0");
  EXPECT_EQ(bench.server->now(), Instant{} + 100us);
  bench.ask("5000100 XFER 0 0 500000 0 0000");
  EXPECT_EQ(bench.server->now(), Instant{} + 132us);
  bench.ask("5000110 STAT");  // a host that does not count the transfer's time
  EXPECT_EQ(bench.server->now(), Instant{} + 132us);
  EXPECT_EQ(bench.ask("5000109 STAT"), "ERR the time ran back");
  bench.ask("99000000000 HELLO 1");
  EXPECT_EQ(bench.server->now(), Instant{} + 132us) << "another clock begins";
  bench.ask("99000001000 STAT");
  EXPECT_EQ(bench.server->now(), Instant{} + 1110us);
}

TEST(SimwireServer, a_stamp_far_ahead_is_refused_and_locks_nobody_out) {
  Bench bench;
  bench.ask("1000 HELLO 1");
  for (const char* stamp : {"1000000000000000000", "18446744073709551615", "3600001001"}) {
    EXPECT_EQ(bench.ask(std::string(stamp) + " STAT"),
              "ERR the time jumped by more than an hour; HELLO begins a new clock");
    EXPECT_EQ(bench.server->now(), Instant{});
  }
  EXPECT_TRUE(bench.ask("1100 STAT").starts_with("STAT ")) << "measured by the last good one";
  EXPECT_EQ(bench.server->now(), Instant{} + 100us);
  EXPECT_TRUE(bench.ask("3600001100 STAT").starts_with("STAT ")) << "an hour is not too much";
  EXPECT_EQ(bench.ask("18446744073709551615 HELLO 1"), "OK simwire 1 sinew");
  EXPECT_EQ(bench.ask("5 STAT"), "ERR the time ran back");
  EXPECT_EQ(bench.ask("5 HELLO 1"), "OK simwire 1 sinew") << "a wrong HELLO can be said again";
  EXPECT_EQ(bench.server->now(), Instant{} + 100us + 1h);
}

TEST(SimwireServer, nothing_is_done_that_is_not_in_order) {
  Bench bench;
  EXPECT_EQ(bench.ask("1 STAT"), "ERR say HELLO 1 first");
  EXPECT_EQ(bench.ask("1 HELLO 2"), "ERR this speaks simwire 1");
  EXPECT_EQ(bench.ask("2 HELLO 1"), "OK simwire 1 sinew");
  EXPECT_EQ(bench.ask("3 XFER 0 0 500000 0 97"), "ERR this bus is not open");
  EXPECT_EQ(bench.ask("4 SET 5 1"), "ERR the pin is no output");
  EXPECT_EQ(bench.ask("5 DIR 64 OUT UP"), "ERR no such pin");
  EXPECT_EQ(bench.ask("6 OPEN 0 0 500000 0"), "OK");
  EXPECT_EQ(bench.ask("8 XFER 0 0 0 0 97"), "ERR the clock is 1 Hz to 50 MHz");
  EXPECT_EQ(bench.ask("9 XFER 0 0 500000 3 97"), "MISO 00") << "another mode samples other edges";
  EXPECT_EQ(bench.ask("10 CLOSE 1 0"), "ERR this bus is not open");
  EXPECT_TRUE(bench.ask("11 POKE 1 00").starts_with("ERR nothing is poked here"));
  EXPECT_TRUE(bench.ask("12 FAULT x").starts_with("ERR faults are given"));
  EXPECT_TRUE(bench.ask("garbage").starts_with("ERR a request begins"));
  EXPECT_EQ(bench.machine.shifted_, 0U);
}

/// A master with six objects, one for each axis, opens spidev0.0 six times.
TEST(SimwireServer, a_bus_is_open_until_the_last_of_those_who_opened_it_closes_it) {
  Bench bench;
  bench.ask("1 HELLO 1");
  for (int i = 0; i < 6; ++i) EXPECT_EQ(bench.ask("2 OPEN 0 0 500000 0"), "OK");
  EXPECT_EQ(bench.ask("2 OPEN 0 1 500000 0"), "OK");
  for (int i = 0; i < 5; ++i) EXPECT_EQ(bench.ask("3 CLOSE 0 0"), "OK");
  EXPECT_TRUE(bench.ask("4 XFER 0 0 500000 0 97").starts_with("MISO ")) << "one is left";
  EXPECT_EQ(bench.ask("5 CLOSE 0 0"), "OK");
  EXPECT_EQ(bench.ask("6 XFER 0 0 500000 0 97"), "ERR this bus is not open");
  EXPECT_EQ(bench.ask("7 CLOSE 0 0"), "ERR this bus is not open");
  EXPECT_TRUE(bench.ask("8 XFER 0 1 500000 0 97").starts_with("MISO ")) << "the other stays";
}

TEST(SimwireServer, truth_is_told_on_request) {
  Bench bench;
  bench.ask("1 HELLO 1");
  EXPECT_EQ(bench.ask("1 STAT"), "STAT time_s=0.000000 q_deg_1=28.647890 moving=0");
  EXPECT_EQ(bench.ask("1 DUMP"),
            "DUMP time_s=0.000000 q_deg_1=28.647890 believed_deg_1=14.323945 "
            "qd_deg_s_1=0.000000 lost_steps_1=0 moving=0");
}

TEST(SimwireServer, next_host_finds_the_pins_as_at_power_on) {
  Bench bench;
  bench.ask("1 HELLO 1");
  bench.ask("2 DIR 5 OUT OFF");
  bench.ask("3 OPEN 0 0 500000 0");
  bench.server->restart();
  EXPECT_EQ(bench.machine.mask_, 0);
  EXPECT_EQ(bench.ask("1 STAT"), "ERR say HELLO 1 first") << "its clock may begin anew";
  EXPECT_EQ(bench.ask("1 HELLO 1"), "OK simwire 1 sinew");
  EXPECT_EQ(bench.ask("1 OPEN 0 0 500000 0"), "OK");
}

}  // namespace
}  // namespace sinew::sim
