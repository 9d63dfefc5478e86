#include "sinew/motion/step_runs.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "sinew/motion/step_test_plans.h"
#include "support/allocation_guard.h"
#include "support/property.h"

namespace sinew::motion {
namespace {

using namespace test_plans;

struct Compressed {
  std::vector<StepRun> runs;
  std::vector<std::uint8_t> bytes;
  std::vector<TimedStep> steps;
};

/// Through the wire and back: what the axis makes of it.
Compressed compressed(StepRuns& compressor, const StepSegments& converter,
                      std::span<const StepSegment> segments) {
  Compressed result;
  result.runs.resize(100'000);
  const auto size = compressor.compress(segments, converter.start_offset(), 0, result.runs);
  EXPECT_TRUE(size) << static_cast<int>(size.error().reason) << " " << size.error().measured;
  result.runs.resize(size.value_or(0));
  StepRunCode sender;
  for (const StepRun& run : result.runs) {
    std::array<std::uint8_t, StepRunCode::kBytesMax> bytes{};
    const std::size_t used = sender.encode(run, bytes);
    result.bytes.insert(result.bytes.end(), bytes.begin(), bytes.begin() + used);
  }
  StepRunCode receiver;
  StepRunPlayer player;
  std::span<const std::uint8_t> left(result.bytes);
  while (!left.empty()) {
    StepRun run;
    const std::size_t used = receiver.decode(left, run);
    if (used == 0) {
      ADD_FAILURE() << "undecodable";
      break;
    }
    left = left.subspan(used);
    player.load(run);
    TimedStep step;
    while (player.next(step)) result.steps.push_back(step);
  }
  return result;
}

TEST(StepRuns, every_step_is_within_the_tolerance_of_its_exact_time) {
  test::for_random_cases(500, [](test::Random& random) {
    const double tolerance = random.chance(0.5) ? 25 : random.uniform(2, 300);
    const auto phases = random_phases(random, std::pow(10, random.uniform(-3, 1)));
    StepSegments converter(hardware(), phases[0].start.q);
    const auto segments = converted(converter, phases);
    StepRuns compressor({tolerance}, segments.size());
    const auto steps = compressed(compressor, converter, segments).steps;
    const auto exact = crossings_of(phases, kStepsPerRad);
    ASSERT_EQ(steps.size(), exact.size());
    const double unsure = position_tolerance(phases, 1e6);
    for (std::size_t i = 0; i < steps.size(); ++i) {
      ASSERT_EQ(steps[i].direction, exact[i].direction);
      const auto off = static_cast<double>(
          std::abs(static_cast<long double>(steps[i].tick) - exact[i].time * 1e6L));
      const double slack = unsure / static_cast<double>(exact[i].speed) * 1e6;
      ASSERT_LE(off, tolerance + slack + 0.02) << i;
    }
  });
}

TEST(StepRuns, steps_keep_half_of_their_interval) {
  // 50 kHz with a tolerance of 25 ticks, which is more than an interval.
  const double distance = 200'000 / kStepsPerRad;
  const auto move =
      plan_axis(distance, {50e3 / kStepsPerRad, 1e6 / kStepsPerRad, 2e7 / kStepsPerRad});
  StepSegments converter(hardware(), 0);
  const auto segments = converted(converter, jerk_phases(move, 0, distance));
  StepRuns compressor({25}, segments.size());
  const auto steps = compressed(compressor, converter, segments).steps;
  const auto exact = play(converter, segments).steps;
  ASSERT_EQ(steps.size(), exact.size());
  for (std::size_t i = 1; i < steps.size(); ++i) {
    const auto interval = static_cast<double>(exact[i].tick - exact[i - 1].tick);
    ASSERT_GE(static_cast<double>(steps[i].tick - steps[i - 1].tick), interval / 2 - 1);
    ASSERT_LE(std::abs(static_cast<double>(steps[i].tick) - static_cast<double>(exact[i].tick)),
              interval / 4 + 2);
  }
}

TEST(StepRuns, moves_of_the_arm_take_a_fiftieth_of_a_byte_a_step) {
  std::size_t bytes = 0;
  std::size_t steps = 0;
  test::for_random_cases(60, [&](test::Random& random) {
    const double q = random.uniform(-2.9, 2.9);
    const double target = random.uniform(-2.9, 2.9);
    const JerkLimitedMove move =
        plan_axis(std::abs(target - q), {from_deg(29.5), from_deg(10), from_deg(10)});
    StepSegments converter(hardware(), q);
    const auto segments = converted(converter, jerk_phases(move, q, target - q));
    StepRuns compressor({25}, segments.size());
    const Compressed result = compressed(compressor, converter, segments);
    bytes += result.bytes.size();
    steps += result.steps.size();
  });
  EXPECT_LT(static_cast<double>(bytes), 0.02 * static_cast<double>(steps));
}

TEST(StepRuns, too_fast_for_whole_ticks_is_refused) {
  const std::vector<JerkPhase> phases{{{0, 250e3 / kStepsPerRad, 0}, 0, 1}};
  StepSegments converter(hardware(), 0);
  const auto segments = converted(converter, phases);
  StepRuns compressor({25}, segments.size());
  std::vector<StepRun> runs(1000);
  const auto result = compressor.compress(segments, converter.start_offset(), 0, runs);
  ASSERT_FALSE(result);
  EXPECT_EQ(result.error().reason, StepRefusal::Reason::kTooFast);
  EXPECT_NEAR(result.error().limit, 6, 1e-9);
}

TEST(StepRuns, too_little_room_is_refused) {
  const auto phases = jerk_phases(plan_axis(1, {1, 1, 1}), 0, 1);
  StepSegments converter(hardware(), 0);
  const auto segments = converted(converter, phases);
  StepRuns compressor({25}, segments.size());
  std::vector<StepRun> runs(3);
  const auto result = compressor.compress(segments, converter.start_offset(), 0, runs);
  ASSERT_FALSE(result);
  EXPECT_EQ(result.error().reason, StepRefusal::Reason::kTooMany);
}

TEST(StepRuns, nothing_allocates_after_construction) {
  const auto phases = jerk_phases(plan_axis(1, {1, 1, 1}), 0, 1);
  StepSegments converter(hardware(), 0);
  const auto segments = converted(converter, phases);
  StepRuns compressor({25}, segments.size());
  std::vector<StepRun> runs(1000);
  const test::AllocationCounter counter;
  const auto result = compressor.compress(segments, converter.start_offset(), 0, runs);
  EXPECT_EQ(counter.count(), 0u);
  EXPECT_TRUE(result);
}

TEST(StepRunCode, random_bytes_are_a_run_or_refused_and_never_harm) {
  test::for_random_cases(20'000, [](test::Random& random) {
    StepRunCode code;
    std::array<std::uint8_t, 64> bytes{};
    for (auto& byte : bytes) byte = static_cast<std::uint8_t>(random.bits());
    std::span<const std::uint8_t> left(bytes);
    while (!left.empty()) {
      StepRun run;
      const std::size_t used = code.decode(left, run);
      if (used == 0) break;
      ASSERT_GE(run.count, 1u);
      ASSERT_LE(run.count, 0xFFFFu);
      ASSERT_LE(run.shift, 48);
      ASSERT_GE(run.shift, 0);
      left = left.subspan(used);
    }
  });
}

TEST(StepRunCode, a_run_that_ends_early_is_no_run) {
  StepRunCode code;
  std::array<std::uint8_t, StepRunCode::kBytesMax> bytes{};
  const std::size_t used =
      code.encode({.count = 500, .shift = 25, .interval = 200 << 25, .add = 77, .add2 = 3}, bytes);
  for (std::size_t size = 0; size < used; ++size) {
    StepRun run;
    EXPECT_EQ(StepRunCode().decode({bytes.data(), size}, run), 0u);
  }
}

}  // namespace
}  // namespace sinew::motion
