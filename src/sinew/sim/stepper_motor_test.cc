#include "sinew/sim/stepper_motor.h"

#include <gtest/gtest.h>

#include <cmath>

#include "sinew/core/units.h"
#include "support/property.h"

namespace sinew::sim {
namespace {

constexpr double kTick = 1e-3;  // s

StepperDrive drive() {
  StepperDrive drive;
  drive.holding_torque = 1.26;
  drive.rotor_inertia = 3e-5;
  drive.corner_speed = 60;
  return drive;
}

void turn_at(StepperMotor& motor, double speed, double seconds, double load = 0) {
  for (int i = 0; i < static_cast<int>(seconds / kTick); ++i) {
    motor.advance(speed * kTick, load, 0, 0, kTick);
  }
}

TEST(StepperMotor, follows_its_field_and_comes_to_rest_on_it) {
  StepperMotor motor(drive(), 6e-5);
  turn_at(motor, 5, 2);
  turn_at(motor, 0, 1);
  EXPECT_NEAR(motor.angle(), 10, 1e-3);
  EXPECT_NEAR(motor.speed(), 0, 1e-3);
  EXPECT_FALSE(motor.slipped());
}

TEST(StepperMotor, under_load_it_trails_by_the_angle_whose_sine_carries_it) {
  StepperMotor motor(drive(), 6e-5);
  turn_at(motor, 0, 1, -0.63);
  EXPECT_NEAR(std::sin(50 * (motor.field() - motor.angle())), 0.5, 1e-2);
}

TEST(StepperMotor, load_beyond_its_torque_pulls_it_through) {
  StepperMotor motor(drive(), 6e-5);
  turn_at(motor, 0, 0.2, -1.3);
  EXPECT_TRUE(motor.slipped());
  EXPECT_LT(motor.angle(), -2 * kPi / 50);
}

TEST(StepperMotor, blocked_rotor_loses_whole_electrical_turns) {
  StepperMotor motor(drive(), 6e-5);
  for (int i = 0; i < 1000; ++i) {  // friction stronger than the motor: it cannot turn
    motor.advance(5 * kTick, 0, 10, 0, kTick);
  }
  EXPECT_TRUE(motor.slipped());
  EXPECT_NEAR(motor.angle(), 0, 0.02);
  EXPECT_LT(std::abs(motor.field() - motor.angle()), kPi / 50 + 1e-9);
}

TEST(StepperMotor, torque_falls_beyond_the_corner_speed) {
  const auto speed_up_to = [](StepperMotor& motor, double speed) {
    for (int i = 0; i * 0.05 < speed; ++i) motor.advance(i * 0.05 * kTick, -0.8, 0, 0, kTick);
  };
  StepperMotor slow(drive(), 6e-5);
  speed_up_to(slow, 50);
  EXPECT_FALSE(slow.slipped());
  StepperMotor fast(drive(), 6e-5);
  speed_up_to(fast, 150);
  EXPECT_TRUE(fast.slipped());
}

TEST(StepperMotor, power_up_snaps_to_the_next_home_phase_within_two_full_steps) {
  test::for_random_cases(2'000, [](test::Random& random) {
    const double start = random.uniform(-10, 10);
    StepperMotor motor(drive(), 6e-5, start);
    motor.set_power(false);
    turn_at(motor, 0, 0.1);
    const double before = motor.angle();
    motor.set_power(true);
    turn_at(motor, 0, 0.5);
    const double full_step = 2 * kPi / 200;
    EXPECT_LE(std::abs(motor.angle() - before), 2 * full_step + 1e-3);
    EXPECT_NEAR(std::remainder(motor.angle(), 4 * full_step), 0, 2e-3);
  });
}

TEST(StepperMotor, going_to_the_other_pole_at_power_up_is_no_lost_step) {
  // All but half way between two poles, where a load decides.
  const double electrical = 2 * kPi / 50;
  StepperMotor motor(drive(), 6e-5, 0.499 * electrical);
  motor.set_power(false);
  motor.set_power(true);
  turn_at(motor, 0, 0.5, 0.03);
  EXPECT_NEAR(motor.angle(), electrical, 0.1 * electrical);
  EXPECT_FALSE(motor.slipped());
  // From then on a lost step is one.
  turn_at(motor, 0, 0.5, 3);
  EXPECT_TRUE(motor.slipped());
}

TEST(StepperMotor, without_current_a_load_turns_it_and_its_steps_do_nothing) {
  StepperMotor motor(drive(), 6e-5);
  motor.set_power(false);
  turn_at(motor, 5, 0.5);
  EXPECT_NEAR(motor.angle(), 0, 1e-6);
  turn_at(motor, 0, 0.5, -0.2);
  EXPECT_LT(motor.angle(), -1);
}

}  // namespace
}  // namespace sinew::sim
