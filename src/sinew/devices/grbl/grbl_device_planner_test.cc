#include "sinew/devices/grbl/grbl_device_planner.h"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "support/property.h"

namespace sinew::grbl {
namespace {

using test::Random;

constexpr double kTick = 1e-3;

std::vector<AxisRates> axes_of(std::size_t count, double rate = 90, double acceleration = 400) {
  return std::vector<AxisRates>(count, {rate, acceleration});
}

Values at(std::initializer_list<double> values) {
  Values all;
  for (const double one : values) all.push_back(one);
  return all;
}

/// Until it is empty. @return  s
double time_of(Planner& planner) {
  double time = 0;
  while (!planner.empty() && time < 100) {
    planner.advance(kTick / 10);
    time += kTick / 10;
  }
  return time;
}

TEST(GrblPlanner, one_motion_is_a_trapezoid) {
  Planner planner(axes_of(2), 0.01);
  planner.push(at({30, 0}), 1);  // 30 units/s, 75 ms of ramp at each end
  EXPECT_NEAR(time_of(planner), 1 + 30.0 / 400, 1e-3);
  EXPECT_NEAR(planner.position()[0], 30, 1e-9);
}

TEST(GrblPlanner, an_axis_that_is_not_fast_enough_makes_the_motion_longer) {
  Planner planner(axes_of(2), 0.01);
  planner.push(at({90, 45}), 0.1);
  EXPECT_NEAR(time_of(planner), 1 + 90.0 / 400, 2e-3);
}

TEST(GrblPlanner, what_is_no_way_is_no_motion) {
  Planner planner(axes_of(2), 0.01);
  planner.push(at({0, 0}), 1);
  EXPECT_TRUE(planner.empty());
}

TEST(GrblPlanner, a_straight_path_in_pieces_takes_as_long_as_in_one) {
  Planner planner(axes_of(2), 0.01);
  for (int i = 1; i <= 10; ++i) planner.push(at({3.0 * i, 1.5 * i}), 0.1);
  EXPECT_NEAR(time_of(planner), 1 + std::hypot(30, 15) / 447, 3e-3);
}

TEST(GrblPlanner, it_turns_back_at_rest_and_passes_a_corner_by_the_deviation) {
  const auto speed_at_corner = [](const Values& second) {
    Planner planner(axes_of(2), 0.05);
    planner.push(at({30, 0}), 0.5);
    planner.push(second, 0.5);
    double speed = 0;
    while (planner.size() == 2) {
      speed = planner.speed();
      planner.advance(kTick / 10);
    }
    return speed;
  };
  EXPECT_LT(speed_at_corner(at({0, 0})), 0.3);
  // At a right angle: v^2 = a d sin(45) / (1 - sin(45)), a along the change of direction.
  const double sine = std::sqrt(0.5);
  const double a = 400 / sine;
  EXPECT_NEAR(speed_at_corner(at({30, 30})), std::sqrt(a * 0.05 * sine / (1 - sine)), 0.3);
}

TEST(GrblPlanner, whatever_waits_it_can_brake_at_the_end_and_no_axis_is_too_fast) {
  test::for_random_cases(500, [](Random& random) {
    const auto count = static_cast<std::size_t>(random.integer(1, 6));
    std::vector<AxisRates> axes;
    for (std::size_t i = 0; i < count; ++i) {
      axes.push_back({random.uniform(10, 200), random.uniform(50, 2000)});
    }
    Planner planner(axes, random.uniform(0.002, 0.2));
    Values to;
    to.resize(count);
    int pushed = 0;
    double before = 0;
    while (pushed < 40 || !planner.empty()) {
      if (pushed < 40 && !planner.full() && random.chance(0.1)) {
        for (double& one : to) one += random.uniform(-5, 5);
        planner.push(to, random.uniform(0.01, 0.3));
        ++pushed;
      }
      if (random.chance(0.002)) planner.hold();
      if (random.chance(0.02)) planner.resume();
      planner.advance(kTick);
      for (std::size_t i = 0; i < count; ++i) {
        ASSERT_LE(std::abs(planner.velocity(i)), axes[i].rate * (1 + 1e-9));
      }
      // On the path it brakes no harder than its strongest direction can.
      double most = 0;
      for (const AxisRates& axis : axes) most += axis.acceleration;
      ASSERT_LE(before - planner.speed(), most * std::sqrt(count) * kTick + 1e-9);
      before = planner.speed();
      if (planner.held() && planner.empty()) planner.resume();
    }
    for (std::size_t i = 0; i < count; ++i) ASSERT_NEAR(planner.position()[i], to[i], 1e-9);
    ASSERT_EQ(planner.speed(), 0);
  });
}

TEST(GrblPlanner, a_hold_keeps_the_path_and_what_waits) {
  Planner planner(axes_of(2), 0.01);
  planner.push(at({30, 15}), 1);
  planner.push(at({60, 30}), 1);
  for (int i = 0; i < 990; ++i) planner.advance(kTick);
  planner.hold();
  for (int i = 0; i < 500; ++i) planner.advance(kTick);
  EXPECT_TRUE(planner.at_rest());
  const Values there = planner.position();
  EXPECT_NEAR(there[0], 2 * there[1], 1e-9);
  planner.resume();
  time_of(planner);
  EXPECT_NEAR(planner.position()[0], 60, 1e-9);
}

}  // namespace
}  // namespace sinew::grbl
