#include "sinew/devices/axis/axis_machine_plant.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "support/allocation_guard.h"
#include "support/property.h"
#include "support/robots.h"

namespace sinew::sim {
namespace {

constexpr double kTick = 1e-3;  // s
constexpr double kStepsPerRad = 200 * 16 * 17 / (2 * kPi);
constexpr double kShoulderInertia = 1.0;  // kg m^2

AxisPlantSettings shoulder() {
  AxisPlantSettings settings;
  settings.drive = test::robot("robot-arm-2").dynamics.drives[1];
  settings.end_lower = from_deg(-95);
  settings.end_upper = from_deg(95);
  settings.switch_angle = from_deg(-91);
  return settings;
}

/// A plant with the most patient of controllers: ramps of its own, nothing measured.
struct Bench {
  explicit Bench(const AxisPlantSettings& settings = shoulder(), double q = 0,
                 std::uint64_t seed = 1)
      : plant(settings, q, seed) {
    plant.set_load(0, kShoulderInertia);
  }

  void wait(double seconds) {
    for (auto i = std::llround(seconds / kTick); i > 0; --i) plant.advance(outputs, kTick);
  }
  void power() {
    outputs.enabled = true;
    wait(0.5);
  }
  /// Smoothly by `turn` (rad) in `seconds`.
  void turn(double turn, double seconds) {
    const std::int64_t start = outputs.steps;
    const auto ticks = std::llround(seconds / kTick);
    for (std::int64_t i = 1; i <= ticks; ++i) {
      const double u = static_cast<double>(i) / static_cast<double>(ticks);
      const double share = u * u * u * (10 - 15 * u + 6 * u * u);
      outputs.steps = start + std::llround(turn * share * kStepsPerRad);
      plant.advance(outputs, kTick);
    }
  }

