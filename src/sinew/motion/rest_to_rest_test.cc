#include "sinew/motion/rest_to_rest.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "support/allocation_guard.h"
#include "support/property.h"

namespace sinew::motion {
namespace {

constexpr double kRounding = 1 + 1e-12;

AxisLimits random_limits(test::Random& random) {
  const auto spread = [&] { return std::pow(10, random.uniform(-2, 2)); };
  return {spread(), spread(), spread()};
}

struct Move {
  std::vector<double> start, target;
  std::vector<AxisLimits> limits;
};

Move random_move(test::Random& random) {
  Move move;
  const auto axes = random.integer(1, 8);
  for (int i = 0; i < axes; ++i) {
    move.start.push_back(random.uniform(-3, 3));
    const double distance = random.chance(0.1) ? 0 : std::pow(10, random.uniform(-6, 1));
    move.target.push_back(move.start.back() + (random.chance(0.5) ? distance : -distance));
    move.limits.push_back(random_limits(random));
  }
  return move;
}

/// Time to go `distance` if the speed peaks at v: the ramp's time plus distance / v.
double time_at_peak(double v, double distance, const AxisLimits& limits) {
  const double a = limits.acceleration;
  const double j = limits.jerk;
  const double ramp = v * j >= a * a ? v / a + a / j : 2 * std::sqrt(v / j);
  return distance >= v * ramp ? ramp + distance / v : INFINITY;
}

TEST(RestToRest, stays_inside_every_limit_and_arrives_together) {
  test::for_random_cases(100'000, [](test::Random& random) {
    const Move move = random_move(random);
    const RestToRest plan(move.start, move.target, move.limits);
    AxisStates before{};
    AxisStates now{};
    plan.sample(0, before);
    constexpr int kSteps = 64;
    const double h = plan.duration() / kSteps;
    for (int step = 0; step <= kSteps; ++step) {
      plan.sample(step == kSteps ? plan.duration() : step * h, now);
      for (std::size_t i = 0; i < plan.size(); ++i) {
        const auto& [v, a, j] = move.limits[i];
        const double distance = std::abs(move.target[i] - move.start[i]);
        ASSERT_LE(std::abs(now.qd[i]), v * kRounding);
        ASSERT_LE(std::abs(now.qdd[i]), a * kRounding);
        ASSERT_LE(std::abs(now.qdd[i] - before.qdd[i]), j * h * kRounding + 1e-9 * a);
        // Between start and target, and never backwards.
        const double towards = move.target[i] >= move.start[i] ? 1 : -1;
        ASSERT_GE(towards * (now.q[i] - before.q[i]), -1e-14 * (3 + distance));
        ASSERT_GE(towards * now.qd[i], -1e-12 * v);
      }
      before = now;
    }
    for (std::size_t i = 0; i < plan.size(); ++i) {
      ASSERT_EQ(now.q[i], move.target[i]);
      ASSERT_EQ(now.qd[i], 0);
      ASSERT_EQ(now.qdd[i], 0);
    }
  });
}

TEST(RestToRest, velocity_and_acceleration_are_the_derivatives) {
  test::for_random_cases(100'000, [](test::Random& random) {
    const Move move = random_move(random);
    const RestToRest plan(move.start, move.target, move.limits);
    if (plan.duration() == 0) return random.discard();
    const double h = 1e-4 * plan.duration();
    const double t = random.uniform(h, plan.duration() - h);
    AxisStates before{}, now{}, after{};
    plan.sample(t - h, before);
    plan.sample(t, now);
    plan.sample(t + h, after);
    for (std::size_t i = 0; i < plan.size(); ++i) {
      // Central differences are off by at most jerk h^2 / 6 and jerk h.
      const double j = move.limits[i].jerk;
      const double noise = 1e-15 * (std::abs(now.q[i]) + 10) / h;
      ASSERT_NEAR((after.q[i] - before.q[i]) / (2 * h), now.qd[i], j * h * h + 2 * noise);
      ASSERT_NEAR((after.qd[i] - before.qd[i]) / (2 * h), now.qdd[i],
                  j * h + 1e-12 * (move.limits[i].velocity / h));
    }
  });
}

