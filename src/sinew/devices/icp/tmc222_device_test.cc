#include "sinew/devices/icp/tmc222_device.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>

#include "sinew/devices/icp/icp_wire.h"
#include "support/allocation_guard.h"
#include "support/property.h"

namespace sinew {
namespace {

using namespace tmc222;
using namespace std::chrono_literals;
using State = Tmc222::State;

/// A chip on its bench, with the parameters of the hexapod where it is not fresh.
struct Bench {
  explicit Bench(bool fresh = false, const Parameters& parameters = icp::kMotorParameters) {
    if (fresh) return;
    send(GetFullStatus1{});
    send(SetMotorParam{parameters});
  }
  bool send(const Command& command) { return chip.write(encode_command(command), now); }
  void go(std::int16_t target) { send(SetPosition{target}); }
  void run_for(Duration duration) {
    now += duration;
    chip.advance(now);
  }
  /// Until it rests; how long that took.
  Duration run_to_rest() {
    const Instant start = now;
    while (const auto event = chip.next_event()) {
      now = *event;
      chip.advance(now);
    }
    return now - start;
  }
  Status1 status1() {
    send(GetFullStatus1{});
    Answer answer{};
    EXPECT_TRUE(chip.read(answer, now));
    return decode_status1(answer).value();
  }
  Status2 status2() {
    send(GetFullStatus2{});
    Answer answer{};
    EXPECT_TRUE(chip.read(answer, now));
    return decode_status2(answer).value();
  }

