#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <iterator>

#include "firmware/emulation/axis_bench.h"
#include "sinew/devices/axis_link/axis_link_driver_setup.h"
#include "support/property.h"
#include "support/robots.h"

namespace sinew::emulation {
namespace {

using axis_link::Mode;
using axis_link::Verdict;

// What an image may use, of the smaller chip: 20 KB of memory, 64 KB of flash (the linker sees to
// that).
constexpr std::uint32_t kStackMax = 3 * 1024;  // bytes
constexpr double kTick = 4e-3;                 // s
constexpr double kTickMax = 0.9;               // of a tick, the longest that the loop works
constexpr double kInterruptMax = 4e-6;         // s, the longest interrupt

constexpr std::size_t kShoulder = 1;

class AxisImage : public ::testing::TestWithParam<Stm32Chip> {
 protected:
  AxisImage()
      : model(test::robot("robot-arm-2")),
        bench(GetParam(), model, kShoulder, model.joints[kShoulder].lower + from_deg(4), 1) {}

  bool ready() {
    bench.set_up();
    return bench.open() && bench.home();
  }
  /// rad, `degrees` above the place where homing ends
  double above_home(double degrees) const {
    return bench.setup.axis.homing.clear_angle + from_deg(degrees);
  }
  double seconds(Cycles cycles) {
    return static_cast<double>(cycles) / bench.chip.core().clock_hz();
  }
  /// What the board says that it may be off by, rad.
  double uncertainty() const { return bench.identity.uncertainty / axis_link::kUncertaintyUnits; }

