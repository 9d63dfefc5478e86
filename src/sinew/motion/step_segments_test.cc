#include "sinew/motion/step_segments.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <vector>

#include "sinew/motion/step_test_plans.h"
#include "support/property.h"

namespace sinew::motion {
namespace {

using namespace test_plans;
using Reason = StepRefusal::Reason;

TEST(StepSegments, phases_of_a_move_are_its_samples) {
  test::for_random_cases(2000, [](test::Random& random) {
    const AxisLimits limits{random.uniform(0.1, 2), random.uniform(0.1, 9), random.uniform(1, 99)};
    const double q = random.uniform(-3, 3);
    const double target = random.uniform(-3, 3);
    const JerkLimitedMove move = plan_axis(std::abs(target - q), limits);
    const auto phases = jerk_phases(move, q, target - q);
    const double from[] = {q};
    const double to[] = {target};
    const RestToRest plan(from, to, {&limits, 1});
    double t = 0;
    AxisStates states;
    for (const JerkPhase& phase : phases) {
      for (const double share : {0.0, 0.4, 1.0}) {
        const double inside = share * phase.duration;
        const AxisState state = advanced(phase.start, phase.jerk, inside);
        plan.sample(t + inside, states);
        ASSERT_NEAR(state.q, states.q[0], 1e-12);
        ASSERT_NEAR(state.qd, states.qd[0], 1e-11);
      }
      t += phase.duration;
    }
    ASSERT_NEAR(t, move.duration(), 1e-12);
    const JerkPhase& last = phases.back();
    ASSERT_NEAR(advanced(last.start, last.jerk, last.duration).q, target, 1e-14);
  });
}

TEST(StepSegments, each_begins_where_the_one_before_ends_to_the_last_bit) {
  test::for_random_cases(300, [](test::Random& random) {
    const auto phases = random_phases(random, std::pow(10, random.uniform(-2, 1)));
    StepSegments converter(hardware(), phases[0].start.q);
    const auto segments = converted(converter, phases);
    std::int64_t offset = converter.start_offset();
    std::int64_t steps = converter.start_steps();
    std::uint64_t clock = 0;
    for (const StepSegment& segment : segments) {
      const auto made = static_cast<std::int64_t>(segment.steps) * segment.direction;
      offset += segment.direction * segment.way(segment.u_at(segment.duration)) -
                made * StepSegment::kStep;
      steps += made;
      clock += segment.duration;
    }
    ASSERT_EQ(offset, converter.offset());
    ASSERT_EQ(steps, converter.steps());
    ASSERT_EQ(clock, converter.clock());
    double time = 0;
    for (const JerkPhase& phase : phases) time += phase.duration;
    ASSERT_NEAR(static_cast<double>(clock), time * 1e6, 0.5001);
  });
}

TEST(StepSegments, a_plan_in_parts_makes_the_same_steps) {
  test::for_random_cases(200, [](test::Random& random) {
    const auto phases = random_phases(random, 3);
    StepSegments whole(hardware(), phases[0].start.q);
    const auto at_once = play(whole, converted(whole, phases)).steps;
    StepSegments parts(hardware(), phases[0].start.q);
    std::vector<StepSegment> segments;
    for (const JerkPhase& phase : phases) {
      for (const StepSegment& segment : converted(parts, {&phase, 1})) segments.push_back(segment);
    }
    const auto in_parts = play(parts, segments).steps;
    ASSERT_EQ(at_once.size(), in_parts.size());
    for (std::size_t i = 0; i < at_once.size(); ++i) {
      ASSERT_EQ(at_once[i].tick, in_parts[i].tick);
      ASSERT_EQ(at_once[i].direction, in_parts[i].direction);
    }
  });
}

TEST(StepSegments, a_motor_that_turns_against_the_joint_makes_mirrored_steps) {
  test::for_random_cases(100, [](test::Random& random) {
    const auto phases = random_phases(random, 3);
    StepHardware mirrored = hardware();
    mirrored.steps_per_unit = -kStepsPerRad;
    StepSegments there(hardware(), phases[0].start.q);
    StepSegments back(mirrored, phases[0].start.q);
    const auto steps = play(there, converted(there, phases)).steps;
    const auto others = play(back, converted(back, phases)).steps;
    ASSERT_EQ(steps.size(), others.size());
    for (std::size_t i = 0; i < steps.size(); ++i) {
      ASSERT_EQ(steps[i].direction, -others[i].direction);
      ASSERT_NEAR(static_cast<double>(steps[i].tick), static_cast<double>(others[i].tick), 1);
    }
  });
}

/// Thrown up to `height` steps and caught, with half a second each way.
std::vector<JerkPhase> throw_to(double height) {
  const double h = height / kStepsPerRad;
  return {{{0, 4 * h, -8 * h}, 0, 1}};
}

TEST(StepSegments, a_turn_that_barely_passes_a_step_leaves_it_out) {
  StepHardware careful = hardware();
  careful.direction_setup = 5e-6;
  // 100 steps up and 1e-9 beyond the middle to the next: to and fro in 3 us.
  StepSegments converter(careful, 0);
  const auto segments = converted(converter, throw_to(100.5 + 1e-9));
  EXPECT_EQ(converter.merged_reversals(), 1);
  EXPECT_EQ(converter.steps(), 0);
  const auto steps = play(converter, segments).steps;
  ASSERT_EQ(steps.size(), 200u);
  EXPECT_EQ(steps[99].direction, 1);
  EXPECT_EQ(steps[100].direction, -1);
  EXPECT_GT(steps[100].tick - steps[99].tick, 5000u);

  // A little higher there is time enough.
  StepSegments higher(careful, 0);
  const auto more = converted(higher, throw_to(100.5 + 1e-7));
  EXPECT_EQ(higher.merged_reversals(), 0);
  const auto all = play(higher, more).steps;
  ASSERT_EQ(all.size(), 202u);
  EXPECT_GE(all[101].tick - all[100].tick, 5u);
}

TEST(StepSegments, every_direction_change_has_its_set_up_time) {
  std::uint64_t merged = 0;
  test::for_random_cases(2000, [&](test::Random& random) {
    StepHardware slow = hardware();
    slow.direction_setup = 8e-3;
    const auto phases = random_phases(random, std::pow(10, random.uniform(-2, 0)));
    StepSegments converter(slow, phases[0].start.q);
    std::vector<StepSegment> segments(4096);
    const auto size = converter.convert(phases, segments);
    ASSERT_TRUE(size);
    merged += static_cast<std::uint64_t>(converter.merged_reversals());
    const auto steps = play(converter, {segments.data(), *size}).steps;
    for (std::size_t i = 1; i < steps.size(); ++i) {
      if (steps[i].direction == steps[i - 1].direction) continue;
      ASSERT_GE(steps[i].tick - steps[i - 1].tick, 8000u);
    }
    // What was left out is not missing.
    const double position = static_cast<double>(converter.steps()) +
                            static_cast<double>(converter.offset()) / StepSegment::kStep;
    const AxisState end = advanced(phases.back().start, phases.back().jerk, phases.back().duration);
    ASSERT_NEAR(position, end.q * kStepsPerRad, position_tolerance(phases, 1e6));
  });
  EXPECT_GT(merged, 10u);
}

TEST(StepSegments, what_cannot_be_stepped_is_refused_and_nothing_changes) {
  StepSegments converter(hardware(), 0);
  std::vector<StepSegment> out(16);
  const auto refused = [&](const JerkPhase& phase) {
    const auto result = converter.convert({&phase, 1}, out);
    EXPECT_FALSE(result);
    EXPECT_EQ(converter.clock(), 0u);
    return result ? Reason::kTooMany : result.error().reason;
  };
  // 2 us from step to step, and one tick of rounding.
  EXPECT_EQ(refused({{0, 340e3 / kStepsPerRad, 0}, 0, 1}), Reason::kTooFast);
  // Too fast in the middle only, where neither end shows it.
  const double peak = 340e3 / kStepsPerRad;
  EXPECT_EQ(refused({{0, 0, 4 * peak}, -8 * peak, 1}), Reason::kTooFast);
  EXPECT_EQ(refused({{1e-6, 0, 0}, 0, 1}), Reason::kGap);
  EXPECT_EQ(refused({{0, 0, 0}, 0, -1}), Reason::kNotANumber);
  EXPECT_EQ(refused({{0, 0, std::numeric_limits<double>::quiet_NaN()}, 0, 1}), Reason::kNotANumber);
  const JerkPhase fine{{0, 330e3 / kStepsPerRad, 0}, 0, 1};
  EXPECT_TRUE(converter.convert({&fine, 1}, out));
}

TEST(StepSegments, a_refusal_says_when_and_by_how_much) {
  StepSegments converter(hardware(), 0);
  std::vector<StepSegment> out(16);
  const std::vector<JerkPhase> phases{{{0, 0, 0}, 0, 2}, {{0, 500e3 / kStepsPerRad, 0}, 0, 1}};
  const auto result = converter.convert(phases, out);
  ASSERT_FALSE(result);
  EXPECT_NEAR(result.error().time, 2, 1e-9);
  EXPECT_NEAR(result.error().measured, 1e-6, 1e-12);
  EXPECT_NEAR(result.error().limit, 2e-6, 1e-12);
}

TEST(StepSegments, too_little_room_is_refused) {
  StepSegments converter(hardware(), 0);
  std::vector<StepSegment> out(1);
  const auto result = converter.convert(throw_to(100), out);
  ASSERT_FALSE(result);
  EXPECT_EQ(result.error().reason, Reason::kTooMany);
  EXPECT_EQ(converter.steps(), 0);
}

TEST(StepSegments, a_turn_between_two_calls_is_refused_where_it_is_too_quick) {
  StepHardware careful = hardware();
  careful.direction_setup = 5e-6;
  StepSegments converter(careful, 0);
  const JerkPhase whole = throw_to(100.5 + 1e-9)[0];
  const JerkPhase up{whole.start, 0, 0.5};
  const JerkPhase down{advanced(whole.start, 0, 0.5), 0, 0.5};
  converted(converter, {&up, 1});
  ASSERT_EQ(converter.steps(), 101);
  std::vector<StepSegment> out(4);
  const auto result = converter.convert({&down, 1}, out);
  ASSERT_FALSE(result);
  EXPECT_EQ(result.error().reason, Reason::kReversalQuick);
}

TEST(StepSegments, long_and_far_phases_are_cut_until_they_fit) {
  StepSegments converter(hardware(72e6), 0);
  // Ten minutes, and five million steps in one phase.
  const std::vector<JerkPhase> phases{{{0, 0, 0}, 0, 600}, {{0, 100e3 / kStepsPerRad, 0}, 0, 50}};
  const auto segments = converted(converter, phases);
  EXPECT_GT(segments.size(), 20u);
  for (const StepSegment& segment : segments) {
    EXPECT_LE(segment.duration, StepSegment::kTicksMax);
    EXPECT_LT(std::abs(segment.c1) + std::abs(segment.c2) + std::abs(segment.c3),
              StepSegment::kCoefficientsMax);
  }
  EXPECT_EQ(converter.clock(), 650 * 72'000'000ULL);
  EXPECT_EQ(converter.steps(), 5'000'000);
}

}  // namespace
}  // namespace sinew::motion
