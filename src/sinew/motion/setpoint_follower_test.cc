#include "sinew/motion/setpoint_follower.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "sinew/core/units.h"
#include "support/allocation_guard.h"
#include "support/property.h"

namespace sinew::motion {
namespace {

using test::for_random_cases;
using test::Random;

const AxisLimits kArm{from_deg(30), from_deg(10), from_deg(10)};
/// What a follower is allowed beside: jitter of the arrivals costs jerk.
const AxisLimits kFollow{kArm.velocity, kArm.acceleration, 10 * kArm.jerk};
const PositionRange kWide{-3, 3};

/// Keeps an eye on the limits of everything that a follower says.
struct Watch {
  Watch(const AxisLimits& axis_limits, const PositionRange& position_range)
      : follower(axis_limits, position_range), limits(axis_limits), range(position_range) {}

  void begin(const AxisState& start) {
    state = start;
    follower.begin(start);
  }
  void step(double dt) {
    const AxisState next = follower.step(state, dt);
    worst_jerk = std::max(worst_jerk, std::abs(next.qdd - state.qdd) / dt);
    worst_acceleration = std::max(worst_acceleration, std::abs(next.qdd));
    worst_velocity = std::max(worst_velocity, std::abs(next.qd));
    outside = std::max({outside, next.q - range.upper, range.lower - next.q});
    state = next;
  }
  void expect_inside() const {
    EXPECT_LE(worst_jerk, limits.jerk * (1 + 1e-6) + 1e-9);
    EXPECT_LE(worst_acceleration, limits.acceleration * (1 + 1e-8));
    EXPECT_LE(worst_velocity, limits.velocity * (1 + 1e-8));
    EXPECT_LE(outside, 1e-9);
  }

