#include "sinew/motion/farthest.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <set>
#include <vector>

#include "sinew/motion/joint_test_problem.h"
#include "sinew/motion/state_to_state.h"

// References that share nothing with the planner: motions whose jerk is +j, 0 or -j in each step of
// a fixed length. In units of j h (acceleration), j h^2 / 2 (velocity) and j h^3 / 6 (position)
// their states are whole numbers, and all of them can be tried.

namespace sinew::motion::test {
namespace {

struct GridState {
  std::int64_t p = 0;
  std::int64_t v = 0;
  std::int64_t a = 0;
  auto operator<=>(const GridState&) const = default;
};

struct GridLimits {
  std::int64_t v_lower, v_upper, a_lower, a_upper;
  bool allow(const GridState& s) const {
    // The acceleration is 0 on a step or not at all, so that velocities are extreme on steps.
    return s.v >= v_lower && s.v <= v_upper && s.a >= a_lower && s.a <= a_upper;
  }
  /// The velocity stays inside if the acceleration is taken back at once.
  bool can_be_left(const GridState& s) const {
    const std::int64_t later = s.v + s.a * std::abs(s.a);
    return allow(s) && later >= v_lower && later <= v_upper;
  }
};

GridState step(const GridState& s, std::int64_t jerk) {
  return {s.p + 3 * s.v + 3 * s.a + jerk, s.v + 2 * s.a + jerk, s.a + jerk};
}

/// h = 1 / fineness, j = 1.
AxisState real(const GridState& s, double fineness) {
  const double h = 1 / fineness;
  return {static_cast<double>(s.p) * h * h * h / 6, static_cast<double>(s.v) * h * h / 2,
          static_cast<double>(s.a) * h};
}

ProfileBounds real(const GridLimits& limits, double fineness) {
  const double h = 1 / fineness;
  ProfileBounds bounds;
  bounds.velocity_lower = static_cast<double>(limits.v_lower) * h * h / 2;
  bounds.velocity_upper = static_cast<double>(limits.v_upper) * h * h / 2;
  bounds.acceleration_lower = static_cast<double>(limits.a_lower) * h;
  bounds.acceleration_upper = static_cast<double>(limits.a_upper) * h;
  bounds.jerk = 1;
  return bounds;
}

GridLimits random_limits(Random& random) {
  return {-random.integer(1, 40), random.integer(1, 40), -random.integer(1, 5),
          random.integer(1, 5)};
}

GridState random_start(Random& random, const GridLimits& limits) {
  for (;;) {
    const GridState start{0, random.integer(limits.v_lower, limits.v_upper),
                          random.integer(limits.a_lower, limits.a_upper)};
    if (limits.can_be_left(start)) return start;
  }
}

TEST(StateToState, no_sequence_of_full_jerks_is_quicker_or_arrives_at_a_blocked_time) {
  std::uint64_t compared = 0;
  std::uint64_t equal = 0;
  sinew::test::for_random_cases(cases_wanted(200'000) / 2000, [&](Random& random) {
    const GridLimits limits = random_limits(random);
    const ProfileBounds bounds = real(limits, 1);
    const GridState start = random_start(random, limits);
    std::set<GridState> reached{start};
    for (int n = 1; n <= 8; ++n) {
      std::set<GridState> next;
      for (const GridState& state : reached) {
        for (const std::int64_t jerk : {-1, 0, 1}) {
          const GridState then = step(state, jerk);
          if (limits.allow(then)) next.insert(then);
        }
      }
      reached = std::move(next);
      for (const GridState& end : reached) {
        const JointProblem problem{real(start, 1), real(end, 1), bounds};
        if (refusal_of_target(problem.target, bounds)) continue;
        SCOPED_TRACE(testing::Message() << problem << " in " << n);
        const StateToState joint = planner(problem);
        const double quickest = joint.next(0).duration;
        // Where the way hardly changes with time (1e-14 m in 1e-5 s), the time is worth no more.
        ASSERT_LE(quickest, n * (1 + 2e-5));
        ASSERT_LE(joint.next(n).duration, n * (1 + 1e-12));
        ++compared;
        if (std::abs(quickest - n) < 1e-9) ++equal;
      }
    }
  });
  EXPECT_GT(equal, compared / 100) << "the reference is never as quick: it proves nothing";
}

constexpr std::int64_t kNowhere = std::numeric_limits<std::int64_t>::min() / 2;

/// The farthest position at each velocity and acceleration after so many steps, from all sequences.
class FarthestOnGrid {
 public:
  FarthestOnGrid(const GridState& start, const GridLimits& limits)
      : limits_(limits),
        width_(static_cast<std::size_t>(limits.a_upper - limits.a_lower + 1)),
        now_(static_cast<std::size_t>(limits.v_upper - limits.v_lower + 1) * width_, kNowhere) {
    at(now_, start) = start.p;
  }

  void advance() {
    std::vector<std::int64_t> next(now_.size(), kNowhere);
    GridState state;
    for (state.v = limits_.v_lower; state.v <= limits_.v_upper; ++state.v) {
      for (state.a = limits_.a_lower; state.a <= limits_.a_upper; ++state.a) {
        state.p = at(now_, state);
        if (state.p == kNowhere) continue;
        for (const std::int64_t jerk : {-1, 0, 1}) {
          const GridState then = step(state, jerk);
          if (limits_.allow(then)) at(next, then) = std::max(at(next, then), then.p);
        }
      }
    }
    now_ = std::move(next);
  }