  const RobotModel& model;
  AxisBench bench;
};
INSTANTIATE_TEST_SUITE_P(, AxisImage, ::testing::Values(Stm32Chip::kF103, Stm32Chip::kF401),
                         [](const auto& chip) { return name_of(chip.param); });

TEST_P(AxisImage, homes_and_follows_a_stream) {
  ASSERT_TRUE(ready()) << bench.broken.value_or("not homed") << int{bench.state.fault};
  EXPECT_NEAR(bench.plant.q(), above_home(0), uncertainty());

  const double speed = 0.8;  // rad/s of the swing
  const auto swing = [&](double t) { return above_home(8 * (1 - std::cos(speed * t))); };
  double worst = 0;
  static_cast<void>(bench.chip.core().longest_work());
  for (int i = 0; i < 800; ++i) {
    const double t = 0.01 * i;
    const double qd = from_deg(8) * speed * std::sin(speed * t);
    ASSERT_TRUE(bench.send(Mode::kTrack, swing(t), qd));
    // A setpoint is for the next one's time; the smoothing is 30 ms behind, board and motor 12.
    if (i > 50) worst = std::max(worst, std::abs(bench.plant.q() - swing(t - 0.032)));
  }
  EXPECT_EQ(bench.state.fault, 0);
  EXPECT_EQ(bench.state.verdict, Verdict::kAccepted);
  EXPECT_LT(worst, uncertainty());
  EXPECT_NEAR(bench.told(), bench.plant.q(), uncertainty());
  EXPECT_EQ(bench.chip.bites(), 0);

  CortexM& core = bench.chip.core();
  const std::uint32_t stack = core.stack_depth();
  const double work = seconds(core.longest_work());
  std::printf("  stack %u bytes; loop %.2f ms of %.0f at most; %.3f deg off at most\n", stack,
              work * 1e3, kTick * 1e3, to_deg(worst));
  EXPECT_LT(stack, kStackMax);
  EXPECT_LT(work, kTickMax * kTick);
  for (const int line : {10, 30, 40}) {
    EXPECT_LT(seconds(core.figures(line).longest), kInterruptMax) << "line " << line;
  }
}

TEST_P(AxisImage, a_silent_host_is_a_stop_that_latches) {
  ASSERT_TRUE(ready());
  ASSERT_TRUE(bench.send(Mode::kMove, above_home(50)));
  ASSERT_TRUE(bench.read_until([&] { return bench.state.velocity > 80; }, 5));
  ASSERT_TRUE(bench.run(0.1 + 3));
  const std::int64_t stood = bench.steps;
  ASSERT_TRUE(bench.run(1));
  EXPECT_NEAR(static_cast<double>(bench.steps), static_cast<double>(stood), 2);
  EXPECT_LT(bench.plant.q(), above_home(40));
  ASSERT_TRUE(bench.open());
  EXPECT_EQ(bench.state.fault, static_cast<int>(AxisFault::kLinkSilent));
  EXPECT_TRUE(bench.state.homed);
}

TEST_P(AxisImage, its_lamp_says_what_is_wrong) {
  // Flashes between two pauses of a second and more.
  const auto flashes = [&] {
    int count = 0, dark = 0;
    bool counts = false;
    for (int ms = 0; ms < 12'000; ++ms) {
      if (!bench.run(1e-3)) return -1;
      const bool lit = !bench.chip.output('C', 13);
      if (lit && dark > 0 && counts) ++count;
      dark = lit ? 0 : dark + 1;
      if (dark != 1000) continue;
      if (counts) return count;
      counts = true;
    }
    return 0;
  };
  ASSERT_TRUE(bench.run(0.1));
  EXPECT_EQ(flashes(), 1) << "a new board is not set up";
  ASSERT_TRUE(ready());
  bench.chip.set_input('B', 15, false);
  ASSERT_TRUE(bench.run(0.1));
  EXPECT_EQ(flashes(), 2) << "a stop is latched";
}

TEST_P(AxisImage, the_stop_line_ends_the_pulses_within_a_millisecond) {
  ASSERT_TRUE(ready());
  ASSERT_TRUE(bench.send(Mode::kMove, above_home(60)));
  ASSERT_TRUE(bench.read_until([&] { return to_deg(bench.plant.qd()) > 9; }, 5));
  const std::int64_t before = bench.steps;
  bench.chip.set_input('B', 15, false);
  const Cycles pulled = bench.chip.core().now();
  ASSERT_TRUE(bench.run(0.5));
  EXPECT_LT(seconds(std::max(bench.last_pulse, pulled) - pulled), 1e-3);
  EXPECT_LE(bench.steps - before, 1);
  ASSERT_TRUE(bench.open());
  EXPECT_TRUE(bench.state.emergency_stopped);
  // While the line is low nothing releases it.
  const auto release = [&] {
    return bench.send(Mode::kRelease) && bench.send(Mode::kRead) && bench.send(Mode::kRead);
  };
  ASSERT_TRUE(release());
  EXPECT_TRUE(bench.state.emergency_stopped);
  bench.chip.set_input('B', 15, true);
  ASSERT_TRUE(release());
  EXPECT_FALSE(bench.state.emergency_stopped);
  // The pulses that were not made are not taken for steps that were lost.
  EXPECT_EQ(bench.state.fault, 0);
  EXPECT_TRUE(bench.state.position_ok);
  ASSERT_TRUE(bench.send(Mode::kMove, above_home(3)));
  ASSERT_TRUE(bench.read_until([&] { return !bench.state.moving; }, 20));
  EXPECT_NEAR(bench.plant.q(), above_home(3), uncertainty());
}

TEST_P(AxisImage, a_supply_that_sags_ends_pulses_and_current_at_once) {
  ASSERT_TRUE(ready());
  ASSERT_TRUE(bench.send(Mode::kMove, above_home(60)));
  ASSERT_TRUE(bench.read_until([&] { return to_deg(bench.plant.qd()) > 9; }, 5));
  bench.chip.set_supply_low(true);
  const Cycles sagged = bench.chip.core().now();
  ASSERT_TRUE(bench.run(1e-3));
  EXPECT_TRUE(bench.chip.output('B', 13)) << "no current";
  bench.chip.set_supply_low(false);
  ASSERT_TRUE(bench.run(0.1));
  EXPECT_LT(seconds(std::max(bench.last_pulse, sagged) - sagged), 1e-3);
  ASSERT_TRUE(bench.open());
  EXPECT_EQ(bench.state.fault, static_cast<int>(AxisFault::kSupplyLow));
  // It moves again only when it is asked to.
  ASSERT_TRUE(bench.send(Mode::kClearFaults));
  const std::int64_t before = bench.pulses;
  ASSERT_TRUE(bench.run(0.5));
  EXPECT_LE(bench.pulses - before, 40) << "the hold only";
  ASSERT_TRUE(bench.open() && bench.home());
}

TEST_P(AxisImage, a_sag_at_any_moment_of_the_control_cycle_keeps_the_current_off) {
  ASSERT_TRUE(ready());
  for (int phase = 0; phase < 32; ++phase) {
    SCOPED_TRACE(phase);
    ASSERT_FALSE(bench.chip.output('B', 13)) << "current is on";
    ASSERT_FALSE(bench.chip.run_for(0.125e-3 * phase));
    bench.chip.set_supply_low(true);
    ASSERT_FALSE(bench.chip.run_for(0.1e-3));
    bench.chip.set_supply_low(false);
    for (int i = 0; i < 100; ++i) {
      ASSERT_TRUE(bench.chip.output('B', 13)) << i;
      ASSERT_FALSE(bench.chip.run_for(0.2e-3));
    }
    ASSERT_TRUE(bench.open() && bench.send(Mode::kClearFaults));
    ASSERT_TRUE(bench.read_until([&] { return bench.state.fault == 0; }, 1));
    ASSERT_TRUE(bench.run(0.5));
  }
}

TEST_P(AxisImage, whatever_comes_over_the_wire_moves_nothing_and_hangs_nothing) {
  bench.set_up();
  ASSERT_TRUE(bench.run(0.1));
  test::Random random(test::seed());
  for (int i = 0; i < 400; ++i) {
    std::vector<std::uint8_t> bytes(static_cast<std::size_t>(random.integer(0, 40)));
    for (std::uint8_t& byte : bytes) byte = static_cast<std::uint8_t>(random.bits());
    if (!bytes.empty() && random.chance(0.5)) bytes[0] = random.chance(0.5) ? 0x97 : 0x99;
    bench.transfer(bytes);
    ASSERT_TRUE(bench.run(1e-3 * static_cast<double>(random.integer(0, 3)))) << *bench.broken;
  }
  EXPECT_EQ(bench.pulses, 0);
  EXPECT_EQ(bench.chip.bites(), 0);
  EXPECT_TRUE(bench.open());
}

TEST_P(AxisImage, a_loop_that_hangs_is_bitten_by_the_watchdog) {
  ASSERT_TRUE(ready());
  // No tick comes any more: the loop waits for ever.
  bench.chip.core().disable(30);
  ASSERT_TRUE(bench.run(0.2));
  EXPECT_EQ(bench.chip.bites(), 1);
  EXPECT_EQ(bench.identity.boot, 1);
  ASSERT_TRUE(bench.open());
  EXPECT_EQ(bench.identity.boot, 2);
  EXPECT_FALSE(bench.state.homed);
  EXPECT_FALSE(bench.state.position_ok);
}

TEST_P(AxisImage, a_latched_stop_outlives_the_watchdog) {
  ASSERT_TRUE(ready());
  ASSERT_TRUE(bench.send(Mode::kEmergencyStop) && bench.send(Mode::kRead));
  EXPECT_TRUE(bench.state.emergency_stopped);
  bench.chip.core().disable(30);
  ASSERT_TRUE(bench.run(0.2));
  EXPECT_EQ(bench.chip.bites(), 1);
  ASSERT_TRUE(bench.open());
  EXPECT_TRUE(bench.state.emergency_stopped);
  ASSERT_TRUE(bench.send(Mode::kHome) && bench.send(Mode::kRead));
  EXPECT_FALSE(bench.state.homing);
  ASSERT_TRUE(bench.send(Mode::kRelease) && bench.home());
}

/// While the flash is erased the processor stands, and timers would repeat their last pulses.
TEST_P(AxisImage, makes_no_pulse_while_its_flash_is_erased) {
  ASSERT_TRUE(ready());
  AxisSetup other = bench.setup;
  other.axis.limits.velocity /= 2;
  const SetupBytes bytes = encode_setup(other);
  ASSERT_TRUE(bench.write_setup_words(bytes));
  // Something leans on the arm: the loop makes steps against it.
  bench.plant.set_extra_load(6);
  ASSERT_TRUE(bench.run(0.06));
  const std::int64_t before = bench.steps;
  ASSERT_TRUE(bench.send(Mode::kStoreSetup));
  ASSERT_TRUE(bench.run(1.2));
  EXPECT_GT(bench.chip.flash().operations(), 50);
  EXPECT_LT(std::abs(bench.steps - before), 40);
}

TEST_P(AxisImage, without_its_encoder_nothing_moves) {
  bench.set_up();
  bench.motor_sensor.plugged_in = false;
  ASSERT_TRUE(bench.open());
  ASSERT_TRUE(bench.send(Mode::kHome));
  ASSERT_TRUE(bench.read_until([&] { return bench.state.fault != 0; }, 1));
  EXPECT_EQ(bench.state.fault, static_cast<int>(AxisFault::kMotorEncoder));
  EXPECT_FALSE(bench.state.sensor_ok);
  EXPECT_LE(std::abs(bench.steps), 2);
}

TEST_P(AxisImage, is_set_up_over_its_wire_and_keeps_that_without_power) {
  // As it was flashed it belongs to no axis.
  ASSERT_TRUE(bench.open(0));
  EXPECT_EQ(bench.identity.model_hash, axis_link::model_hash({}));
  const std::uint8_t number = std::exchange(bench.setup.axis_number, 0);
  ASSERT_TRUE(bench.send(Mode::kHome) && bench.send(Mode::kRead) && bench.send(Mode::kRead));
  EXPECT_FALSE(bench.state.homing);
  EXPECT_FALSE(bench.state.motor_ok);

  AxisSetup setup = bench.setup;
  setup.axis_number = number;
  const auto report = axis_link::write_setup(encode_setup(setup), 1, bench.setup_line());
  ASSERT_TRUE(report) << describe(report.error()) << bench.broken.value_or("");
  EXPECT_TRUE(report->written);
  EXPECT_FALSE(decode_setup(report->before));
  // It has started again, by itself, as the axis that it now is.
  EXPECT_EQ(bench.chip.bites(), 0);
  bench.setup = setup;
  ASSERT_TRUE(bench.open());
  EXPECT_EQ(
      bench.identity.model_hash,
      axis_link::model_hash({number, setup.axis.lower, setup.axis.upper, setup.axis.limits.velocity,
                             setup.axis.limits.acceleration, setup.axis.limits.jerk}));
  bench.chip.power_cycle();
  ASSERT_TRUE(bench.open() && bench.home());
}

TEST_P(AxisImage, tells_which_image_it_is) {
  std::ifstream file(EmulatedBoard::image(GetParam()), std::ios::binary);
  const std::vector<std::uint8_t> bytes{std::istreambuf_iterator<char>(file), {}};
  const auto flashed = sinew::read_image(bytes);
  ASSERT_TRUE(flashed);
  EXPECT_EQ(flashed->size, bytes.size());
  EXPECT_EQ(flashed->board_name(), EmulatedBoard::image(GetParam()).stem().string());
  const auto told = axis_link::read_board_image(1, bench.setup_line());
  ASSERT_TRUE(told) << describe(told.error()) << bench.broken.value_or("");
  EXPECT_EQ(*told, flashed);
}

TEST_P(AxisImage, a_power_cut_at_any_unit_of_a_setup_leaves_a_whole_one) {
  bench.set_up();
  AxisSetup other = bench.setup;
  other.axis.limits.velocity /= 2;
  const SetupBytes bytes = encode_setup(other);
  const auto hash = [](const AxisSetup& setup) {
    return axis_link::model_hash({setup.axis_number, setup.axis.lower, setup.axis.upper,
                                  setup.axis.limits.velocity, setup.axis.limits.acceleration,
                                  setup.axis.limits.jerk});
  };
  // The erasing, and each unit of the copy: half words, or words.
  constexpr int kCopySize = static_cast<int>(kSetupSize) + 8;
  const int units = kCopySize / (GetParam() == Stm32Chip::kF103 ? 2 : 4);
  int kept = 0;
  for (int cut = 0; cut <= units + 1; cut += cut < 3 || cut > units - 3 ? 1 : 13) {
    SCOPED_TRACE(cut);
    ASSERT_TRUE(bench.open());
    ASSERT_EQ(bench.identity.model_hash, hash(bench.setup));
    ASSERT_TRUE(bench.write_setup_words(bytes));
    bench.chip.flash().cut_power_in(cut);
    static_cast<void>(bench.send(Mode::kStoreSetup));
    if (!bench.broken) static_cast<void>(bench.run(2.5));
    const bool was_cut = bench.broken.has_value();
    EXPECT_EQ(was_cut, cut <= units) << bench.broken.value_or("");
    bench.broken.reset();
    bench.chip.flash().cut_power_in(std::nullopt);
    bench.chip.power_cycle();
    ASSERT_TRUE(bench.open());
    // The old one, or where all was written the new one; never none.
    const bool is_new = bench.identity.model_hash == hash(other);
    EXPECT_TRUE(is_new || bench.identity.model_hash == hash(bench.setup));
    EXPECT_EQ(is_new, cut > units);
    kept += is_new ? 0 : 1;
    if (is_new) break;
  }
  EXPECT_GT(kept, 10);
}

/// A joint that needs all the steps that a board can make: 64 microsteps, 60 deg/s.
class QuickImage : public ::testing::TestWithParam<Stm32Chip> {
 protected:
  static RobotModel quick() {
    RobotModel model = test::robot("robot-arm-2");
    Joint& joint = model.joints[kShoulder];
    joint.velocity_max = from_deg(59);
    joint.acceleration_max = from_deg(150);
    joint.jerk_max = from_deg(1500);
    model.dynamics.drives[kShoulder].microsteps = 64;
    (*model.device.settings->own_boards())[kShoulder].step_rate_max = kStepRateMost;
    return model;
  }
  RobotModel model = quick();
  AxisBench bench{GetParam(), model, kShoulder, model.joints[kShoulder].lower + from_deg(4), 1};
};
INSTANTIATE_TEST_SUITE_P(, QuickImage, ::testing::Values(Stm32Chip::kF103, Stm32Chip::kF401),
                         [](const auto& chip) { return name_of(chip.param); });

TEST_P(QuickImage, makes_each_step_in_time_at_its_highest_rate) {
  bench.set_up();
  ASSERT_TRUE(bench.open() && bench.home()) << int{bench.state.fault};
  std::vector<double> rises;  // s
  const double cycle = 1.0 / bench.chip.core().clock_hz();
  double shortest_high = 1;
  const auto counted = bench.chip.timers().on_pulse;
  bench.chip.timers().on_pulse = [&](Cycles at, bool high) {
    const double now = static_cast<double>(at) * cycle;
    if (high) rises.push_back(now);
    if (!high && !rises.empty()) shortest_high = std::min(shortest_high, now - rises.back());
    counted(at, high);
  };
  const double target = bench.setup.axis.homing.clear_angle + from_deg(60);
  const std::int64_t before = bench.steps;
  const double from = bench.told();
  ASSERT_TRUE(bench.send(Mode::kMove, target));
  ASSERT_TRUE(bench.read_until([&] { return !bench.state.moving; }, 20));
  EXPECT_EQ(bench.state.fault, 0);
  const double per_rad = bench.setup.axis.steps_per_rad();
  EXPECT_NEAR(static_cast<double>(bench.steps - before), (target - from) * per_rad,
              bench.setup.axis.position_tolerance * per_rad)
      << "but for what its loop held against";
  // A step is due half way between its neighbours: its own pace changes by less than 0.1 us there.
  double quickest = 1, latest = 0;
  for (std::size_t i = 1; i + 1 < rises.size(); ++i) {
    const double pace = (rises[i + 1] - rises[i - 1]) / 2;
    quickest = std::min(quickest, pace);
    if (pace < 1 / 30e3) latest = std::max(latest, std::abs(rises[i] - rises[i - 1] - pace));
  }
  std::printf(
      "  %zu steps, up to %.0f a second, %.2f us off their time at most, pulses of %.2f us\n",
      rises.size(), 1 / quickest, latest * 1e6, shortest_high * 1e6);
  EXPECT_GT(1 / quickest, 34e3);
  EXPECT_LT(latest, 2e-6);
  EXPECT_GE(shortest_high, 4.9e-6);
}

/// A joint whose AS5600 is read over RS-485, by its node.
class NodeImage : public ::testing::TestWithParam<Stm32Chip> {
 protected:
  static constexpr std::size_t kForearm = 3;

