#include "sinew/planning/studies/drive_train.h"

#include <gtest/gtest.h>

#include <cmath>

#include "sinew/core/units.h"
#include "support/property.h"

namespace sinew::planning {
namespace {

StepperDrive shoulder() {
  StepperDrive drive;
  drive.holding_torque = 1.89;
  drive.motors = 2;
  drive.gear_ratio = 17;
  drive.gear_efficiency = 0.7;
  drive.rotor_inertia = 48e-6;
  drive.corner_speed = 54;
  drive.coulomb_friction = 1.2;
  drive.viscous_friction = 0.7;
  return drive;
}

StepperDrive random_drive(test::Random& random) {
  StepperDrive drive;
  drive.holding_torque = random.uniform(0.1, 5);
  drive.motors = static_cast<int>(random.integer(1, 3));
  drive.gear_ratio = random.uniform(1, 60);
  drive.gear_efficiency = random.uniform(0.4, 1);
  drive.rotor_inertia = random.uniform(0, 1e-4);
  drive.corner_speed = random.uniform(20, 120);
  drive.coulomb_friction = random.uniform(0, 2);
  drive.viscous_friction = random.uniform(0, 2);
  return drive;
}

TEST(DriveTrain, gives_motor_times_motors_times_ratio_times_efficiency_up_to_the_corner) {
  const DriveTrain train(shoulder());
  EXPECT_NEAR(train.available(0), 1.89 * 2 * 17 * 0.7, 1e-12);
  EXPECT_NEAR(train.available(54.0 / 17), 1.89 * 2 * 17 * 0.7, 1e-9);
  EXPECT_NEAR(train.available(-2 * 54.0 / 17), 1.89 * 17 * 0.7, 1e-9);
}

TEST(DriveTrain, driving_against_a_load_costs_the_load_friction_and_the_rotors) {
  const DriveTrain train(shoulder());
  // 2 x 48e-6 x 17^2 x 0.7 = 0.0194 kg m^2.
  EXPECT_NEAR(train.demand({20, 0.5, 3}), 20 + 1.2 + 0.35 + 3 * 0.01942080, 1e-9);
  EXPECT_NEAR(train.demand({-20, -0.5, -3}), 20 + 1.2 + 0.35 + 3 * 0.01942080, 1e-9);
}

TEST(DriveTrain, losses_of_the_gear_help_a_motor_that_is_driven) {
  StepperDrive drive = shoulder();
  drive.coulomb_friction = drive.viscous_friction = 0;
  // Lowering 20 Nm: the motor sees 20 / 17 x (2 - 1 / 0.7), counted as times 17 x 0.7.
  EXPECT_NEAR(DriveTrain(drive).demand({20, -0.5, 0}), 20 * (2 - 1 / 0.7) * 0.7, 1e-12);
  // A gear that locks itself has to be pushed down.
  drive.gear_efficiency = 0.4;
  EXPECT_NEAR(DriveTrain(drive).demand({20, -0.5, 0}), 20 * (1 / 0.4 - 2) * 0.4, 1e-12);
}

TEST(DriveTrain, gear_and_friction_take_power_whichever_way_it_flows) {
  test::for_random_cases(5'000, [](test::Random& random) {
    StepperDrive drive = random_drive(random);
    drive.gear_efficiency = random.uniform(0.5, 1);
    const double torque = random.uniform(0, 50), speed = random.uniform(0.01, 3);
    const auto motor_power = [&](double velocity) {
      return DriveTrain(drive).demand({torque, velocity, 0}) / drive.gear_efficiency * speed;
    };
    EXPECT_GE(motor_power(speed), torque * speed);  // lifting
    drive.coulomb_friction = drive.viscous_friction = 0;
    EXPECT_LE(motor_power(-speed), torque * speed);  // lowering: the rest is heat in the gear
  });
}

TEST(DriveTrain, servo_gives_a_straight_line_from_stall_to_no_load) {
  const DriveTrain train(ServoRating{1.7, 6, 0.1});
  EXPECT_NEAR(train.available(0), 1.7, 1e-12);
  EXPECT_NEAR(train.available(-3), 0.85, 1e-12);
  EXPECT_EQ(train.available(7), 0);
  EXPECT_NEAR(train.demand({-0.5, 0, 0}), 0.6, 1e-12);
  EXPECT_NEAR(train.demand({-0.5, 1, 0}), 0.4, 1e-12);
  EXPECT_FALSE(train.ratio_for({1, 1, 1}, 5000).has_value());
}

TEST(DriveTrain, ratio_that_does_just_does_and_a_smaller_one_does_not) {
  int found = 0, none = 0;
  test::for_random_cases(5'000, [&](test::Random& random) {
    StepperDrive drive = random_drive(random);
    const double torque = random.uniform(0, 100);
    const JointDuty duty{torque, random.uniform(0.01, 3), random.uniform(0, 20)};
    const auto answer = DriveTrain(drive).ratio_for(duty, 5000);
    ASSERT_TRUE(answer.has_value());
    const auto does = [&](double ratio) {
      drive.gear_ratio = ratio;
      const DriveTrain train(drive);
      return train.demand(duty) <= train.available(duty.velocity) * (1 + 1e-9);
    };
    if (answer->lowest) {
      ++found;
      EXPECT_TRUE(does(*answer->lowest));
      EXPECT_FALSE(does(*answer->lowest * 0.999));
    } else {
      ++none;
      // Brute force over every ratio agrees that none does.
      for (double ratio = 0.01; ratio < 1e5; ratio *= 1.05) EXPECT_FALSE(does(ratio)) << ratio;
    }
  });
  EXPECT_GT(found, 1000);
  EXPECT_GT(none, 100);
}

TEST(DriveTrain, steps_a_second_bound_the_ratio_for_a_speed) {
  const DriveTrain train(shoulder());
  const double velocity = from_deg(29.5);
  const auto answer = train.ratio_for({40, velocity, 0.17}, 5000);
  ASSERT_TRUE(answer && answer->highest_for_speed);
  // 5000 steps of 3200 a turn: 562.5 deg/s at the motor.
  EXPECT_NEAR(*answer->highest_for_speed, 562.5 / 29.5, 1e-9);
  EXPECT_NEAR(train.velocity_at(5000, *answer->highest_for_speed), velocity, 1e-12);
  EXPECT_FALSE(train.ratio_for({40, velocity, 0.17}, 0)->highest_for_speed.has_value());
}

}  // namespace
}  // namespace sinew::planning