  /// kNowhere where no sequence ends with this velocity and acceleration.
  std::int64_t position(const GridState& s) { return at(now_, s); }

 private:
  std::int64_t& at(std::vector<std::int64_t>& table, const GridState& s) const {
    return table[static_cast<std::size_t>(s.v - limits_.v_lower) * width_ +
                 static_cast<std::size_t>(s.a - limits_.a_lower)];
  }
  GridLimits limits_;
  std::size_t width_;
  std::vector<std::int64_t> now_;
};

/// The same problem on a grid with steps of 1 / fineness.
GridState refined(const GridState& s, std::int64_t fineness) {
  return {s.p * fineness * fineness * fineness, s.v * fineness * fineness, s.a * fineness};
}

GridLimits refined(const GridLimits& limits, std::int64_t fineness) {
  const std::int64_t square = fineness * fineness;
  return {limits.v_lower * square, limits.v_upper * square, limits.a_lower * fineness,
          limits.a_upper * fineness};
}

bool contains(const std::array<TimeSpan, 2>& spans, double T, double margin) {
  return std::any_of(spans.begin(), spans.end(), [&](const TimeSpan& span) {
    return !span.empty() && T >= span.first + margin && T <= span.last - margin;
  });
}

// Which durations exist, and how far the joint comes in each: nothing of all sequences comes
// farther, and the best of them come as far up to what the grid's steps cost.
TEST(Farthest, is_as_far_as_the_best_of_all_sequences_of_full_jerks) {
  constexpr std::int64_t kFineness = 4;
  constexpr int kSteps = 40;
  std::uint64_t compared = 0;
  sinew::test::for_random_cases(cases_wanted(200'000) / 1000, [&](Random& random) {
    GridLimits coarse = random_limits(random);
    coarse.v_lower = std::max<std::int64_t>(coarse.v_lower, -16);
    coarse.v_upper = std::min<std::int64_t>(coarse.v_upper, 16);
    const GridLimits limits = refined(coarse, kFineness);
    const GridState start = refined(random_start(random, coarse), kFineness);
    GridState end = refined(random_start(random, coarse), kFineness);
    const ProfileBounds bounds = real(limits, kFineness);
    const AxisState from = real(start, kFineness);
    const AxisState to = real(end, kFineness);
    if (refusal_of_target(to, bounds)) return random.discard();
    const JointProblem problem{from, to, bounds};
    SCOPED_TRACE(testing::Message() << problem);
    const Farthest farthest(
        {from.qd, from.qdd}, {to.qd, to.qdd},
        {bounds.acceleration_upper, -bounds.acceleration_lower, bounds.velocity_upper});
    const auto spans = farthest.spans(1e-13);
    FarthestOnGrid grid(start, limits);
    for (int n = 1; n <= kSteps; ++n) {
      grid.advance();
      const double T = static_cast<double>(n) / kFineness;
      const std::int64_t position = grid.position(end);
      if (position == kNowhere) {
        // What exists in between steps only is no more than a few steps wide.
        ASSERT_FALSE(contains(spans, T, 2.0 / kFineness)) << T;
        continue;
      }
      // One phase of full jerk is the only motion in its time, and a matter of rounding.
      if (n == std::abs(end.a - start.a)) continue;
      ASSERT_TRUE(contains(spans, T, -1e-7)) << T;
      end.p = position;
      const double on_grid = real(end, kFineness).q;
      const double way = farthest.way(T);
      ASSERT_GE(way, on_grid - 1e-9) << T;
      if (!contains(spans, T, 2.0 / kFineness)) continue;
      // Switches have to move by parts of a step, which are felt for the rest of the time.
      ASSERT_LE(way, on_grid + 0.15 * T * T / kFineness) << T;
      ++compared;
    }
  });
  EXPECT_GT(compared, 0U);
}

TEST(Farthest, its_growth_is_the_derivative_of_its_way) {
  sinew::test::for_random_cases(100'000, [](Random& random) {
    const JointProblem problem = random_problem(random);
    const double j = problem.bounds.jerk;
    const Farthest farthest(
        {problem.start.qd / j, problem.start.qdd / j},
        {problem.target.qd / j, problem.target.qdd / j},
        {problem.bounds.acceleration_upper / j, -problem.bounds.acceleration_lower / j,
         problem.bounds.velocity_upper / j});
    const double T = farthest.spans(0)[1].first + std::pow(10, random.uniform(-2, 1));
    const double h = 1e-6 * T;
    const double slope = (farthest.way(T + h) - farthest.way(T - h)) / (2 * h);
    const double scale = 1 + std::abs(farthest.way(T)) / T + T * T;
    // Where the cruise begins, the slope jumps: the difference lies between both.
    const double below = std::min(farthest.way_growth(T - h), farthest.way_growth(T + h));
    const double above = std::max(farthest.way_growth(T - h), farthest.way_growth(T + h));
    ASSERT_GE(slope, below - 1e-6 * scale) << problem << " T " << T;
    ASSERT_LE(slope, above + 1e-6 * scale) << problem << " T " << T;
  });
}

}  // namespace
}  // namespace sinew::motion::test