  static RobotModel with_node() {
    RobotModel model = test::robot("robot-arm-2");
    (*model.device.settings->own_boards())[kForearm].encoder_node = true;
    return model;
  }

  bool ready() {
    bench.set_up();
    return bench.open() && bench.home();
  }
  /// In a session of its own; not measured where no answer comes.
  axis_link::Health health() {
    if (!bench.open() || !bench.send(Mode::kReadHealth)) return {};
    const auto reply = bench.exchange({.axis = bench.setup.axis_number,
                                       .mode = Mode::kRead,
                                       .sequence = ++bench.sequence,
                                       .session = bench.session});
    const auto* told = reply ? std::get_if<axis_link::Health>(&reply->body) : nullptr;
    return told != nullptr ? *told : axis_link::Health{};
  }

  RobotModel model = with_node();
  AxisBench bench{GetParam(), model, kForearm, model.joints[kForearm].lower + from_deg(4), 1};
};
INSTANTIATE_TEST_SUITE_P(, NodeImage, ::testing::Values(Stm32Chip::kF103, Stm32Chip::kF401),
                         [](const auto& chip) { return name_of(chip.param); });

TEST_P(NodeImage, homes_and_moves_with_the_joints_sensor_on_rs485) {
  ASSERT_TRUE(ready()) << bench.broken.value_or("not homed") << int{bench.state.fault};
  const double target = bench.setup.axis.homing.clear_angle + from_deg(20);
  ASSERT_TRUE(bench.send(Mode::kMove, target));
  ASSERT_TRUE(bench.read_until([&] { return !bench.state.moving; }, 20));
  EXPECT_EQ(bench.state.fault, 0);
  EXPECT_NEAR(bench.plant.q(), target, bench.identity.uncertainty / axis_link::kUncertaintyUnits);
  EXPECT_EQ(bench.undriven_bytes, 0);
  EXPECT_FALSE(bench.chip.output('B', 1)) << "the line is free between requests";
  EXPECT_NEAR(bench.chip.usart2().baud(), 115'200, 0.005 * 115'200);
  EXPECT_EQ(health().joint_magnet, Magnet::kGood);
  EXPECT_EQ(health().motor_magnet, Magnet::kGood);

  CortexM& core = bench.chip.core();
  const double longest =
      static_cast<double>(core.figures(38).longest) / static_cast<double>(core.clock_hz());
  EXPECT_LT(longest, kInterruptMax);
  EXPECT_LT(core.stack_depth(), kStackMax);
}

TEST_P(NodeImage, a_node_that_is_unplugged_is_a_fault_with_its_name) {
  ASSERT_TRUE(ready());
  bench.node_plugged_in = false;
  ASSERT_TRUE(bench.read_until([&] { return bench.state.fault != 0; }, 1));
  EXPECT_EQ(bench.state.fault, static_cast<int>(AxisFault::kJointEncoder));
  EXPECT_EQ(health().joint_magnet, Magnet::kNoReply);
  bench.node_plugged_in = true;
  ASSERT_TRUE(bench.run(0.2));
  EXPECT_EQ(health().joint_magnet, Magnet::kGood);
}

TEST_P(NodeImage, a_magnet_that_moved_away_shows_in_its_health) {
  ASSERT_TRUE(ready());
  bench.plant.set_field(0.4);
  ASSERT_TRUE(bench.run(0.3));
  EXPECT_EQ(health().joint_magnet, Magnet::kTooWeak);
  EXPECT_EQ(bench.state.fault, 0) << "its readings still count";
  bench.plant.set_field(0);
  ASSERT_TRUE(bench.read_until([&] { return bench.state.fault != 0; }, 1));
  EXPECT_EQ(health().joint_magnet, Magnet::kMissing);
}

}  // namespace
}  // namespace sinew::emulation
