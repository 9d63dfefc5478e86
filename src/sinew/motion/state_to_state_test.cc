#include "sinew/motion/state_to_state.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "sinew/core/error_code.h"
#include "sinew/motion/joint_test_problem.h"
#include "support/allocation_guard.h"
#include "support/property.h"

namespace sinew::motion::test {
namespace {

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
constexpr double kInfinite = std::numeric_limits<double>::infinity();

TEST(StateToState, arrives_exactly_and_stays_inside_its_limits) {
  sinew::test::for_random_cases(cases_wanted(200'000), [](Random& random) {
    const JointProblem problem = random_problem(random);
    SCOPED_TRACE(testing::Message() << problem);
    const StateToState joint = planner(problem);
    const StateToState::Reach quickest = joint.next(0);
    const JointProfile profile = joint.profile(quickest.duration);
    ASSERT_NEAR(profile.duration(), quickest.duration, 1e-13 * quickest.duration + 1e-12);
    expect_sound(problem, profile);

    // And in any longer time that it says is possible.
    const double longer = quickest.duration * (1 + std::pow(10, random.uniform(-9, 1)));
    const StateToState::Reach slower = joint.next(longer);
    ASSERT_GE(slower.duration, longer * (1 - 1e-13));
    const JointProfile slow = joint.profile(slower.duration);
    ASSERT_NEAR(slow.duration(), slower.duration, 1e-13 * slower.duration + 1e-12);
    expect_sound(problem, slow);
  });
}

TEST(StateToState, solves_limits_with_ratios_of_a_million) {
  sinew::test::for_random_cases(50'000, [](Random& random) {
    const JointProblem problem = random_problem(random, 3);
    SCOPED_TRACE(testing::Message() << problem);
    const StateToState joint = planner(problem);
    const double duration = joint.next(0).duration;
    constexpr double kFewDigits = 1e-11;  // of ways of 1e9 m that end within 1 m
    expect_sound(problem, joint.profile(duration), 0, kFewDigits);
    const double longer = joint.next(duration * random.uniform(1, 3)).duration;
    expect_sound(problem, joint.profile(longer), 0, kFewDigits);
  });
}

TEST(StateToState, the_mirror_takes_the_same_time) {
  sinew::test::for_random_cases(50'000, [](Random& random) {
    const JointProblem problem = random_problem(random);
    SCOPED_TRACE(testing::Message() << problem);
    const StateToState one = planner(problem);
    const StateToState other = planner(mirrored(problem));
    const double duration = one.next(0).duration;
    ASSERT_NEAR(other.next(0).duration, duration, 1e-9 * duration);
    const double later = duration * random.uniform(1, 3);
    ASSERT_NEAR(other.next(later).duration, one.next(later).duration, 1e-9 * later);
  });
}

// The film run backwards: velocities turn round, accelerations do not.
TEST(StateToState, the_way_back_in_time_takes_the_same_time) {
  sinew::test::for_random_cases(50'000, [](Random& random) {
    const JointProblem problem = random_problem(random);
    SCOPED_TRACE(testing::Message() << problem);
    JointProblem back;
    back.start = {problem.target.q, -problem.target.qd, problem.target.qdd};
    back.target = {problem.start.q, -problem.start.qd, problem.start.qdd};
    back.bounds = problem.bounds;
    back.bounds.velocity_lower = -problem.bounds.velocity_upper;
    back.bounds.velocity_upper = -problem.bounds.velocity_lower;
    const double duration = planner(problem).next(0).duration;
    ASSERT_NEAR(planner(back).next(0).duration, duration, 1e-9 * duration);
  });
}

