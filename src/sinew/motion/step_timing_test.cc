#include "sinew/motion/step_timing.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "sinew/motion/step_segments.h"
#include "sinew/motion/step_test_plans.h"
#include "support/allocation_guard.h"
#include "support/property.h"

namespace sinew::motion {
namespace {

using namespace test_plans;

TEST(StepTimer, every_step_comes_within_a_tick_of_its_exact_time) {
  double worst = 0;
  std::uint64_t steps = 0;
  std::uint64_t evaluations = 0;
  test::for_random_cases(1000, [&](test::Random& random) {
    const double rate = random.chance(0.5) ? 1e6 : 72e6;
    const auto phases = random_phases(random, std::pow(10, random.uniform(-3, 1.2)));
    StepSegments converter(hardware(rate), phases[0].start.q);
    const auto segments = converted(converter, phases);
    const Played played = play(converter, segments);
    expect_steps(crossings_of(phases, kStepsPerRad), played.steps, rate,
                 position_tolerance(phases, rate), worst);
    ASSERT_LE(played.timer.evaluations_most(), StepTimer::kEvaluationsMax);
    evaluations += played.timer.evaluations();
    steps += played.steps.size();
    // Both ends hold the same integers.
    ASSERT_EQ(played.timer.clock(), converter.clock());
    ASSERT_EQ(played.timer.offset(), converter.offset());
    ASSERT_EQ(converter.start_steps() + played.timer.position(), converter.steps());
  });
  EXPECT_LE(worst, 1);
  EXPECT_GT(steps, 100'000u);
  EXPECT_LT(evaluations, 3 * steps);
}

TEST(StepTimer, ten_million_steps_end_where_the_plan_does) {
  const double distance = 1e7 / kStepsPerRad;
  const JerkLimitedMove move =
      plan_axis(distance, {180'000 / kStepsPerRad, 2e6 / kStepsPerRad, 4e7 / kStepsPerRad});
  const double rate = 72e6;
  StepSegments converter(hardware(rate), 0);
  const auto segments = converted(converter, jerk_phases(move, 0, distance));
  StepTimer timer(converter.start_offset());
  TimedStep step;
  std::uint64_t first = 0;
  std::uint64_t last = 0;
  std::uint64_t closest = UINT64_MAX;
  for (const StepSegment& segment : segments) {
    timer.load(segment);
    while (timer.next(step)) {
      ASSERT_EQ(step.direction, 1);
      if (timer.position() == 1) {
        first = step.tick;
      } else {
        closest = std::min(closest, step.tick - last);
      }
      last = step.tick;
    }
  }
  EXPECT_EQ(timer.position(), 10'000'000);
  EXPECT_LE(static_cast<double>(std::abs(timer.offset())), 1e-8 * StepSegment::kStep);
  EXPECT_GE(static_cast<double>(closest), rate / 180'000 - 1);
  // First and last step are half a step from rest: jerk t^3 / 6.
  const double from_rest = std::cbrt(6 * 0.5 / kStepsPerRad / move.jerk);
  EXPECT_NEAR(static_cast<double>(first), from_rest * rate, 1);
  EXPECT_NEAR(static_cast<double>(last), (move.duration() - from_rest) * rate, 1.5);
}

TEST(StepTimer, a_hundred_moves_in_a_row_lose_nothing) {
  test::for_random_cases(5, [](test::Random& random) {
    StepSegments converter(hardware(), 0);
    StepTimer timer(converter.start_offset());
    std::vector<StepSegment> segments(64);
    double q = 0;
    TimedStep step;
    std::uint64_t last = 0;
    for (int i = 0; i < 100; ++i) {
      const double target = i == 99 ? 0 : random.uniform(-6, 6);
      const auto phases =
          jerk_phases(plan_axis(std::abs(target - q), {10, 100, 1000}), q, target - q);
      const auto size = converter.convert(phases, segments);
      ASSERT_TRUE(size);
      for (std::size_t k = 0; k < *size; ++k) {
        timer.load(segments[k]);
        while (timer.next(step)) {
          ASSERT_GE(step.tick, last);
          last = step.tick;
        }
      }
      q = target;
      ASSERT_EQ(timer.position(), converter.steps());
      ASSERT_EQ(timer.offset(), converter.offset());
      const double position =
          static_cast<double>(timer.position()) +
          static_cast<double>(timer.offset()) / static_cast<double>(StepSegment::kStep);
      ASSERT_NEAR(position, q * kStepsPerRad, kPositionTolerance);
    }
    EXPECT_EQ(timer.position(), 0);
  });
}

TEST(StepTimer, one_step_in_minutes_comes_at_its_tick) {
  const double seconds = 400;  // from one to the next
  const std::vector<JerkPhase> phases{{{0, 1 / kStepsPerRad / seconds, 0}, 0, 4.9 * seconds}};
  for (const double rate : {1e6, 72e6}) {
    StepSegments converter(hardware(rate), 0);
    const auto segments = converted(converter, phases);
    const auto steps = play(converter, segments).steps;
    ASSERT_EQ(steps.size(), 5u);
    for (std::size_t i = 0; i < 5; ++i) {
      const double due = (static_cast<double>(i) + 0.5) * seconds * rate;
      EXPECT_NEAR(static_cast<double>(steps[i].tick), due, 1) << rate;
    }
  }
}

TEST(StepTimer, two_hundred_kilohertz_stay_even) {
  const double rate = 1e6;
  const std::vector<JerkPhase> phases{{{0, 200e3 / kStepsPerRad, 0}, 0, 1}};
  StepSegments converter(hardware(rate), 0);
  const auto steps = play(converter, converted(converter, phases)).steps;
  ASSERT_EQ(steps.size(), 200'000u);
  for (std::size_t i = 1; i < steps.size(); ++i) {
    ASSERT_NEAR(static_cast<double>(steps[i].tick - steps[i - 1].tick), 5, 1);
  }
}

TEST(StepTimer, an_axis_at_rest_makes_no_step_wherever_it_stands) {
  for (const double step : {0.0, 0.25, 0.5, -0.5, 7.49999, 1e6 + 0.5}) {
    const std::vector<JerkPhase> phases{{{step / kStepsPerRad, 0, 0}, 0, 3600}};
    StepSegments converter(hardware(), step / kStepsPerRad);
    const auto segments = converted(converter, phases);
    const Played played = play(converter, segments);
    EXPECT_TRUE(played.steps.empty()) << step;
    EXPECT_EQ(played.timer.clock(), 3'600'000'000u);
    EXPECT_EQ(played.timer.offset(), converter.start_offset());
  }
}

TEST(StepTimer, an_axis_that_turns_makes_the_same_steps_back) {
  // Thrown up and caught: 1000.3 steps high, half a second each way.
  const double height = 1000.3 / kStepsPerRad;
  const std::vector<JerkPhase> phases{{{0, 4 * height, -8 * height}, 0, 1}};
  StepSegments converter(hardware(), 0);
  const auto segments = converted(converter, phases);
  ASSERT_EQ(segments.size(), 2u);
  const auto steps = play(converter, segments).steps;
  ASSERT_EQ(steps.size(), 2000u);
  for (std::size_t i = 0; i < 1000; ++i) {
    ASSERT_EQ(steps[i].direction, 1);
    ASSERT_EQ(steps[1999 - i].direction, -1);
    ASSERT_NEAR(static_cast<double>(steps[i].tick + steps[1999 - i].tick), 1e6, 1);
  }
}

TEST(StepTimer, a_damaged_segment_costs_no_more_than_a_good_one) {
  test::for_random_cases(20'000, [](test::Random& random) {
    StepTimer timer(static_cast<std::int64_t>(random.bits()) >> 24);
    TimedStep step;
    for (int k = 0; k < 3; ++k) {
      StepSegment segment;
      segment.duration = static_cast<std::uint32_t>(random.integer(1, StepSegment::kTicksMax)) >>
                         random.integer(0, 30);
      segment.duration = std::max(segment.duration, 1u);
      segment.steps = 5;
      segment.direction = random.chance(0.5) ? 1 : -1;
      segment.c1 = static_cast<std::int64_t>(random.bits()) >> random.integer(4, 60);
      segment.c2 = static_cast<std::int64_t>(random.bits()) >> random.integer(4, 60);
      segment.c3 = static_cast<std::int64_t>(random.bits()) >> random.integer(4, 60);
      const std::uint64_t begin = timer.clock();
      timer.load(segment);
      while (timer.next(step)) {
        ASSERT_GE(step.tick, begin);
        ASSERT_LT(step.tick, begin + segment.duration);
      }
      ASSERT_LE(timer.evaluations_most(), StepTimer::kEvaluationsMax);
    }
    ASSERT_LE(std::abs(timer.position()), 15);
  });
}

TEST(StepTimer, neither_end_allocates) {
  const auto phases = jerk_phases(plan_axis(1, {10, 100, 1000}), 0, 1);
  std::vector<StepSegment> segments(16);
  const test::AllocationCounter counter;
  StepSegments converter(hardware(), 0);
  const auto size = converter.convert(phases, segments);
  StepTimer timer(converter.start_offset());
  TimedStep step;
  for (std::size_t i = 0; i < size.value_or(0); ++i) {
    timer.load(segments[i]);
    while (timer.next(step)) {
    }
  }
  EXPECT_EQ(counter.count(), 0u);
  EXPECT_EQ(timer.position(), std::llround(kStepsPerRad));
}

}  // namespace
}  // namespace sinew::motion