TEST(RestToRest, one_axis_is_as_quick_as_a_search_over_all_peak_speeds) {
  test::for_random_cases(20'000, [](test::Random& random) {
    const AxisLimits limits = random_limits(random);
    const double distance = std::pow(10, random.uniform(-6, 2));
    const double duration = plan_axis(distance, limits).duration();
    double best = INFINITY;
    for (int i = 1; i <= 400; ++i) {
      const double v = limits.velocity * std::pow(10, -12.0 * (400 - i) / 400);
      best = std::min(best, time_at_peak(v, distance, limits));
    }
    ASSERT_LE(duration, best * kRounding);
    // And not quicker than is possible: the peak it claims really takes that long.
    const double v = plan_axis(distance, limits).velocity();
    ASSERT_LE(v, limits.velocity * kRounding);
    ASSERT_NEAR(time_at_peak(v * (1 - 1e-9), distance, limits), duration, 1e-8 * duration);
  });
}

TEST(RestToRest, duration_is_that_of_the_slowest_axis) {
  test::for_random_cases(100'000, [](test::Random& random) {
    const Move move = random_move(random);
    const RestToRest plan(move.start, move.target, move.limits);
    double slowest = 0;
    for (std::size_t i = 0; i < plan.size(); ++i) {
      const double distance = std::abs(move.target[i] - move.start[i]);
      slowest = std::max(slowest, plan_axis(distance, move.limits[i]).duration());
    }
    ASSERT_EQ(plan.duration(), slowest);
  });
}

TEST(RestToRest, equal_axes_go_straight) {
  const std::vector<AxisLimits> limits(3, AxisLimits{1, 2, 8});
  const RestToRest plan(std::vector{0.0, 1.0, 2.0}, std::vector{1.0, 0.5, 2.0}, limits);
  EXPECT_TRUE(plan.straight());
  EXPECT_EQ(plan.slowest(), 0U);
  AxisStates state{};
  for (int i = 0; i <= 1000; ++i) {
    plan.sample(plan.duration() * i / 1000, state);
    EXPECT_NEAR(state.q[1], 1 - 0.5 * state.q[0], 1e-12);
    EXPECT_EQ(state.q[2], 2.0);
  }
}

TEST(RestToRest, staying_where_one_is_takes_no_time) {
  const std::vector<AxisLimits> limits(2, AxisLimits{1, 1, 1});
  const RestToRest plan(std::vector{0.5, -1.0}, std::vector{0.5, -1.0}, limits);
  AxisStates state{};
  plan.sample(1, state);
  EXPECT_EQ(plan.duration(), 0);
  EXPECT_EQ(state.q[0], 0.5);
  EXPECT_EQ(state.q[1], -1.0);
}

TEST(RestToRest, wide_vectors_sample_what_the_portable_version_does) {
  test::for_random_cases(20'000, [](test::Random& random) {
    const Move move = random_move(random);
    const RestToRest plan(move.start, move.target, move.limits);
    const double t = random.uniform(-0.1, 1.1) * plan.duration();
    AxisStates wide{};
    AxisStates portable{};
    plan.sample(t, wide);
    plan.sample_portable(t, portable);
    for (std::size_t i = 0; i < plan.size(); ++i) {
      ASSERT_NEAR(wide.q[i], portable.q[i], 1e-12);
      ASSERT_NEAR(wide.qd[i], portable.qd[i], 1e-12 * move.limits[i].velocity);
      ASSERT_NEAR(wide.qdd[i], portable.qdd[i], 1e-12 * move.limits[i].acceleration);
    }
  });
}

TEST(RestToRest, nothing_allocates) {
  const std::vector<AxisLimits> limits(2, AxisLimits{1, 1, 1});
  const std::vector<double> start{0, 1};
  const std::vector<double> target{1, 3};
  const test::AllocationCounter allocations;
  const RestToRest plan(start, target, limits);
  AxisStates state{};
  plan.sample(0.3, state);
  EXPECT_EQ(allocations.count(), 0U);
  EXPECT_GT(state.q[0], 0);
}

}  // namespace
}  // namespace sinew::motion