// Where the rest of the way is without choice (full jerk to the end), rounding of the state in
// between can make it impossible; then it takes another, longer way. That must stay an exception.
TEST(StateToState, planned_again_on_its_way_it_arrives_when_it_would_have) {
  std::uint64_t late = 0;
  const std::uint64_t cases = cases_wanted(100'000);
  sinew::test::for_random_cases(cases, [&](Random& random) {
    const JointProblem problem = random_problem(random);
    SCOPED_TRACE(testing::Message() << problem);
    const StateToState joint = planner(problem);
    const JointProfile profile = joint.profile(joint.next(0).duration);
    const double t = random.uniform(0, 1) * profile.duration();
    JointProblem rest = problem;
    rest.start = profile.at(t);
    const StateToState again = planner(rest);
    const double duration = again.next(0).duration;
    if (duration > profile.duration() - t + 1e-6 * profile.duration() + 1e-9) ++late;
    expect_sound(rest, again.profile(duration));
  });
  EXPECT_LE(late, cases / 5000);
}

TEST(StateToState, staying_takes_no_time) {
  const ProfileBounds bounds(AxisLimits{1, 2, 8});
  for (const AxisState& state : {AxisState{0, 0, 0}, AxisState{1, 1, 0}, AxisState{-2, -0.5, 2}}) {
    const StateToState joint(state, state, bounds);
    EXPECT_EQ(joint.next(0).duration, 0);
    EXPECT_FALSE(joint.next(0).binding.has_value());
    const JointProfile profile = joint.profile(0);
    EXPECT_EQ(profile.duration(), 0);
    EXPECT_EQ(profile.at(1).q, state.q);
  }
}

TEST(StateToState, from_rest_to_rest_it_is_the_symmetric_move) {
  sinew::test::for_random_cases(50'000, [](Random& random) {
    const AxisLimits limits{spread(random, 2), spread(random, 2), spread(random, 2)};
    const double distance = std::pow(10, random.uniform(-6, 2));
    const StateToState joint({0, 0, 0}, {distance, 0, 0}, ProfileBounds(limits));
    const double duration = plan_axis(distance, limits).duration();
    ASSERT_NEAR(joint.next(0).duration, duration, 1e-11 * duration);
    // Any longer time is possible too.
    const double longer = duration * random.uniform(1, 4);
    ASSERT_EQ(joint.next(longer).duration, longer);
  });
}

TEST(StateToState, says_what_binds) {
  const ProfileBounds bounds(AxisLimits{1, 2, 8});
  const auto binding = [&](double distance) {
    return *StateToState({0, 0, 0}, {distance, 0, 0}, bounds).next(0).binding;
  };
  EXPECT_EQ(binding(0.01), Binding::kJerk);
  EXPECT_EQ(binding(0.5), Binding::kAcceleration);
  EXPECT_EQ(binding(5), Binding::kVelocity);
}

// It arrives with the velocity that it has, but 1 mm too early: there is no time for a detour, so
// it must come back.
TEST(StateToState, blocked_durations_are_stepped_over) {
  const ProfileBounds bounds(AxisLimits{1, 2, 8});
  const StateToState joint({0, 0.5, 0}, {0.001, 0.5, 0}, bounds);
  const double quickest = joint.next(0).duration;
  EXPECT_NEAR(quickest, 0.002, 1e-5);
  // Slower on the way: only a little later.
  const StateToState::Reach latest = joint.next(quickest + 1e-12);
  EXPECT_LT(latest.duration, 0.0021);
  const StateToState::Reach next = joint.next(0.0021);
  EXPECT_GT(next.duration, 1);
  EXPECT_TRUE(next.binding.has_value());
  expect_sound({{0, 0.5, 0}, {0.001, 0.5, 0}, bounds}, joint.profile(next.duration));
  EXPECT_EQ(joint.next(next.duration + 1).duration, next.duration + 1);
}

