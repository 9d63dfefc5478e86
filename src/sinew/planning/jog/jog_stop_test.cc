#include "sinew/planning/jog/jog_stop.h"

#include <gtest/gtest.h>

#include <cmath>

#include "sinew/planning/jog/jog_test_robot.h"

namespace sinew::planning {
namespace {

using motion::AxisState;

constexpr std::size_t kCount = 6;

struct RandomStop {
  explicit RandomStop(test::Random& random) {
    for (std::size_t j = 0; j < kCount; ++j) {
      const motion::AxisLimits limits{std::pow(10, random.uniform(-2, 1)),
                                      std::pow(10, random.uniform(-2, 2)),
                                      std::pow(10, random.uniform(-1, 3))};
      joints.push_back(JogJoint(limits, {-1e6, 1e6}));
      AxisState state{0, limits.velocity * random.uniform(-1, 1), 0};
      if (random.chance(0.2)) state.qd = 0;
      // What does not lead beyond the limit of velocity any more.
      const double side = random.chance(0.5) ? 1 : -1;
      const double room = limits.velocity - side * state.qd;
      state.qdd = side * random.uniform(0, 1) *
                  std::min(limits.acceleration, std::sqrt(2 * limits.jerk * room));
      if (random.chance(0.3)) state.qdd = 0;
      states.push_back(state);
    }
  }
  FixedVector<JogJoint, kMaxJoints> joints;
  std::vector<AxisState> states;
};

TEST(JogStop, keeps_all_limits_and_takes_the_time_of_the_slowest_joint) {
  JogStop stop;
  test::for_random_cases(3000, [&](test::Random& random) {
    const RandomStop some(random);
    stop.plan({some.joints.data(), kCount}, some.states);
    double slowest = 0;
    for (std::size_t j = 0; j < kCount; ++j) {
      slowest = std::max(slowest, some.joints[j].stop(some.states[j]).duration());
    }
    ASSERT_NEAR(stop.duration(), slowest, 1e-9 * slowest);
    for (std::size_t j = 0; j < kCount; ++j) {
      const auto& [velocity, acceleration, jerk] = some.joints[j].limits();
      const double dt = stop.duration() / 200;
      AxisState last = stop.at(j, 0);
      for (int k = 1; k <= 200; ++k) {
        const AxisState at = stop.at(j, k * dt);
        ASSERT_LE(std::abs(at.qd), velocity * (1 + 1e-8));
        ASSERT_LE(std::abs(at.qdd), acceleration * (1 + 1e-8));
        ASSERT_LE(std::abs(at.qdd - last.qdd), jerk * dt * (1 + 1e-8) + 1e-8 * acceleration);
        const double ahead = last.q + dt * (last.qd + dt / 2 * last.qdd);
        ASSERT_LE(std::abs(at.q - ahead), jerk * dt * dt * dt / 6 * (1 + 1e-8) + 1e-9 * velocity);
        last = at;
      }
      EXPECT_EQ(stop.at(j, stop.duration()).qd, 0);
      EXPECT_EQ(stop.at(j, stop.duration()).qdd, 0);
    }
  });
}

/// What its acceleration at the start makes of a velocity, before the jerk lets it end.
motion::VelocityRange unavoidable(const AxisState& state, const motion::AxisLimits& limits) {
  const double natural = state.qd + state.qdd * std::abs(state.qdd) / (2 * limits.jerk);
  return {std::min({0.0, state.qd, natural}), std::max({0.0, state.qd, natural})};
}

TEST(JogStop, no_joint_reverses_or_speeds_up_but_for_what_its_acceleration_makes_unavoidable) {
  JogStop stop;
  test::for_random_cases(3000, [&](test::Random& random) {
    const RandomStop some(random);
    stop.plan({some.joints.data(), kCount}, some.states);
    double growth = 1;  // in their share of what one of them cannot avoid
    for (std::size_t j = 0; j < kCount; ++j) {
      if (some.states[j].qd == 0) continue;
      const auto range = unavoidable(some.states[j], some.joints[j].limits());
      growth = std::max(growth, (some.states[j].qd > 0 ? range.upper : -range.lower) /
                                    std::abs(some.states[j].qd));
    }
    for (std::size_t j = 0; j < kCount; ++j) {
      const AxisState& state = some.states[j];
      const auto range = unavoidable(state, some.joints[j].limits());
      const double slack = 1e-8 * some.joints[j].limits().velocity;
      const double upper = state.qd > 0 ? std::max(range.upper, growth * state.qd) : range.upper;
      const double lower = state.qd < 0 ? std::min(range.lower, growth * state.qd) : range.lower;
      for (int k = 0; k <= 200; ++k) {
        const double qd = stop.at(j, stop.duration() * k / 200).qd;
        ASSERT_LE(qd, upper + slack) << "J" << j + 1;
        ASSERT_GE(qd, lower - slack)
            << "J" << j + 1 << " from " << state.qd << ", " << state.qdd << " at " << k;
      }
    }
  });
}

TEST(JogStop, joints_that_gather_speed_together_come_to_rest_along_their_line) {
  JogStop stop;
  test::for_random_cases(2000, [&](test::Random& random) {
    RandomStop some(random);
    // One shape for all, inside everybody's limits.
    const double gain = random.uniform(-1, 1);
    double scale = 1e9;
    std::array<double, kCount> way{};
    for (std::size_t j = 0; j < kCount; ++j) {
      const auto& [velocity, acceleration, jerk] = some.joints[j].limits();
      way[j] = velocity * random.uniform(-1, 1);
      const double size = std::abs(way[j]);
      scale = std::min({scale, velocity / (2 * size), acceleration / size,
                        jerk / (2 * size) * std::min(1.0, velocity / size)});
    }
    // The slowest one's jerk must fit for all: the same limits in proportion.
    for (std::size_t j = 0; j < kCount; ++j) {
      const double size = std::abs(way[j]);
      some.joints[j] = JogJoint({3 * size * scale, size * scale, 2 * size * scale}, {-1e6, 1e6});
      some.states[j] = {0, way[j] * scale, gain * way[j] * scale};
    }
    stop.plan({some.joints.data(), kCount}, some.states);
    for (int k = 0; k <= 50; ++k) {
      const double t = stop.duration() * k / 50;
      const double share = stop.at(0, t).qd / way[0];
      for (std::size_t j = 1; j < kCount; ++j) {
        EXPECT_NEAR(stop.at(j, t).qd, share * way[j], 1e-9 * scale * std::abs(way[j]));
      }
    }
  });
}

}  // namespace
}  // namespace sinew::planning
