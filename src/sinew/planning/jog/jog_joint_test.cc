#include "sinew/planning/jog/jog_joint.h"

#include <gtest/gtest.h>

#include <cmath>

#include "sinew/motion/velocity_change.h"
#include "support/property.h"

namespace sinew::planning {
namespace {

using motion::AxisLimits;
using motion::AxisState;

struct RandomJoint {
  explicit RandomJoint(test::Random& random)
      : limits{std::pow(10, random.uniform(-2, 1)), std::pow(10, random.uniform(-2, 2)),
               std::pow(10, random.uniform(-1, 3))},
        range{-random.uniform(0.1, 3), random.uniform(0.1, 3)},
        joint(limits, range) {}
  AxisLimits limits;
  motion::PositionRange range;
  JogJoint joint;
};

TEST(JogJoint, any_reference_in_any_cycle_keeps_all_limits_and_leaves_room_to_stop) {
  test::for_random_cases(3000, [](test::Random& random) {
    RandomJoint some(random);
    const auto& [velocity, acceleration, jerk] = some.limits;
    AxisState state{random.uniform(some.range.lower, some.range.upper), 0, 0};
    if (random.chance(0.2)) state.q = some.range.upper;
    JointReference reference;
    for (int k = 0; k < 100; ++k) {
      if (k % 20 == 0) {
        reference.velocity = velocity * random.uniform(-3, 3);
        reference.rate = random.chance(0.5) ? 0 : acceleration * random.uniform(-2, 2);
      }
      const double dt = random.chance(0.5) ? 1e-3 : random.uniform(1e-5, 0.02);
      reference.velocity += reference.rate * dt;
      const AxisState next = some.joint.follow(state, reference, dt);
      ASSERT_LE(std::abs(next.qd), velocity * (1 + 1e-9));
      ASSERT_LE(std::abs(next.qdd), acceleration * (1 + 1e-9));
      ASSERT_LE(std::abs(next.qdd - state.qdd), jerk * dt * (1 + 1e-9) + 1e-12 * acceleration);
      const double ahead = state.q + dt * (state.qd + dt / 2 * state.qdd);
      ASSERT_LE(std::abs(next.q - ahead), jerk * dt * dt * dt / 6 * (1 + 1e-9) + 1e-13);
      const motion::PositionRange way = some.joint.stop(next).range();
      ASSERT_GE(way.lower, some.range.lower - 1e-9);
      ASSERT_LE(way.upper, some.range.upper + 1e-9);
      state = next;
    }
  });
}

TEST(JogJoint, steady_change_of_the_reference_is_followed_without_lag) {
  test::for_random_cases(2000, [](test::Random& random) {
    RandomJoint some(random);
    const auto& [velocity, acceleration, jerk] = some.limits;
    JogJoint joint(some.limits, {-1e6, 1e6});
    const double rate = 0.5 * acceleration * random.uniform(-1, 1);
    const double dt = 1e-3;
    // Long enough for the acceleration to gather, short enough for the velocity limit.
    const double seconds = std::min(3 * acceleration / jerk + 0.01, 0.9 * velocity / acceleration);
    if (seconds < 2.5 * acceleration / jerk) return random.discard();
    AxisState state;
    double wanted = 0;
    for (double t = dt; t < seconds; t += dt) {
      wanted = rate * t;
      state = joint.follow(state, {wanted, rate}, dt);
    }
    EXPECT_NEAR(state.qd, wanted, 1e-9 * velocity);
    EXPECT_NEAR(state.qdd, rate, 1e-9 * acceleration);
  });
}

TEST(JogJoint, constant_reference_is_reached_as_quickly_as_velocity_can_change) {
  test::for_random_cases(1000, [](test::Random& random) {
    RandomJoint some(random);
    JogJoint joint(some.limits, {-1e6, 1e6});
    const double wanted = some.limits.velocity * random.uniform(-1, 1);
    const double time =
        motion::VelocityChange({}, wanted, motion::ProfileBounds(some.limits)).profile().duration();
    AxisState state;
    const double dt = time / 50;
    for (int k = 0; k < 51; ++k) state = joint.follow(state, {wanted, 0}, dt);
    EXPECT_NEAR(state.qd, wanted, 1e-12 * some.limits.velocity);
    EXPECT_NEAR(state.qdd, 0, 1e-9 * some.limits.acceleration);
  });
}

TEST(JogJoint, approach_speed_is_what_can_just_be_stopped) {
  test::for_random_cases(3000, [](test::Random& random) {
    const RandomJoint some(random);
    const double q = random.uniform(some.range.lower, some.range.upper);
    for (const bool upwards : {true, false}) {
      const double speed = some.joint.approach_speed(q, upwards, 1);
      const double rest = some.joint.stop({q, upwards ? speed : -speed, 0}).target();
      EXPECT_NEAR(rest, upwards ? some.range.upper : some.range.lower, 1e-9);
      EXPECT_LT(some.joint.approach_speed(q, upwards, 0.5), speed);
    }
    EXPECT_EQ(some.joint.approach_speed(some.range.upper + 1e-6, true, 1), 0);
  });
}

}  // namespace
}  // namespace sinew::planning