TEST(StateToState, targets_that_cannot_be_held_are_refused) {
  const ProfileBounds bounds(AxisLimits{1, 2, 8});
  const auto code = [&](const AxisState& target) {
    return refusal_of_target(target, bounds)->code;
  };
  EXPECT_EQ(code({0, 1.001, 0}), ErrorCode::kTargetVelocity);
  EXPECT_EQ(code({0, -1.001, 0}), ErrorCode::kTargetVelocity);
  EXPECT_EQ(code({0, 0, 2.001}), ErrorCode::kTargetAcceleration);
  EXPECT_EQ(code({0, 0, -2.001}), ErrorCode::kTargetAcceleration);
  // 2^2 / 16 = 0.25 more or less is what it takes to lose or gain that acceleration.
  EXPECT_EQ(code({0, 0.76, 2}), ErrorCode::kTargetVelocity);
  EXPECT_EQ(code({0, 0.76, -2}), ErrorCode::kTargetVelocity);
  EXPECT_EQ(code({0, -0.76, 2}), ErrorCode::kTargetVelocity);
  const Error error = *refusal_of_target({0, -0.8, -2}, bounds);
  EXPECT_NEAR(error.measured, -1.05, 1e-15);
  EXPECT_EQ(error.limit, -1);
  EXPECT_FALSE(refusal_of_target({0, 0.75, 2}, bounds));
  EXPECT_FALSE(refusal_of_target({1e9, -1, 0}, bounds));
}

TEST(StateToState, what_is_no_number_is_refused) {
  const ProfileBounds good(AxisLimits{1, 2, 8});
  for (const double bad : {kNan, kInfinite, -kInfinite}) {
    for (const AxisState& state :
         {AxisState{bad, 0, 0}, AxisState{0, bad, 0}, AxisState{0, 0, bad}}) {
      EXPECT_EQ(refusal(state, good)->code, ErrorCode::kMotionInput);
      EXPECT_EQ(refusal_of_target(state, good)->code, ErrorCode::kMotionInput);
    }
  }
  for (double ProfileBounds::* const field :
       {&ProfileBounds::velocity_lower, &ProfileBounds::velocity_upper,
        &ProfileBounds::acceleration_lower, &ProfileBounds::acceleration_upper,
        &ProfileBounds::jerk}) {
    for (const double bad : {kNan, kInfinite, -kInfinite, 0.0, -(good.*field)}) {
      ProfileBounds bounds = good;
      bounds.*field = bad;
      EXPECT_EQ(refusal({0, 0, 0}, bounds)->code, ErrorCode::kMotionInput) << bad;
    }
  }
  EXPECT_FALSE(refusal({0, 99, 99}, good)) << "a start may be outside";
}

/// A start outside its limits, on one side or the other, in velocity, acceleration or both.
JointProblem random_problem_from_outside(Random& random) {
  JointProblem problem = random_problem(random);
  const ProfileBounds& bounds = problem.bounds;
  const double v = bounds.velocity_upper - bounds.velocity_lower;
  const double a = bounds.acceleration_upper - bounds.acceleration_lower;
  problem.start.qd = random.uniform(bounds.velocity_lower - v, bounds.velocity_upper + v);
  problem.start.qdd = random.uniform(bounds.acceleration_lower - a, bounds.acceleration_upper + a);
  return problem;
}

bool inside(const AxisState& state, const ProfileBounds& bounds) {
  const double later = state.qd + state.qdd * std::abs(state.qdd) / (2 * bounds.jerk);
  const auto between = [](double x, double low, double high) {
    const double slack = 1e-9 * (high - low);
    return x >= low - slack && x <= high + slack;
  };
  return between(state.qdd, bounds.acceleration_lower, bounds.acceleration_upper) &&
         between(state.qd, bounds.velocity_lower, bounds.velocity_upper) &&
         between(later, bounds.velocity_lower, bounds.velocity_upper);
}

TEST(Recovery, comes_back_inside_goes_on_and_arrives) {
  sinew::test::for_random_cases(cases_wanted(100'000), [](Random& random) {
    const JointProblem problem = random_problem_from_outside(random);
    SCOPED_TRACE(testing::Message() << problem);
    const Recovery back = recovery(problem.start, problem.bounds);
    ASSERT_TRUE(inside(back.state, problem.bounds));
    ASSERT_EQ(back.phases.empty(), inside(problem.start, problem.bounds));
    const StateToState joint = planner(problem);
    const double duration = joint.next(0).duration;
    ASSERT_GE(duration, back.duration);
    expect_sound(problem, joint.profile(duration), back.duration * (1 + 1e-12) + 1e-12);
    const double longer = joint.next(duration * random.uniform(1, 3)).duration;
    expect_sound(problem, joint.profile(longer), back.duration * (1 + 1e-12) + 1e-12);
  });
}