  SetpointFollower follower;
  AxisLimits limits;
  PositionRange range;
  AxisState state;
  double worst_jerk = 0, worst_acceleration = 0, worst_velocity = 0, outside = 0;
};

/// Streams a planned move with a setpoint every `period` s (to within one tick) and returns the
/// greatest distance between where the axis was told to be and where it was.
double greatest_lag(double period, double dt, double way, double quantum = 0) {
  Watch watch(kFollow, kWide);
  watch.begin({});
  const auto plan = OnlineProfile::to({}, way, ProfileBounds(kArm));
  double next = 0, lag = 0;
  for (int i = 0; i * dt < plan.duration() + 1.5; ++i) {
    const double t = i * dt;
    if (t >= next - 1e-9) {
      AxisState setpoint = plan.at(next + period);
      if (quantum > 0) setpoint.qd = std::round(setpoint.qd / quantum) * quantum;
      watch.follower.setpoint(setpoint.q, setpoint.qd);
      next += period;
    }
    watch.step(dt);
    // The follower hears a setpoint at the end of its tick: where it is now it was told for t.
    const double told = plan.at(std::max(0.0, t - SetpointFollower::kDelay)).q;
    if (t > 0.1) lag = std::max(lag, std::abs(watch.state.q - told));
  }
  watch.expect_inside();
  EXPECT_NEAR(watch.state.q, way, 1e-6);
  EXPECT_NEAR(watch.state.qd, 0, 1e-5);
  return lag;
}

TEST(SetpointFollower, planned_move_is_followed_to_a_fraction_of_a_microstep) {
  // The smoothing is late by 3/2 a kLag^2 more than by kDelay: 2.6e-5 rad, a quarter of a
  // microstep.
  for (const double period : {0.002, 0.004, 0.010}) {
    EXPECT_LT(greatest_lag(period, 1e-3, 1.5), 3e-5) << period;
  }
  EXPECT_LT(greatest_lag(0.010, 1e-2, 1.5), 5e-5);
  EXPECT_LT(greatest_lag(0.005, 2e-4, -0.7), 3e-5);
}

TEST(SetpointFollower, period_that_is_no_multiple_of_the_tick_is_evened_out) {
  // Until the rhythm is known to a few microseconds it falls behind, by some 25 ms of the speed,
  // and a stream that accelerates at the limit leaves nothing to catch up with.
  EXPECT_LT(to_deg(greatest_lag(0.0043, 1e-3, 1.5)), 1.0);
  EXPECT_LT(to_deg(greatest_lag(0.0077, 1e-3, 1.5)), 1.0);
}

TEST(SetpointFollower, coarse_velocities_do_not_shake_it) {
  EXPECT_LT(greatest_lag(0.005, 1e-3, 1.5, from_deg(0.01)), 1e-4);
}

TEST(SetpointFollower, jump_is_caught_up_with_inside_the_limits) {
  Watch watch(kFollow, kWide);
  watch.begin({});
  double arrived = 0;
  for (int i = 0; i < 12'000; ++i) {
    if (i % 5 == 0) watch.follower.setpoint(from_deg(40), 0);
    watch.step(1e-3);
    if (arrived == 0 && std::abs(watch.state.q - from_deg(40)) < 1e-5) arrived = i * 1e-3;
  }
  watch.expect_inside();
  EXPECT_NEAR(watch.state.q, from_deg(40), 1e-7);
  // Hardly slower than a move of its own.
  EXPECT_LT(arrived, 1.05 * plan_axis(from_deg(40), kArm).duration());
}

TEST(SetpointFollower, stream_that_is_already_moving_is_caught_up_with) {
  Watch watch(kFollow, kWide);
  watch.begin({});
  for (int i = 0; i < 18'000; ++i) {
    if (i % 5 == 0) watch.follower.setpoint(0.1 + from_deg(8) * (i + 5) * 1e-3, from_deg(8));
    watch.step(1e-3);
  }
  watch.expect_inside();
  EXPECT_NEAR(watch.state.q, 0.1 + from_deg(8) * (17.999 - SetpointFollower::kDelay), 1e-4);
  EXPECT_NEAR(watch.state.qd, from_deg(8), 1e-4);
}

TEST(SetpointFollower, stream_that_ends_in_motion_ends_at_rest) {
  Watch watch(kFollow, kWide);
  watch.begin({0, from_deg(10), 0});
  for (int i = 0; i < 1000; ++i) {
    if (i % 5 == 0) watch.follower.setpoint(from_deg(10) * (i + 5) * 1e-3, from_deg(10));
    watch.step(1e-3);
  }
  EXPECT_FALSE(watch.follower.silent());
  const double last = watch.state.q;
  for (int i = 0; i < 20; ++i) watch.step(1e-3);
  EXPECT_TRUE(watch.follower.silent());
  for (int i = 0; i < 5'000; ++i) watch.step(1e-3);
  watch.expect_inside();
  EXPECT_EQ(watch.state.qd, 0);
  // At most 21 ms at the last speed, then a stop of v^2 / 2a + v a / 2j.
  EXPECT_LT(to_deg(watch.state.q - last), 0.21 + 5 + 0.5 + 0.6);
  EXPECT_GT(to_deg(watch.state.q - last), 5.5);
}

TEST(SetpointFollower, two_lost_setpoints_in_a_row_are_hardly_felt) {
  Watch watch(kFollow, kWide);
  const auto plan = OnlineProfile::to({}, 1.5, ProfileBounds(kArm));
  watch.begin({});
  double lag = 0;
  for (int i = 0; i < 9'000; ++i) {
    const AxisState setpoint = plan.at((i + 5) * 1e-3);
    const bool lost = i % 100 == 55 || i % 100 == 60;
    if (i % 5 == 0 && !lost) watch.follower.setpoint(setpoint.q, setpoint.qd);
    watch.step(1e-3);
    ASSERT_FALSE(watch.follower.silent());
    lag = std::max(lag, std::abs(watch.state.q - plan.at(i * 1e-3 - SetpointFollower::kDelay).q));
  }
  watch.expect_inside();
  EXPECT_LT(to_deg(lag), 0.8);
}

TEST(SetpointFollower, any_stream_at_any_rate_keeps_every_limit) {
  for_random_cases(300, [](Random& random) {
    const AxisLimits limits{std::pow(10.0, random.uniform(-1, 0.5)),
                            std::pow(10.0, random.uniform(-1, 1.5)),
                            std::pow(10.0, random.uniform(-1, 3))};
    const PositionRange range{-random.uniform(0.01, 2), random.uniform(0.01, 2)};
    Watch watch(limits, range);
    watch.begin({random.uniform(range.lower, range.upper), 0, 0});
    const double rate = std::pow(10.0, random.uniform(2, 3.7));
    double q = watch.state.q, qd = 0;
    for (int i = 0; i < 3'000; ++i) {
      if (random.chance(0.2)) {
        if (random.chance(0.02)) q = random.uniform(range.lower, range.upper);
        if (random.chance(0.1)) qd = random.uniform(-2, 2) * limits.velocity;
        q = std::clamp(q + qd / rate, range.lower, range.upper);
        watch.follower.setpoint(q, qd);
      }
      watch.step(random.uniform(0.5, 1.5) / rate);
    }
    watch.expect_inside();
  });
}

/// A host that takes its setpoints from its motion when it sends them, and sends them when it can.
struct JitteredHost {
  enum class Rhythm { kUneven, kNearlyEven, kPauses };

  /// @return s from one setpoint to the next
  double pause(Random& random) const {
    if (rhythm == Rhythm::kUneven) return random.uniform(0.5e-3, 3e-3);
    const double even = random.uniform(1.0e-3, 1.14e-3);
    if (rhythm == Rhythm::kNearlyEven) return random.chance(0.01) ? 1.5e-3 : even;
    return random.chance(0.002) ? random.uniform(5e-3, 40e-3) : even;
  }

  Rhythm rhythm = Rhythm::kUneven;
};

struct JitterFigures {
  double ahead = 0;   ///< rad, of where the stream was told to be by then
  double beyond = 0;  ///< rad, of where the stream ends
  double astray = 0;  ///< rad, either way, of the stream kDelay before
  double at_end = 0;  ///< rad, two seconds after the stream came to rest
};

/// There and back, from rest to rest inside the limits; setpoints come between the ticks.
JitterFigures follow_jittered(const JitteredHost& host, double way, Random& random) {
  JitterFigures figures;
  Watch watch(kFollow, kWide);
  watch.begin({});
  for (const double to : {way, -way, 0.0}) {
    const double from = watch.state.q;
    const double sign = to > from ? 1 : -1;
    const auto plan = OnlineProfile::to({from, 0, 0}, to, ProfileBounds(kArm));
    const auto told = [&](double t) { return plan.at(std::clamp(t, 0.0, plan.duration())); };
    double sends = 0, round = 1e-3;
    for (int i = 1; i * 1e-3 < plan.duration() + 3; ++i) {
      const double t = i * 1e-3;
      while (sends < t) {
        const AxisState setpoint = told(sends + round);
        watch.follower.setpoint(setpoint.q, setpoint.qd);
        round = host.pause(random);
        sends += round;
      }
      watch.step(1e-3);
      const double q = watch.state.q;
      const double late = std::abs(q - told(t - SetpointFollower::kDelay).q);
      figures.ahead = std::max(figures.ahead, sign * (q - told(t).q));
      figures.beyond = std::max(figures.beyond, sign * (q - to));
      figures.astray = std::max(figures.astray, late);
      if (t > plan.duration() + 2) figures.at_end = std::max(figures.at_end, std::abs(q - to));
    }
  }
  watch.expect_inside();
  return figures;
}

TEST(SetpointFollower, stream_of_any_rhythm_is_never_outrun) {
  using enum JitteredHost::Rhythm;
  for_random_cases(120, [](Random& random) {
    const JitteredHost host{random.chance(0.5) ? kUneven : kNearlyEven};
    const JitterFigures figures = follow_jittered(host, from_deg(random.uniform(2, 60)), random);
    // A fraction of a microstep, 0.0066 deg; 2.4 to 4.2 deg when positions were gone by.
    EXPECT_LT(to_deg(figures.ahead), 0.006);
    EXPECT_LT(to_deg(figures.beyond), 0.006);
    // At full speed, where the limits leave nothing to catch up with, half of the way of 3 ms.
    EXPECT_LT(to_deg(figures.astray), 0.3);
    EXPECT_LT(to_deg(figures.at_end), 0.001);
  });
}

TEST(SetpointFollower, host_that_pauses_is_not_outrun_either) {
  using enum JitteredHost::Rhythm;
  for_random_cases(40, [](Random& random) {
    const JitterFigures figures =
        follow_jittered({kPauses}, from_deg(random.uniform(2, 60)), random);
    EXPECT_LT(to_deg(figures.beyond), to_deg(2 * SetpointFollower::kBeyond));
    EXPECT_LT(to_deg(figures.at_end), 0.001);
  });
}

TEST(SetpointFollower, way_to_the_stream_is_known) {
  Watch watch(kFollow, kWide);
  watch.begin({});
  EXPECT_EQ(watch.follower.astray(watch.state), 0);
  for (int i = 0; i < 100; ++i) {
    watch.follower.setpoint(0.5, 0);
    watch.step(1e-3);
  }
  EXPECT_NEAR(watch.follower.astray(watch.state), watch.state.q - 0.5, 1e-4);
  EXPECT_LT(watch.follower.astray(watch.state), -0.49);
}

TEST(SetpointFollower, following_allocates_nothing) {
  Watch watch(kFollow, kWide);
  watch.begin({});
  const test::AllocationCounter counter;
  for (int i = 0; i < 100; ++i) {
    watch.follower.setpoint(1, 0);
    watch.step(1e-3);
  }
  EXPECT_EQ(counter.count(), 0U);
}

}  // namespace
}  // namespace sinew::motion