  AxisPlant plant;
  AxisOutputs outputs;
};

TEST(AxisPlant, joint_follows_the_steps_within_backlash_and_windup) {
  Bench bench;
  bench.power();
  const double start = bench.plant.q();
  bench.turn(from_deg(40), 4);
  bench.wait(0.5);
  EXPECT_NEAR(bench.plant.q() - start, from_deg(40), from_deg(0.2 + 0.1));
  EXPECT_FALSE(bench.plant.stalled());
}

TEST(AxisPlant, backlash_is_a_gap_that_a_reversal_has_to_cross) {
  Bench bench;
  bench.power();
  bench.turn(from_deg(10), 2);
  bench.wait(0.3);
  const double reversal = bench.plant.q();
  bench.turn(from_deg(-0.15), 0.5);  // friction holds the joint while the rotor crosses the gap
  EXPECT_NEAR(bench.plant.q(), reversal, from_deg(0.02));
  bench.turn(from_deg(-9.85), 2);
  bench.wait(0.3);
  const double lost = bench.plant.q() - (reversal - from_deg(10));
  EXPECT_NEAR(lost, from_deg(0.2), from_deg(0.05));
}

TEST(AxisPlant, lifts_what_the_torque_table_says_and_stalls_above) {
  const double stall = 1.89 * 2 * 17 * 0.7;  // 45 Nm
  for (const bool too_much : {false, true}) {
    Bench bench;
    bench.power();
    bench.plant.set_load(-(too_much ? 1.1 : 0.85) * stall, kShoulderInertia);
    bench.wait(0.5);
    bench.turn(from_deg(20), 8);
    bench.wait(0.5);
    EXPECT_EQ(bench.plant.stalled(), too_much);
    if (too_much) continue;
    EXPECT_NEAR(bench.plant.q(), from_deg(20), from_deg(2));
  }
}

TEST(AxisPlant, gear_that_holds_needs_less_than_it_lifts) {
  // 1.1 times what it can lift is held: friction helps then.
  Bench bench;
  bench.power();
  const double held = bench.plant.q();
  bench.plant.set_load(-1.1 * 1.89 * 2 * 17 * 0.7, kShoulderInertia);
  bench.wait(2);
  EXPECT_FALSE(bench.plant.stalled());
  EXPECT_NEAR(bench.plant.q(), held, from_deg(0.6));
}

TEST(AxisPlant, without_current_a_heavy_arm_falls_on_its_end_and_a_light_one_stays) {
  Bench heavy;
  heavy.plant.set_load(-25, kShoulderInertia);
  heavy.wait(10);
  EXPECT_TRUE(heavy.plant.at_end());
  EXPECT_NEAR(heavy.plant.q(), from_deg(-95), from_deg(0.2));
  EXPECT_TRUE(heavy.plant.inputs().end_stop);

  Bench light;
  light.plant.set_load(-1, kShoulderInertia);
  light.wait(10);
  EXPECT_NEAR(light.plant.q(), 0, from_deg(0.3));
}

TEST(AxisPlant, steps_into_a_thing_in_the_way_lose_whole_electrical_turns) {
  Bench bench;
  bench.power();
  bench.plant.block(from_deg(5));
  bench.turn(from_deg(30), 4);
  EXPECT_LT(bench.plant.q(), from_deg(5.3));
  EXPECT_TRUE(bench.plant.stalled());
  bench.plant.unblock();
  bench.wait(0.5);
  const double freed = bench.plant.q();
  bench.turn(from_deg(10), 3);
  bench.wait(0.5);
  EXPECT_NEAR(bench.plant.q() - freed, from_deg(10), from_deg(0.5));  // it goes on, but elsewhere
}

TEST(AxisPlant, end_stop_bounces_and_then_says_where_the_joint_is) {
  AxisPlantSettings settings = shoulder();
  settings.switch_angle = from_deg(-5);
  Bench bench(settings);
  bench.power();
  int changes = 0;
  bool level = bench.plant.inputs().end_stop;
  ASSERT_FALSE(level);
  for (int i = 0; i < 5000; ++i) {
    bench.outputs.steps -= 5;
    bench.plant.advance(bench.outputs, kTick);
    const bool now = bench.plant.inputs().end_stop;
    changes += now != level ? 1 : 0;
    level = now;
    if (bench.plant.q() < from_deg(-5.2)) break;
  }
  EXPECT_TRUE(level);
  EXPECT_EQ(changes % 2, 1);
  bench.turn(from_deg(1), 1);
  EXPECT_FALSE(bench.plant.inputs().end_stop);
}

TEST(AxisPlant, brown_out_takes_the_current_and_power_up_snaps_by_two_full_steps_at_most) {
  test::for_random_cases(100, [](test::Random& random) {
    Bench bench(shoulder(), random.uniform(-1, 1), random.bits());
    bench.power();
    bench.turn(random.uniform(-0.2, 0.2), 0.5);
    bench.wait(0.3);
    bench.plant.set_supply(5);
    bench.wait(0.3);
    EXPECT_FALSE(bench.plant.powered());
    const double before = bench.plant.motor_angle();
    bench.plant.set_supply(24);
    bench.plant.reboot();
    bench.outputs.steps = 0;
    bench.wait(0.5);
    EXPECT_LE(std::abs(bench.plant.motor_angle() - before), 2 * from_deg(1.8) + 0.01);
  });
}

TEST(AxisPlant, low_supply_costs_torque_at_speed_and_none_at_rest) {
  for (const double volts : {24.0, 11.0}) {
    Bench bench;
    bench.power();
    bench.plant.set_supply(volts);
    bench.plant.set_load(-20, kShoulderInertia);
    bench.wait(1);
    EXPECT_FALSE(bench.plant.stalled()) << volts;
    bench.turn(from_deg(80), 0.8);  // 190 deg/s at most, 55 rad/s at the motor
    EXPECT_EQ(bench.plant.stalled(), volts < 24) << volts;
  }
}

TEST(AxisPlant, energy_never_comes_from_nowhere) {
  // Unpowered pendulum between its ends, with every loss but one: kinetic + weight only falls.
  test::for_random_cases(50, [](test::Random& random) {
    AxisPlantSettings settings = shoulder();
    settings.drive.coulomb_friction *= random.uniform(0, 1);
    settings.drive.holding_torque = 1e-6;           // and a motor without magnets
    settings.windup = from_deg(0.1) * 1e-6 / 1.89;  // keeps the gear's stiffness
    Bench bench(settings, random.uniform(-1.2, 1.2));
    const double moment = random.uniform(1, 3);  // kg m
    const auto energy = [&] {
      return bench.plant.mechanical_energy() + moment * 9.81 * std::cos(bench.plant.q());
    };
    double last = energy();
    const double start = last;
    for (int i = 0; i < 5000; ++i) {
      bench.plant.set_load(moment * 9.81 * std::sin(bench.plant.q()), kShoulderInertia);
      bench.plant.advance(bench.outputs, kTick);
      if (bench.plant.at_end()) continue;  // looked at again when it has bounced off
      const double now = energy();
      // Load is held for a tick: half of a tick's work is the error of that. A millijoule is the
      // integration's share of 15 J.
      const double slack = 0.5 * moment * 9.81 * std::pow(bench.plant.qd() * kTick, 2) + 1e-3;
      ASSERT_LE(now, last + slack) << "at " << i << " ms";
      last = std::min(last, now);
    }
    EXPECT_LE(last, start);
  });
}

TEST(AxisPlant, frictionless_pendulum_keeps_its_energy) {
  AxisPlantSettings settings = shoulder();
  settings.drive.coulomb_friction = settings.drive.viscous_friction = 0;
  settings.drive.gear_efficiency = 1;
  settings.drive.holding_torque = 1e-6;
  settings.drive.backlash = 0;
  settings.windup = from_deg(0.1) * 1e-6 / 1.89;
  Bench bench(settings, from_deg(170));
  // Hangs, so that it swings about pi: the ends are out of the way.
  settings.end_lower = from_deg(0);
  settings.end_upper = from_deg(360);
  bench.plant = AxisPlant(settings, from_deg(120), 1);
  constexpr double kMoment = 2;  // kg m
  const auto energy = [&] {
    return bench.plant.mechanical_energy() + kMoment * 9.81 * std::cos(bench.plant.q());
  };
  constexpr double kShort = 1e-4;  // s, so that the load held for a tick does no work of its own
  const double start = energy();
  double swing = 0;
  for (int i = 0; i < 50'000; ++i) {
    bench.plant.set_load(kMoment * 9.81 * std::sin(bench.plant.q()), kShoulderInertia);
    bench.plant.advance(bench.outputs, kShort);
    swing = std::max(swing, bench.plant.mechanical_energy());
  }
  EXPECT_GT(swing, 5);
  EXPECT_NEAR(energy(), start, 0.02 * swing);
}

TEST(AxisPlant, encoders_tell_the_turn_of_motor_and_joint) {
  Bench bench;
  bench.power();
  const AxisInputs before = bench.plant.inputs();
  const double q = bench.plant.q();
  const double motor = bench.plant.motor_angle();
  bench.turn(from_deg(15), 3);
  bench.wait(0.5);
  const AxisInputs after = bench.plant.inputs();
  EXPECT_NEAR(after.joint_counts - before.joint_counts, (bench.plant.q() - q) / (2 * kPi) * 2400,
              1.01);
  const double turned = (bench.plant.motor_angle() - motor) / (2 * kPi) * 4096;
  EXPECT_NEAR(std::remainder(after.motor_counts - before.motor_counts - turned, 4096), 0, 3);
}

TEST(AxisPlant, absolute_joint_encoder_remembers_across_a_reboot_and_the_incremental_forgets) {
  for (const bool absolute : {true, false}) {
    AxisPlantSettings settings = shoulder();
    settings.joint_as5600 = absolute;
    Bench bench(settings, 0.5);
    bench.power();
    bench.turn(0.4, 1);
    bench.wait(0.5);
    const std::int32_t before = bench.plant.inputs().joint_counts;
    bench.plant.reboot();
    const std::int32_t after = bench.plant.inputs().joint_counts;
    EXPECT_NEAR(after, absolute ? before : 0, 1);
    EXPECT_NE(before, 0);
  }
}

TEST(AxisPlant, lost_magnet_is_told_and_the_angle_is_noise) {
  Bench bench;
  bench.power();
  bench.plant.set_field(0);
  bench.wait(0.01);
  EXPECT_FALSE(bench.plant.inputs().motor_encoder_ok);
  bench.plant.set_field(1);
  bench.wait(0.01);
  EXPECT_TRUE(bench.plant.inputs().motor_encoder_ok);
}

TEST(AxisPlant, motor_warms_up_while_it_is_held) {
  Bench bench;
  bench.power();
  bench.wait(1200);
  EXPECT_NEAR(bench.plant.inputs().temperature_c, 25 + 50 * (1 - std::exp(-1.0)), 0.5);
}

TEST(AxisPlant, comes_to_rest_and_rests_until_something_changes) {
  Bench bench;
  bench.power();
  bench.plant.set_load(-12, kShoulderInertia);
  bench.wait(2);
  EXPECT_TRUE(bench.plant.resting());
  const double q = bench.plant.q();
  bench.wait(1);
  EXPECT_EQ(bench.plant.q(), q);
  bench.plant.set_load(12, kShoulderInertia);
  bench.wait(0.01);
  EXPECT_FALSE(bench.plant.resting());
  bench.wait(2);
  EXPECT_GT(bench.plant.q(), q);
}

TEST(AxisPlant, same_seed_gives_the_same_run_and_nothing_allocates) {
  Bench first(shoulder(), 0.2, 9), second(shoulder(), 0.2, 9);
  const test::AllocationCounter allocations;
  for (Bench* bench : {&first, &second}) {
    bench->power();
    bench->turn(0.5, 1);
  }
  EXPECT_EQ(allocations.count(), 0U);
  EXPECT_EQ(first.plant.q(), second.plant.q());
  EXPECT_EQ(first.plant.inputs().motor_counts, second.plant.inputs().motor_counts);
}

TEST(AxisPlant, encoder_whose_coupling_slips_stands_still_and_goes_along_again_from_there) {
  for (const bool as5600 : {false, true}) {
    AxisPlantSettings settings = shoulder();
    settings.joint_as5600 = as5600;
    const double turn_counts = as5600 ? As5600::kTurn : Quadrature::kTurn;
    Bench bench(settings);
    bench.power();
    const auto counts = [&] { return static_cast<double>(bench.plant.inputs().joint_counts); };
    const double rest = counts();
    bench.plant.set_coupling(false);
    bench.turn(from_deg(10), 2);
    EXPECT_NEAR(counts(), rest, 3) << "of the noise";
    EXPECT_GT(bench.plant.q(), from_deg(9)) << "the joint goes on";
    EXPECT_TRUE(bench.plant.inputs().joint_encoder_ok) << "it does not know";
    bench.plant.set_coupling(true);
    const double held = bench.plant.q();
    bench.turn(from_deg(8), 2);
    bench.wait(0.5);
    const double moved = (bench.plant.q() - held) / (2 * kPi) * turn_counts;
    double told = counts() - rest;
    if (as5600 && told < 0) told += As5600::kTurn;
    EXPECT_NEAR(told, moved, 4);
  }
}

TEST(AxisPlant, finger_on_the_end_stop_closes_it_wherever_the_joint_is) {
  Bench bench;
  bench.plant.hold_switch(true);
  bench.wait(0.01);
  EXPECT_TRUE(bench.plant.inputs().end_stop);
  bench.plant.hold_switch(false);
  bench.wait(0.01);
  EXPECT_FALSE(bench.plant.inputs().end_stop);
}

}  // namespace
}  // namespace sinew::sim
