#include "sinew/sim/servo_motor.h"

#include <gtest/gtest.h>

#include <cmath>

namespace sinew::sim {
namespace {

void run(ServoMotor& servo, double target, double seconds, double load = 0, bool driven = true) {
  for (int i = 0; i < static_cast<int>(seconds * 100); ++i) {
    servo.advance(target, driven, load, 0.01);
  }
}

TEST(ServoMotor, comes_to_its_target_within_its_dead_band) {
  ServoMotor servo({});
  run(servo, 1.0, 2);
  EXPECT_NEAR(servo.angle(), 1.0, 0.01);
  EXPECT_EQ(servo.speed(), 0);
}

TEST(ServoMotor, is_no_faster_than_its_motor) {
  ServoMotor servo({});
  run(servo, 2.0, 0.1);
  EXPECT_LT(servo.angle(), 0.62);
  EXPECT_GT(servo.angle(), 0.2);
}

TEST(ServoMotor, load_bends_it_and_too_much_load_turns_it_back) {
  ServoMotor light({});
  run(light, 1.0, 3, -0.5);
  EXPECT_NEAR(light.angle(), 1.0, 0.03);
  EXPECT_LT(light.angle(), 0.999);
  ServoMotor heavy({});
  run(heavy, 1.0, 3, -2.5);
  EXPECT_LT(heavy.angle(), 0);
}

TEST(ServoMotor, low_supply_makes_it_weak_and_then_sleepy) {
  ServoMotor weak({});
  weak.set_supply_ratio(0.6);
  run(weak, 1.0, 3, -1.2);
  EXPECT_LT(weak.angle(), 0.5);
  ServoMotor asleep({});
  asleep.set_supply_ratio(0.4);
  run(asleep, 1.0, 3);
  EXPECT_EQ(asleep.angle(), 0);
}

TEST(ServoMotor, friction_holds_it_without_pulses_and_a_load_overcomes_it) {
  ServoMotor held({}, 0.3);
  run(held, -1, 3, 0.1, false);
  EXPECT_EQ(held.angle(), 0.3);
  ServoMotor falling({}, 0.3);
  run(falling, -1, 1, 0.5, false);
  EXPECT_GT(falling.angle(), 0.5);
}

TEST(ServoMotor, a_thing_in_the_way_stops_it_with_full_effort) {
  ServoMotor servo({});
  servo.block_above(0.4);
  run(servo, 1.0, 2);
  EXPECT_EQ(servo.angle(), 0.4);
  EXPECT_TRUE(servo.at_end());
  EXPECT_NEAR(servo.effort(), 1, 1e-9);
  servo.unblock();
  run(servo, 1.0, 2);
  EXPECT_NEAR(servo.angle(), 1.0, 0.01);
}

}  // namespace
}  // namespace sinew::sim
