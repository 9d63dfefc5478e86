#include "sinew/io/clock.h"

#include <gtest/gtest.h>

namespace sinew::io {
namespace {

using namespace std::chrono_literals;

TEST(Clock, starts_at_zero_and_never_runs_back) {
  const Clock clock;
  Instant last = clock.now();
  EXPECT_LT(last, Instant{1s});
  for (int i = 0; i < 1000; ++i) {
    const Instant now = clock.now();
    ASSERT_GE(now, last);
    last = now;
  }
}

TEST(Clock, scaled_clocks_pass_their_seconds_faster_or_slower) {
  const Clock fast(100);
  const Clock slow(0.01);
  const auto start = std::chrono::steady_clock::now();
  const Instant fast_start = fast.now();
  const Instant slow_start = slow.now();
  while (std::chrono::steady_clock::now() - start < 5ms) {
  }
  // Others may take the processor away in the middle: lower bounds are sure, upper ones generous.
  EXPECT_GE(fast.now() - fast_start, 499ms);
  const Duration slow_passed = slow.now() - slow_start;
  EXPECT_GE(slow_passed, 49us);
  EXPECT_LT(slow_passed, (std::chrono::steady_clock::now() - start) / 50);
}

TEST(Clock, until_counts_in_real_time) {
  const Clock fast(100);
  const Duration left = fast.until(fast.now() + 1s);
  EXPECT_LE(left, 10ms);
  EXPECT_GT(left, 1ms);
  EXPECT_EQ(fast.until(Instant{-1s}), Duration::zero());
  const Clock plain;
  EXPECT_GT(plain.until(plain.now() + 1h), 59min);
  EXPECT_LE(plain.until(plain.now() + 1h), 1h);
}

/// The simulated arm can be sent on a way of a century; slowed down a hundred times, that many
/// nanoseconds are more than a Duration holds.
TEST(Clock, far_instants_stay_in_the_future_at_every_scale) {
  for (const double scale : {0.01, 0.5, 1.0, 100.0}) {
    const Clock clock(scale);
    EXPECT_GE(clock.until(Instant{from_seconds(9e9)}), 24h) << scale;
  }
}

TEST(SimulatedClock, passes_only_as_far_as_somebody_lets_it) {
  const Clock clock = Clock::simulated(100);
  const auto start = std::chrono::steady_clock::now();
  while (std::chrono::steady_clock::now() - start < 5ms) {
  }
  EXPECT_EQ(clock.now(), Instant{});
  clock.pass_to(Instant{3s});
  EXPECT_EQ(clock.now(), Instant{3s});
  clock.pass_to(Instant{2s});
  EXPECT_EQ(clock.now(), Instant{3s}) << "it never runs back";
}

TEST(SimulatedClock, is_never_quicker_than_its_scale_says) {
  const Clock clock = Clock::simulated(10);
  const auto start = std::chrono::steady_clock::now();
  clock.pause(20ms);
  EXPECT_EQ(clock.now(), Instant{200ms});
  EXPECT_GE(std::chrono::steady_clock::now() - start, 19ms);
}

TEST(SimulatedClock, reaches_an_instant_that_is_nearer_than_any_sleep) {
  const Clock clock = Clock::simulated(40);
  clock.pass_to(Instant{3s});
  clock.pause_until(Instant{3s} + Duration{7});
  EXPECT_EQ(clock.now(), Instant{3s} + Duration{7}) << "ns";
}

/// `sinew run --time-scale 50` never came to the end of a wait.
TEST(SimulatedClock, until_is_zero_only_where_the_instant_has_passed) {
  const Clock clock = Clock::simulated(50);
  clock.pass_to(Instant{2s} - Duration{1});
  EXPECT_GT(clock.until(Instant{2s}), Duration::zero()) << "a nanosecond is left";
  clock.pass_to(Instant{2s});
  EXPECT_EQ(clock.until(Instant{2s}), Duration::zero());
}

/// Ahead by less than a sleep, a turn goes its whole way: shorter ones would spin.
TEST(SimulatedClock, a_turn_is_whole_or_empty) {
  const Clock clock = Clock::simulated(200);
  clock.pass_to(Instant{30s});
  EXPECT_EQ(clock.end_of_turn(20ms), Instant{30s}) << "far ahead";
  const Clock late = Clock::simulated(200);
  Clock().pause(2ms);
  EXPECT_EQ(late.end_of_turn(20ms), Instant{20ms});
}

TEST(SimulatedClock, what_a_busy_computer_has_missed_is_not_made_up_for_at_once) {
  const Clock clock = Clock::simulated();
  Clock().pause(2 * Clock::kLateMax);
  clock.keep_pace();
  const auto start = std::chrono::steady_clock::now();
  clock.pass_to(Instant{20ms});
  clock.keep_pace();
  EXPECT_GE(std::chrono::steady_clock::now() - start, 19ms);
}

}  // namespace
}  // namespace sinew::io