  Tmc222 chip{0x61, {}, 7.5, Instant{}};
  Instant now{};
};

TEST(Tmc222, power_up_is_a_shutdown_that_only_a_status_leaves) {
  Bench bench(true);
  EXPECT_EQ(bench.chip.state(), State::kShutdown);
  EXPECT_EQ(bench.chip.current(), 0);
  bench.send(SetMotorParam{icp::kMotorParameters});
  bench.go(1);
  EXPECT_FALSE(bench.chip.next_event());
  EXPECT_TRUE(bench.status1().flags.vdd_reset);
  EXPECT_EQ(bench.chip.state(), State::kStopped);
  EXPECT_FALSE(bench.status1().flags.vdd_reset) << "cleared by having been read";
  bench.go(1);
  EXPECT_TRUE(bench.chip.moving());
}

TEST(Tmc222, positioning_is_ignored_until_the_parameters_are_set) {
  Bench bench(true);
  bench.send(GetFullStatus1{});
  bench.go(5);
  EXPECT_EQ(bench.chip.target(), 0);
  bench.send(SetMotorParam{icp::kMotorParameters});
  bench.go(5);
  EXPECT_EQ(bench.chip.target(), 5);
}

TEST(Tmc222, one_microstep_takes_a_seventh_of_a_millisecond) {
  Bench bench;
  bench.send(ResetPosition{});
  bench.go(1);
  EXPECT_NEAR(to_seconds(bench.run_to_rest()), 1 / (456.0 * 16), 1e-6);
  EXPECT_EQ(bench.chip.field(), 1);
  const Status2 status = bench.status2();
  EXPECT_EQ(status.actual, 1);
  EXPECT_EQ(status.target, 1);
  EXPECT_EQ(bench.status1().motion, Motion::kAtTarget);
}

TEST(Tmc222, long_way_takes_the_time_of_its_trapezoid) {
  Bench bench;
  bench.go(16'000);  // 1000 full steps
  const double low = 456.09;
  const double top = 973;
  const double ramp = (top - low) / 40047;
  const double ramp_way = (top * top - low * low) / (2 * 40047);
  const double due = 2 * ramp + (1000 - 2 * ramp_way) / top;
  EXPECT_NEAR(to_seconds(bench.run_to_rest()), due, 1e-3 * due);
  EXPECT_EQ(bench.chip.field(), 16'000);
}

TEST(Tmc222, acceleration_shape_keeps_to_the_lowest_speed) {
  Parameters parameters = icp::kMotorParameters;
  parameters.acceleration_shape = true;
  Bench bench(false, parameters);
  bench.go(1600);
  EXPECT_NEAR(to_seconds(bench.run_to_rest()), 100 / 456.09, 1e-3);
}

TEST(Tmc222, motion_codes_follow_the_ramps_in_both_directions) {
  for (const bool up : {true, false}) {
    Bench bench;
    bench.go(up ? 1600 : -1600);
    bench.run_for(5ms);
    EXPECT_EQ(bench.status1().motion, up ? Motion::kAcceleratingUp : Motion::kAcceleratingDown);
    bench.run_for(45ms);
    EXPECT_EQ(bench.status1().motion, up ? Motion::kTopSpeedUp : Motion::kTopSpeedDown);
    bench.run_for(55ms);
    EXPECT_EQ(bench.status1().motion, up ? Motion::kDeceleratingUp : Motion::kDeceleratingDown);
    bench.run_to_rest();
    EXPECT_EQ(bench.status1().motion, Motion::kAtTarget);
    EXPECT_EQ(bench.chip.field(), up ? 1600 : -1600);
  }
}

TEST(Tmc222, target_moved_behind_it_is_reached_by_way_of_a_stop) {
  Bench bench;
  bench.go(16'000);
  bench.run_for(500ms);
  bench.go(-100);
  bench.run_to_rest();
  EXPECT_EQ(bench.chip.actual(), -100);
  EXPECT_EQ(bench.chip.field(), -100);
  EXPECT_FALSE(bench.status1().flags.step_loss);
}

TEST(Tmc222, position_is_reached_the_short_way_round) {
  Bench bench;
  bench.go(30'000);
  bench.run_to_rest();
  bench.go(-30'000);
  bench.run_to_rest();
  EXPECT_EQ(bench.chip.actual(), -30'000);
  EXPECT_EQ(bench.chip.field(), 30'000 + 5'536) << "over the wrap";
}

TEST(Tmc222, step_modes_scale_the_field_and_shaft_turns_it) {
  for (std::uint8_t mode = 0; mode < 4; ++mode) {
    Parameters parameters = icp::kMotorParameters;
    parameters.step_mode = mode;
    parameters.shaft = true;
    Bench bench(false, parameters);
    bench.go(10);
    bench.run_to_rest();
    EXPECT_EQ(bench.chip.field(), -10 * (8 >> mode));
  }
}

TEST(Tmc222, reset_position_is_ignored_in_motion_and_never_turns_the_field) {
  Bench bench;
  bench.go(1600);
  bench.run_for(20ms);
  bench.send(ResetPosition{});
  EXPECT_GT(bench.chip.actual(), 0);
  bench.run_to_rest();
  bench.send(ResetPosition{});
  EXPECT_EQ(bench.chip.actual(), 0);
  EXPECT_EQ(bench.chip.field(), 1600);
}

TEST(Tmc222, soft_stop_loses_nothing_and_hard_stop_blocks_until_a_status) {
  Bench soft;
  soft.go(16'000);
  soft.run_for(100ms);
  soft.send(SoftStop{});
  soft.run_to_rest();
  EXPECT_EQ(soft.chip.actual(), soft.chip.target());
  EXPECT_EQ(soft.chip.actual(), soft.chip.field());
  EXPECT_FALSE(soft.status1().flags.step_loss);
  Bench hard;
  hard.go(16'000);
  hard.run_for(100ms);
  hard.send(HardStop{});
  EXPECT_FALSE(hard.chip.moving());
  hard.go(5);
  hard.send(GotoSecurePosition{});
  EXPECT_FALSE(hard.chip.moving()) << "blocked";
  EXPECT_TRUE(hard.status1().flags.step_loss);
  hard.go(5);
  EXPECT_TRUE(hard.chip.moving()) << "a status enables it again";
  Bench resting;
  resting.send(HardStop{});
  EXPECT_FALSE(resting.status1().flags.step_loss) << "nothing moved";
}

TEST(Tmc222, secure_position_0_is_a_place_and_400_is_none) {
  Bench bench;
  bench.go(100);
  bench.run_to_rest();
  Parameters off = icp::kMotorParameters;
  off.secure_position = kSecurePositionOff;
  bench.send(SetMotorParam{off});
  bench.send(GotoSecurePosition{});
  EXPECT_FALSE(bench.chip.moving());
  bench.send(SetMotorParam{icp::kMotorParameters});
  bench.send(GotoSecurePosition{});
  bench.run_to_rest();
  EXPECT_EQ(bench.chip.actual(), 0);
}

TEST(Tmc222, run_init_makes_both_ways_and_ends_at_zero) {
  Bench bench;
  bench.send(RunInit{15, 15, -160, -320});
  bench.go(50);
  EXPECT_EQ(bench.chip.target(), -160) << "only a hard stop interrupts it";
  bench.run_to_rest();
  EXPECT_EQ(bench.chip.field(), -320);
  EXPECT_EQ(bench.chip.actual(), 0);
  EXPECT_EQ(bench.chip.target(), 0);
}

TEST(Tmc222, run_init_from_its_own_first_target_hangs_until_a_hard_stop) {
  Bench bench;
  bench.send(RunInit{15, 15, 0, 100});
  EXPECT_TRUE(bench.chip.moving());
  EXPECT_FALSE(bench.chip.next_event());
  bench.run_for(60s);
  EXPECT_TRUE(bench.chip.moving());
  bench.send(HardStop{});
  EXPECT_FALSE(bench.chip.moving());
}

TEST(Tmc222, brown_out_leaves_the_otp_defaults_and_vdd_reset) {
  Bench bench;
  bench.go(16'000);
  bench.run_for(100ms);
  bench.chip.set_supply(4, bench.now);
  EXPECT_FALSE(bench.send(GetFullStatus1{})) << "no acknowledge without a supply";
  bench.chip.set_supply(12, bench.now);
  const Status1 status = bench.status1();
  EXPECT_TRUE(status.flags.vdd_reset);
  EXPECT_EQ(status.parameters, Parameters{});
  bench.go(1);
  EXPECT_FALSE(bench.chip.moving());
}

TEST(Tmc222, under_voltage_in_motion_is_a_hard_stop_without_current) {
  Bench bench;
  bench.go(16'000);
  bench.run_for(100ms);
  bench.chip.set_supply(7.4, bench.now);
  EXPECT_EQ(bench.chip.state(), State::kShutdown);
  Status1 status = bench.status1();
  EXPECT_TRUE(status.flags.under_voltage && status.flags.step_loss);
  EXPECT_EQ(bench.chip.state(), State::kShutdown) << "it is still low";
  bench.chip.set_supply(12, bench.now);
  status = bench.status1();
  EXPECT_TRUE(status.flags.under_voltage);
  EXPECT_FALSE(bench.status1().flags.under_voltage);
  EXPECT_EQ(bench.chip.state(), State::kStopped);
}

TEST(Tmc222, heat_warns_and_then_shuts_down) {
  Bench bench;
  bench.chip.set_temperature(150, bench.now);
  Status1 status = bench.status1();
  EXPECT_TRUE(status.flags.thermal_warning);
  EXPECT_EQ(status.flags.temperature, 2);
  EXPECT_FALSE(status.flags.thermal_shutdown);
  bench.chip.set_temperature(156, bench.now);
  status = bench.status1();
  EXPECT_TRUE(status.flags.thermal_shutdown);
  EXPECT_EQ(status.flags.temperature, 3);
  bench.go(1);
  EXPECT_FALSE(bench.chip.moving());
}

TEST(Tmc222, broken_coil_is_an_electrical_defect) {
  Bench bench;
  bench.chip.set_coil_fault(true, bench.now);
  EXPECT_TRUE(bench.status1().flags.electrical_defect);
  bench.go(1);
  EXPECT_FALSE(bench.chip.moving());
}

TEST(Tmc222, position_that_a_coarser_step_mode_cannot_hold_wraps_with_it) {
  Bench bench;
  bench.go(10'000);
  bench.run_to_rest();
  bench.send(ResetToDefault{});
  EXPECT_EQ(bench.chip.actual(), 10'000 - 8'192);
  EXPECT_EQ(bench.chip.target(), bench.chip.actual());
  EXPECT_FALSE(bench.chip.moving());
}

TEST(Tmc222, current_is_what_its_codes_say) {
  Parameters parameters = icp::kMotorParameters;
  parameters.hold_current = 0;
  Bench bench(false, parameters);
  EXPECT_EQ(bench.chip.current(), 59);
  bench.go(100);
  EXPECT_EQ(bench.chip.current(), 566);
}

TEST(Tmc222, any_commands_at_any_time_keep_field_and_position_in_step) {
  test::for_random_cases(500, [](test::Random& random) {
    Bench bench;
    std::int64_t zero = 0;  // field at position 0
    const test::AllocationCounter allocations;
    for (int i = 0; i < 60; ++i) {
      const bool rests = !bench.chip.moving();
      switch (random.integer(0, 5)) {
        case 0:
          bench.send(ResetPosition{});
          if (rests) zero = bench.chip.field();
          break;
        case 1:
          bench.send(SoftStop{});
          break;
        case 2:
          bench.send(HardStop{});
          break;
        case 3:
          bench.send(GetFullStatus1{});
          break;
        default:
          bench.go(static_cast<std::int16_t>(random.integer(-32768, 32767)));
      }
      bench.run_for(Duration{random.integer(0, 300'000'000)});
      EXPECT_EQ(wrapped(bench.chip.field() - zero, 3), bench.chip.actual());
    }
    EXPECT_EQ(allocations.count(), 0U);
    bench.send(GetFullStatus1{});
    bench.run_to_rest();
    EXPECT_EQ(bench.chip.actual(), bench.chip.target());
  });
}

}  // namespace
}  // namespace sinew
