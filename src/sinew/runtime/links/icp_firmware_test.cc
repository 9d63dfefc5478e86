#include <gtest/gtest.h>

#include <vector>

#include "sinew/devices/icp/icp_settings.h"
#include "sinew/devices/kinds.h"
#include "sinew/runtime/links/robot_variant.h"
#include "support/robots.h"

namespace sinew::runtime {
namespace {

using namespace std::chrono_literals;
using Bytes = std::vector<std::uint8_t>;

/// The simulated controller that belongs to a robot's file (and a profile), with what it answers.
struct Bench {
  explicit Bench(const IcpFirmware& firmware, std::optional<std::string> profile = {})
      : model(test::robot("hexapod")) {
    model.device.settings.get<IcpDevice>().firmware = firmware;
    model = *variant_of(model, profile, std::nullopt);
    machine = std::move(*make_machine(model, {.profile = profile}, Instant{}));
    wait(firmware.boot + 1ms);
  }
  void wait(Duration time) {
    now += time;
    machine.byte->advance(now);
  }
  Bytes ask(const Bytes& bytes) {
    Bytes answers;
    for (const std::uint8_t byte : bytes) {
      machine.byte->receive(std::span(&byte, 1), now);
      wait(2ms);
      std::array<std::uint8_t, 32> piece{};
      const std::size_t count = machine.byte->take_output(piece);
      answers.insert(answers.end(), piece.begin(),
                     piece.begin() + static_cast<std::ptrdiff_t>(count));
    }
    return answers;
  }
  /// TagPos of leg 1 after one step with that positioning byte.
  int target_after(std::uint8_t step) {
    ask({0xFF, step});
    wait(100ms);
    const Bytes status = ask({0xFF, 0xF0, 0x01});
    return status.size() < 13 ? 99'999
                              : static_cast<std::int16_t>(status[status.size() - 4] << 8 |
                                                          status[status.size() - 3]);
  }

  RobotModel model;
  RobotMachine machine;
  Instant now{};
};

TEST(IcpFirmware, each_setting_of_the_file_reaches_the_simulated_controller) {
  EXPECT_EQ(Bench({}).ask({0xFF, 0xC0}), (Bytes{0, 0}));
  EXPECT_EQ(Bench({.knows_wake = false}).ask({0xFF, 0xC0}), (Bytes{0, 0x11}));

  EXPECT_EQ(Bench({}).ask({0xFF, 0xF0, 0x01}).size(), 15U);
  EXPECT_EQ(Bench({.checks_selector = true}).ask({0xFF, 0xF0, 0x01}), (Bytes{0, 0, 0x11}));
  EXPECT_EQ(Bench({.checks_selector = true}).ask({0xFF, 0xF0, 0x11}).size(), 15U);

  EXPECT_EQ(Bench({}).target_after(0x11), 1);
  EXPECT_EQ(Bench({}).target_after(0xA9), -1);
  EXPECT_EQ(Bench({.bit_one_is_plus = true}).target_after(0x11), -1);
  EXPECT_EQ(Bench({.minus_one_is_fffe = true}).target_after(0xA9), -2);

  EXPECT_EQ(Bench({}).ask({0xFF, 0x00}), (Bytes{0, 0x11}));
  EXPECT_EQ(Bench({.silent_without_motor = true}).ask({0xFF, 0x00}), (Bytes{0}));

  for (const bool lies : {false, true}) {
    Bench bench({.ack_without_module = lies});
    bench.machine.byte->disturb({sim::Disturbance::Kind::kSupply, -1, 4.5});
    EXPECT_EQ(bench.ask({0xFF, 0x11}), lies ? (Bytes{0, 0}) : (Bytes{0}));
  }
}

TEST(IcpFirmware, its_times_reach_it_too) {
  Bench slow({.processing = 30ms});
  EXPECT_EQ(slow.ask({0xFF, 0x11}), (Bytes{0})) << "not yet";
  slow.wait(30ms);
  EXPECT_EQ(slow.ask({0xFF}), (Bytes{0, 0})) << "the step's, then FF's";

  Bench asleep({.boot = 0ms});
  Bench booting({.boot = 1500ms});
  EXPECT_EQ(asleep.ask({0xFF}), (Bytes{0}));
  EXPECT_EQ(booting.ask({0xFF}), (Bytes{0})) << "1.5 s later";
  const RobotModel late = booting.model;
  auto fresh = make_machine(late, {}, Instant{});
  const std::uint8_t init = 0xFF;
  fresh->byte->receive(std::span(&init, 1), Instant{} + 1499ms);
  std::array<std::uint8_t, 4> piece{};
  EXPECT_EQ(fresh->byte->take_output(piece), 0U) << "deaf while it boots";

  Bench idle({.idle_shutdown = 10s});
  idle.wait(9s);
  EXPECT_EQ(idle.ask({0xFF}), (Bytes{0}));
  idle.wait(11s);
  EXPECT_TRUE(idle.ask({0x10, 0xFF}).empty());
}

TEST(IcpFirmware, a_profile_comes_on_top_of_the_file) {
  const IcpFirmware swapped{.bit_one_is_plus = true};
  EXPECT_EQ(Bench(swapped, "fffe").target_after(0x11), -2);
  EXPECT_EQ(Bench(swapped, "section4").ask({0xFF, 0xC0}), (Bytes{0, 0x11}));
  EXPECT_EQ(Bench(swapped, "table1").target_after(0xA9), 1);
}

}  // namespace
}  // namespace sinew::runtime
