#include "sinew/devices/icp/icp_device.h"

#include <gtest/gtest.h>

#include <vector>

#include "support/allocation_guard.h"
#include "support/property.h"

namespace sinew {
namespace {

using namespace std::chrono_literals;
using Bytes = std::vector<std::uint8_t>;
using State = IcpController::State;

template <std::size_t... Index>
std::array<Tmc222, icp::kMotors> six(std::index_sequence<Index...>) {
  return {Tmc222(static_cast<std::uint8_t>(0x61 + Index), {}, 7.5, Instant{})...};
}

struct Bench {
  explicit Bench(const IcpQuirks& quirks = {}) : controller(quirks, modules, Instant{}) {
    run_for(50ms);
  }
  void run_for(Duration duration) {
    now += duration;
    for (Tmc222& module : modules) module.advance(now);
    controller.advance(now);
  }
  /// Sends, waits out the controller's time, and gives back what came.
  Bytes ask(const Bytes& bytes) {
    for (const std::uint8_t byte : bytes) {
      controller.receive(byte, now);
      run_for(20ms);
    }
    return output();
  }
  Bytes output() {
    Bytes all;
    std::array<std::uint8_t, 5> piece{};
    while (const std::size_t count = controller.take_output(piece)) {
      all.insert(all.end(), piece.begin(), piece.begin() + static_cast<std::ptrdiff_t>(count));
    }
    return all;
  }