// Beyond a limit, the acceleration only comes nearer, with full jerk; a velocity that is too high
// gets no acceleration upwards that is not taken away with full jerk.
TEST(Recovery, lets_no_violation_grow_more_than_jerk_forces) {
  sinew::test::for_random_cases(cases_wanted(200'000), [](Random& random) {
    const JointProblem problem = random_problem_from_outside(random);
    SCOPED_TRACE(testing::Message() << problem);
    const ProfileBounds& bounds = problem.bounds;
    AxisState state = problem.start;
    for (const auto& [jerk, duration] : recovery(problem.start, bounds).phases) {
      const double slack = 1e-9 * (bounds.acceleration_upper - bounds.acceleration_lower);
      if (state.qdd > bounds.acceleration_upper + slack) {
        ASSERT_EQ(jerk, -bounds.jerk);
      } else if (state.qdd < bounds.acceleration_lower - slack) {
        ASSERT_EQ(jerk, bounds.jerk);
      } else if (state.qd > bounds.velocity_upper && state.qdd > 0) {
        ASSERT_EQ(jerk, -bounds.jerk);
      } else if (state.qd < bounds.velocity_lower && state.qdd < 0) {
        ASSERT_EQ(jerk, bounds.jerk);
      }
      state = advanced(state, jerk, duration);
    }
  });
}

// Of all ways with the acceleration inside its limits, by steps of full jerk.
TEST(Recovery, no_sequence_of_full_jerks_is_back_earlier) {
  sinew::test::for_random_cases(2'000, [](Random& random) {
    const std::int64_t up = random.integer(1, 4);
    const std::int64_t down = -random.integer(1, 4);
    ProfileBounds bounds;  // velocities in j h^2 / 2
    bounds.velocity_upper = static_cast<double>(random.integer(1, 20)) / 2;
    bounds.velocity_lower = -static_cast<double>(random.integer(1, 20)) / 2;
    bounds.acceleration_upper = static_cast<double>(up);
    bounds.acceleration_lower = static_cast<double>(down);
    bounds.jerk = 1;
    struct Step {
      std::int64_t v, a;
      bool operator==(const Step&) const = default;
    };
    const auto real = [](const Step& s) {
      return AxisState{0, static_cast<double>(s.v) / 2, static_cast<double>(s.a)};
    };
    std::vector<Step> reached{{random.integer(-40, 40), random.integer(down, up)}};
    const Recovery back = recovery(real(reached[0]), bounds);
    for (int n = 0; n < back.duration - 1e-9 && n < 8; ++n) {
      std::vector<Step> next;
      for (const Step& s : reached) {
        ASSERT_FALSE(inside(real(s), bounds)) << n << " < " << back.duration;
        for (const std::int64_t jerk : {-1, 0, 1}) {
          const Step then{s.v + 2 * s.a + jerk, s.a + jerk};
          const bool known = std::find(next.begin(), next.end(), then) != next.end();
          if (then.a >= down && then.a <= up && !known) next.push_back(then);
        }
      }
      reached = std::move(next);
    }
  });
}

TEST(StateToState, nothing_allocates) {
  const ProfileBounds bounds(AxisLimits{1, 2, 8});
  const sinew::test::AllocationCounter allocations;
  const StateToState joint({0, 1.5, 3}, {1, -0.5, 1}, bounds);
  const JointProfile quick = joint.profile(joint.next(0).duration);
  const JointProfile slow = joint.profile(joint.next(9).duration);
  EXPECT_EQ(allocations.count(), 0U);
  EXPECT_EQ(quick.end().q, slow.end().q);
}

}  // namespace
}  // namespace sinew::motion::test