  std::array<Tmc222, icp::kMotors> modules = six(std::make_index_sequence<icp::kMotors>{});
  Instant now{};
  IcpController controller;
};

TEST(IcpController, boot_wakes_all_modules_and_writes_their_parameters) {
  const Bench bench;
  for (const Tmc222& module : bench.modules) {
    EXPECT_EQ(module.state(), Tmc222::State::kStopped);
    EXPECT_EQ(module.parameters(), icp::kMotorParameters);
    EXPECT_EQ(module.flags(), tmc222::Flags{});
  }
}

TEST(IcpController, deaf_while_it_boots) {
  std::array<Tmc222, icp::kMotors> modules = six(std::make_index_sequence<icp::kMotors>{});
  IcpController controller({}, modules, Instant{});
  controller.receive(icp::kInit, Instant{10ms});
  EXPECT_EQ(controller.bytes_lost(), 1U);
  EXPECT_EQ(controller.next_event(), Instant{20ms});
}

TEST(IcpController, every_step_moves_its_motor_by_one_unit_and_is_acknowledged) {
  for (std::uint8_t motor = 1; motor <= icp::kMotors; ++motor) {
    for (const bool direction : {false, true}) {
      Bench bench;
      EXPECT_EQ(bench.ask({0xFF, icp::encode_step({motor, direction})}), (Bytes{0, 0}));
      for (std::uint8_t other = 1; other <= icp::kMotors; ++other) {
        const int unit = direction ? -1 : 1;
        EXPECT_EQ(bench.modules[other - 1U].field(), other == motor ? unit : 0);
        EXPECT_EQ(bench.modules[other - 1U].target(), other == motor ? unit : 0);
      }
    }
  }
}

TEST(IcpController, quirks_of_sign_and_of_minus_one) {
  Bench swapped({.bit_one_is_plus = true});
  swapped.ask({0xFF, icp::encode_step({2, false}), 0xFF, icp::encode_step({3, true})});
  EXPECT_EQ(swapped.modules[1].field(), -1);
  EXPECT_EQ(swapped.modules[2].field(), 1);
  Bench doubled({.minus_one = -2});
  doubled.ask({0xFF, icp::encode_step({2, true}), 0xFF, icp::encode_step({3, false})});
  EXPECT_EQ(doubled.modules[1].field(), -2);
  EXPECT_EQ(doubled.modules[2].field(), 1);
}

TEST(IcpController, status_is_acknowledged_and_then_the_documents_twelve_bytes) {
  Bench bench;
  const Bytes healthy{0, 0, 0, 0xE1, 0xDD, 0xFF, 0x6F, 0, 2, 0, 1, 0, 1, 0, 0xF8};
  bench.ask({0xFF, icp::encode_step({1, false})});
  EXPECT_EQ(bench.ask({0xFF, 0xF0, 0x01}), healthy);
  EXPECT_EQ(bench.ask({0xFF, 0xF0, 0xA9}), healthy) << "a positioning byte selects as well";
}

TEST(IcpController, step_that_a_module_ignores_is_acknowledged_all_the_same) {
  Bench bench;
  bench.modules[0].set_supply(7, bench.now);
  EXPECT_EQ(bench.ask({0xFF, 0x11}), (Bytes{0, 0}));
  EXPECT_EQ(bench.modules[0].field(), 0);
  EXPECT_EQ(bench.modules[0].target(), 0) << "that is how a host can see it";
}

TEST(IcpController, module_without_supply_gives_silence_or_an_empty_acknowledge) {
  for (const bool lies : {false, true}) {
    Bench bench({.ack_without_module = lies});
    bench.modules[0].set_supply(0, bench.now);
    EXPECT_EQ(bench.ask({0xFF, 0x11}), lies ? (Bytes{0, 0}) : (Bytes{0}));
    EXPECT_EQ(bench.ask({0xFF, 0xF0, 0x01}), lies ? (Bytes{0, 0, 0}) : (Bytes{0, 0}));
    EXPECT_EQ(bench.ask({0xFF, 0x12}), (Bytes{0, 0})) << "the others go on";
  }
}

TEST(IcpController, bytes_for_no_motor_are_refused_or_met_with_silence) {
  for (const std::uint8_t byte : Bytes{0x00, 0x18, 0xB7, 0xCF}) {
    EXPECT_EQ(Bench().ask({0xFF, byte}), (Bytes{0, 0x11}));
    EXPECT_EQ(Bench({.silent_without_motor = true}).ask({0xFF, byte}), (Bytes{0}));
  }
  EXPECT_EQ(Bench().ask({0xFF, 0xF0, 0x00}), (Bytes{0, 0, 0x11}));
  EXPECT_EQ(Bench().ask({0xFF, 0xF0, 0x07}), (Bytes{0, 0, 0x11}));
  EXPECT_EQ(Bench().ask({0xFF, 0x91}), (Bytes{0, 0x22}));
}

TEST(IcpController, wake_is_a_command_or_a_byte_with_wrong_ones) {
  Bench bench;
  bench.modules[3].set_supply(0, bench.now);
  bench.modules[3].set_supply(12, bench.now);
  EXPECT_EQ(bench.ask({0xFF, 0xC0}), (Bytes{0, 0}));
  EXPECT_EQ(bench.modules[3].state(), Tmc222::State::kStopped);
  EXPECT_EQ(Bench({.dialect = {.knows_wake = false}}).ask({0xFF, 0xC0}), (Bytes{0, 0x11}));
}

TEST(IcpController, killed_until_its_power_is_cut) {
  Bench bench;
  EXPECT_EQ(bench.ask({0xFF, 0xE0}), (Bytes{0}));
  EXPECT_EQ(bench.controller.state(), State::kDead);
  EXPECT_TRUE(bench.ask({0x10, 0xFF, 0xFF}).empty());
  bench.controller.power_cycle(bench.now);
  bench.run_for(20ms);
  EXPECT_EQ(bench.ask({0xFF}), (Bytes{0}));
}

TEST(IcpController, long_idle_time_shuts_it_down_where_it_does_that) {
  Bench bench({.idle_shutdown = 10min});
  bench.run_for(9min);
  EXPECT_EQ(bench.ask({0xFF, 0x11}), (Bytes{0, 0}));
  bench.run_for(11min);
  EXPECT_TRUE(bench.ask({0xFF}).empty());
}

TEST(IcpController, own_time_passes_before_the_reply_and_one_byte_waits_meanwhile) {
  Bench bench({.processing = 10ms});
  bench.controller.receive(0xFF, bench.now);
  EXPECT_EQ(bench.output(), (Bytes{0})) << "FF needs no module";
  bench.controller.receive(0x11, bench.now);
  EXPECT_EQ(bench.controller.next_event(), bench.now + 10ms);
  bench.run_for(9ms);
  EXPECT_TRUE(bench.output().empty());
  EXPECT_EQ(bench.modules[0].target(), 0);
  bench.controller.receive(0xFF, bench.now);
  bench.controller.receive(0x12, bench.now);
  EXPECT_EQ(bench.controller.bytes_lost(), 1U);
  bench.run_for(1ms);
  EXPECT_EQ(bench.output(), (Bytes{0, 0})) << "the step's, and that of the FF which waited";
}

TEST(IcpController, any_bytes_are_survived_without_an_allocation) {
  test::for_random_cases(2'000, [](test::Random& random) {
    Bench bench({.processing = random.integer(0, 2) * 5ms});
    constexpr std::array<std::uint8_t, 9> kUsual{0xFF, 0xFF, 0xFF, 0xF0, 0x10, 0x11, 0xA9, 1, 6};
    std::array<std::uint8_t, 64> out{};
    const test::AllocationCounter allocations;
    for (int i = 0; i < 100; ++i) {
      const bool usual = random.chance(0.8);
      const auto byte = static_cast<std::uint8_t>(random.bits());
      bench.controller.receive(usual ? kUsual[byte % kUsual.size()] : byte, bench.now);
      bench.run_for(Duration{random.integer(0, 20'000'000)});
      if (random.chance(0.5)) (void)bench.controller.take_output(out);
    }
    EXPECT_EQ(allocations.count(), 0U);
    // No byte moves a motor by more than one unit.
    for (const Tmc222& module : bench.modules) EXPECT_LE(std::abs(module.field()), 50);
  });
}

}  // namespace
}  // namespace sinew
