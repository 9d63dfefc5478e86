#include "sinew/planning/timing/path_timing.h"

#include <gtest/gtest.h>

#include <limits>

#include "sinew/core/error_code.h"
#include "sinew/planning/timing/path_timing_test_paths.h"
#include "sinew/planning/timing/path_timing_test_reference.h"
#include "support/allocation_guard.h"

namespace sinew::planning {
namespace {

using test::for_random_cases;
using test::Random;
using test_paths::Case;
using test_paths::ten_to;

/// The time that joint velocities and accelerations and the tool's speed need, without jerk:
/// forward and backward passes over v^2 on a fine grid, with every constraint as it is. A lower
/// bound, but for the grid.
double duration_without_jerk(const Case& test) {
  const PlannedPath& path = test.path;
  const std::size_t n = 4 * path.joints.size();
  const double h = path.joints.length() / static_cast<double>(n);
  std::vector<PathPoint> at(n + 1);
  std::vector<double> square(n + 1);
  const auto range = [&](std::size_t i, double vv) {
    const double s = h * static_cast<double>(i);
    const bool second = path.sections.size() > 1 && s >= path.sections[1].begin;
    const ToolRate& tool = path.tool[path.joints.piece_at(s)];
    const double asked = path.sections[second ? 1 : 0].tool_acceleration;
    double high = (asked - tool.curvature * vv) / tool.speed;
    double low = -high;
    for (std::size_t j = 0; j < test.limits.size(); ++j) {
      const double dq = at[i].dq[j];
      if (std::abs(dq) < 1e-9) continue;
      const double one = (-test.limits[j].acceleration - at[i].ddq[j] * vv) / dq;
      const double other = (test.limits[j].acceleration - at[i].ddq[j] * vv) / dq;
      low = std::max(low, std::min(one, other)), high = std::min(high, std::max(one, other));
    }
    return std::pair(low, high);
  };
  std::size_t piece = 0;
  for (std::size_t i = 0; i <= n; ++i) {
    const double s = h * static_cast<double>(i);
    piece = path.joints.piece_at(s, piece);
    path.joints.sample(s, at[i], piece);
    const bool second = path.sections.size() > 1 && s >= path.sections[1].begin;
    const PathSection& section = path.sections[second ? 1 : 0];
    double v = section.tool_speed / path.tool[piece].speed;
    for (std::size_t j = 0; j < test.limits.size(); ++j) {
      v = std::min(v, section.joint_share * test.limits[j].velocity /
                          std::max(1e-12, std::abs(at[i].dq[j])));
    }
    double low = 0, high = v * v;
    for (int k = 0; k < 60; ++k) {
      const double middle = (low + high) / 2;
      const auto [least, most] = range(i, middle);
      (least <= most ? low : high) = middle;
    }
    square[i] = high;
  }
  square[0] = square[n] = 0;
  for (std::size_t i = n; i-- > 0;) {
    square[i] = std::min(square[i],
                         square[i + 1] - 2 * h * std::min(0.0, range(i + 1, square[i + 1]).first));
  }
  double time = 0;
  for (std::size_t i = 0; i < n; ++i) {
    square[i + 1] =
        std::min(square[i + 1], square[i] + 2 * h * std::max(0.0, range(i, square[i]).second));
    time += 2 * h / (std::sqrt(square[i]) + std::sqrt(square[i + 1]));
  }
  return time;
}

struct Planner {
  PathTiming timing;
  TimeLaw law{timing.phases_max()};

  std::optional<Error> plan(const Case& test, double feed = 1) {
    if (const auto error = timing.prepare(test.path, test.limits, feed)) return error;
    return timing.plan({}, feed, law);
  }
};

void expect_within_limits(const Case& test, const TimeLaw& law, double feed, int samples = 40) {
  EXPECT_LE(check(test.path, law, test.limits, feed, samples).worst(), 1 + 1e-9);
  const PathState jump = test_paths::largest_jump(law);
  EXPECT_LE(jump.s, 1e-9);
  EXPECT_LE(jump.v, 1e-8);
  EXPECT_LE(jump.a, 1e-7);
}

TEST(PathTiming, a_straight_line_in_joint_space_takes_the_quickest_seven_phases) {
  Planner planner;
  for_random_cases(2000, [&](Random& random) {
    std::vector<double> to;
    std::vector<motion::AxisLimits> limits;
    for (int j = 0; j < 3; ++j) {
      to.push_back((random.chance(0.5) ? 1 : -1) * ten_to(random, -3, 1));
      limits.push_back({ten_to(random, -1, 1), ten_to(random, -1, 1), ten_to(random, -1, 1)});
    }
    const auto pieces = static_cast<std::size_t>(random.integer(1, 5));
    const Case line = test_paths::straight(to, limits, random.uniform(0.1, 3), pieces);
    ASSERT_FALSE(planner.plan(line).has_value());
    motion::AxisLimits most{1e300, 1e300, 1e300};
    const double length = line.path.joints.length();
    for (std::size_t j = 0; j < to.size(); ++j) {
      const double dq = std::abs(to[j]) / length;
      most.velocity = std::min(most.velocity, limits[j].velocity / dq);
      most.acceleration = std::min(most.acceleration, limits[j].acceleration / dq);
      most.jerk = std::min(most.jerk, limits[j].jerk / dq);
    }
    const double quickest = motion::plan_axis(length, most).duration();
    EXPECT_NEAR(planner.law.duration() / quickest, 1, 1e-8);
    EXPECT_LE(planner.law.size(), 7U);
    EXPECT_EQ(planner.law.end().s, length);
    EXPECT_EQ(planner.law.end().v, 0);
    EXPECT_EQ(planner.law.end().a, 0);
    expect_within_limits(line, planner.law, 1);
  });
}

TEST(PathTiming, random_splines_keep_every_limit_everywhere_and_end_at_rest_at_their_end) {
  Planner planner;
  double ratios = 0;
  double worst = 0;
  int cases = 0;
  for_random_cases(1000, [&](Random& random) {
    const Case test = test_paths::random_case(random);
    const double feed = random.chance(0.5) ? 1 : random.uniform(0.1, 2);
    ASSERT_FALSE(planner.plan(test, feed).has_value());
    expect_within_limits(test, planner.law, feed);
    EXPECT_EQ(planner.law.end().s, test.path.joints.length());
    EXPECT_EQ(planner.law.end().v, 0);
    EXPECT_EQ(planner.law.end().a, 0);
    if (feed != 1) return;
    const double ratio = planner.law.duration() / duration_without_jerk(test);
    EXPECT_GE(ratio, 0.99);
    EXPECT_LE(ratio, 6);
    ratios += ratio, worst = std::max(worst, ratio), ++cases;
  });
  std::cout << "  " << ratios / cases << " times the duration without jerk limits, at most "
            << worst << '\n';
  EXPECT_LE(ratios / cases, 1.5);
}

TEST(PathTiming, a_law_from_any_instant_of_another_feed_keeps_the_joints_limits) {
  Planner planner;
  TimeLaw next(planner.timing.phases_max());
  int plans = 0, refused = 0;
  for_random_cases(400, [&](Random& random) {
    const Case test = test_paths::random_case(random);
    ASSERT_FALSE(
        planner.timing.prepare(test.path, test.limits, 2, LawUse::kChangeable).has_value());
    ASSERT_FALSE(planner.timing.plan({}, random.uniform(0.1, 2), planner.law).has_value());
    for (int i = 0; i < 5; ++i) {
      ++plans;
      const PathState start = planner.law.sample(planner.law.duration() * random.uniform(0, 1));
      const double feed = random.uniform(0.05, 2);
      // What would not hold the limits is refused; then a stop does.
      if (const auto error = planner.timing.plan(start, feed, next)) {
        EXPECT_EQ(error->code, ErrorCode::kMotionInput);
        ++refused;
        continue;
      }
      Case any = test;
      for (PathSection& section : any.path.sections) {
        section.joint_share = 1;
        section.tool_speed = std::numeric_limits<double>::infinity();
      }
      EXPECT_LE(check(any.path, next, any.limits, 1, 20).worst(), 1 + 1e-9);
      EXPECT_NEAR(next.sample(0).v, start.v, 1e-9);
      EXPECT_EQ(next.end().s, test.path.joints.length());
      EXPECT_EQ(next.end().v, 0);
      ASSERT_FALSE(planner.timing.stop(start, next).has_value());
      EXPECT_LE(check(any.path, next, any.limits, 1, 20).worst(), 1 + 1e-9);
      EXPECT_EQ(next.end().v, 0);
      EXPECT_EQ(next.end().a, 0);
      EXPECT_LE(next.end().s, test.path.joints.length());
    }
  });
  EXPECT_LE(refused, plans / 100);
}

TEST(PathTiming, a_piece_of_a_nanometre_between_two_lines_does_no_harm) {
  Planner planner;
  Case test{PlannedPath(2, 3), {{1, 5, 50}, {1, 5, 50}}};
  const std::array<double, 2> q[4] = {{0, 0}, {0.5, 0.2}, {0.5 + 1e-9, 0.2}, {1, 0.4}};
  const double lengths[3] = {0.5, 1e-9, 0.5};
  for (std::size_t i = 0; i < 3; ++i) {
    ASSERT_TRUE(test.path.joints.append_line(q[i], q[i + 1], lengths[i]));
    test.path.tool.push_back({1, 0});
  }
  test.path.sections.push_back({});
  ASSERT_FALSE(planner.plan(test).has_value());
  expect_within_limits(test, planner.law, 1);
  Case tiny = test_paths::straight({1e-9, 0}, test.limits, 1e-9);
  ASSERT_FALSE(planner.plan(tiny).has_value());
  expect_within_limits(tiny, planner.law, 1);
  EXPECT_NEAR(planner.law.duration(), 4 * std::cbrt(1e-9 / (2 * 50)), 1e-9);
}

TEST(PathTiming, limits_that_differ_ten_thousand_times_are_all_kept) {
  Planner planner;
  for_random_cases(200, [&](Random& random) {
    Case test = test_paths::random_case(random, 10);
    for (auto& limit : test.limits) {
      const double scale = ten_to(random, -2, 2);
      limit = {limit.velocity * scale, limit.acceleration * scale, limit.jerk * scale};
    }
    ASSERT_FALSE(planner.plan(test).has_value());
    expect_within_limits(test, planner.law, 1, 10);
  });
}

TEST(PathTiming, a_narrow_blend_between_two_lines_is_taken_slowly_and_the_lines_quickly) {
  Planner planner;
  Case test{PlannedPath(2, 3), {{1, 5, 50}, {1, 5, 50}}};
  PathPoint in, out;
  in.q = {0.99, 0}, in.dq = {1, 0};
  out.q = {1, 0.01}, out.dq = {0, 1};
  ASSERT_TRUE(test.path.joints.append_line(std::array{0.0, 0.0}, std::array{0.99, 0.0}, 0.99));
  ASSERT_TRUE(test.path.joints.append_quintic(in, out, 0.0155));
  ASSERT_TRUE(test.path.joints.append_line(std::array{1.0, 0.01}, std::array{1.0, 1.0}, 0.99));
  test.path.tool.assign(3, {1, 0});
  test.path.sections.push_back({});
  ASSERT_FALSE(planner.plan(test).has_value());
  expect_within_limits(test, planner.law, 1);
  double quickest = 0;
  for (const LawPhase& phase : planner.law.phases()) quickest = std::max(quickest, phase.state.v);
  EXPECT_GT(quickest, 0.995);
  // Two lines of 1.29 s from rest to rest, and the blend at the little speed that its bend allows.
  EXPECT_LT(planner.law.duration(), 2 * 1.29 + 0.2);
}

TEST(PathTiming, four_thousand_pieces_are_planned_without_the_heap) {
  Planner planner;
  Random random(test::seed());
  const Case test = test_paths::random_spline(random, 6, 40, 100, 0.1);
  ASSERT_EQ(test.path.joints.size(), 4000U);
  const test::AllocationCounter counter;
  ASSERT_FALSE(planner.plan(test).has_value());
  ASSERT_FALSE(planner.timing.prepare(test.path, test.limits, 1, LawUse::kChangeable).has_value());
  ASSERT_FALSE(planner.timing.plan({}, 1, planner.law).has_value());
  ASSERT_FALSE(planner.timing.stop(planner.law.sample(1), planner.law).has_value());
  EXPECT_EQ(counter.count(), 0U);
  ASSERT_FALSE(planner.timing.plan({}, 1, planner.law).has_value());
  expect_within_limits(test, planner.law, 1, 4);
}

TEST(PathTiming, names_what_limits_a_motion) {
  Planner planner;
  const std::vector<motion::AxisLimits> limits{{1, 100, 10000}, {0.5, 100, 10000}};
  Case line = test_paths::straight({3, 3}, limits, 3);
  ASSERT_FALSE(planner.plan(line).has_value());
  EXPECT_EQ(planner.timing.limit_times().largest(), (PathLimit{LimitKind::kJointVelocity, 1}));
  EXPECT_NEAR(planner.timing.limit_times().total(), planner.law.duration(), 1e-9);
  line.path.sections[0].tool_speed = 0.1;
  ASSERT_FALSE(planner.plan(line).has_value());
  EXPECT_EQ(planner.timing.limit_times().largest(), (PathLimit{LimitKind::kToolSpeed, -1}));
  ASSERT_FALSE(planner.plan(line, 0.5).has_value());
  EXPECT_EQ(planner.timing.limit_times().largest(), (PathLimit{LimitKind::kFeed, -1}));
  line = test_paths::straight({3, 3}, {{100, 0.5, 1000}, {100, 1, 1000}}, 3);
  ASSERT_FALSE(planner.plan(line).has_value());
  EXPECT_EQ(planner.timing.limit_times().largest(), (PathLimit{LimitKind::kJointAcceleration, 0}));
  line = test_paths::straight({3, 3}, {{100, 50, 2}, {100, 50, 1}}, 3);
  ASSERT_FALSE(planner.plan(line).has_value());
  EXPECT_EQ(planner.timing.limit_times().largest(), (PathLimit{LimitKind::kJointJerk, 1}));
}

TEST(PathTiming, what_is_no_number_or_out_of_range_is_refused) {
  Planner planner;
  const double nan = std::numeric_limits<double>::quiet_NaN();
  Case line = test_paths::straight({1, 1}, {{1, 1, 1}, {1, nan, 1}}, 1);
  EXPECT_EQ(planner.plan(line)->index, 1);
  line.limits[1].acceleration = 0;
  EXPECT_EQ(planner.plan(line)->code, ErrorCode::kMotionInput);
  line.limits[1].acceleration = 1;
  ASSERT_FALSE(planner.plan(line).has_value());
  for (const PathState& start : {PathState{nan, 0, 0}, PathState{0, nan, 0}, PathState{0, 0, nan},
                                 PathState{-1, 0, 0}, PathState{2, 0, 0}, PathState{0, -1, 0}}) {
    EXPECT_TRUE(planner.timing.plan(start, 1, planner.law).has_value());
    EXPECT_TRUE(planner.timing.stop(start, planner.law).has_value());
  }
  for (const double feed : {nan, 0.0, -1.0, 1.5}) {
    EXPECT_TRUE(planner.timing.plan({}, feed, planner.law).has_value());
  }
  // Too quick to stop before the end.
  EXPECT_TRUE(planner.timing.plan({0.99, 0.9, 0}, 1, planner.law).has_value());
  line = test_paths::straight({1, nan}, {{1, 1, 1}, {1, 1, 1}}, 1);
  EXPECT_TRUE(planner.plan(line).has_value());
  PathTiming small(2);
  line = test_paths::straight({1, 1}, {{1, 1, 1}, {1, 1, 1}}, 1, 3);
  EXPECT_EQ(small.prepare(line.path, line.limits)->code, ErrorCode::kProgramTooLong);
}

TEST(PathTiming, takes_little_longer_than_a_long_optimisation_finds) {
  Planner planner;
  double ratios = 0, worst = 0, changeable = 0;
  int cases = 0;
  for_random_cases(12, [&](Random& random) {
    const Case test = test_paths::random_case(random);
    ASSERT_FALSE(planner.plan(test).has_value());
    const double reference = test_paths::QuickestMotion(test.path, test.limits, 600).duration();
    const double ratio = planner.law.duration() / reference;
    ratios += ratio, worst = std::max(worst, ratio), ++cases;
    ASSERT_FALSE(
        planner.timing.prepare(test.path, test.limits, 1, LawUse::kChangeable).has_value());
    ASSERT_FALSE(planner.timing.plan({}, 1, planner.law).has_value());
    changeable += planner.law.duration() / reference;
  });
  std::cout << "  " << ratios / cases << " times the reference, at most " << worst
            << "; changeable laws " << changeable / cases << '\n';
  EXPECT_LE(ratios / cases, 1.04);
  EXPECT_LE(worst, 1.08);
  EXPECT_GE(ratios / cases, 0.99);
}

TEST(PathTiming, the_reference_finds_the_seven_phases_of_a_straight_line) {
  const Case line = test_paths::straight({1}, {{0.5, 1, 4}}, 1);
  const double quickest = motion::plan_axis(1, line.limits[0]).duration();
  test_paths::QuickestMotion reference(line.path, line.limits, 800);
  EXPECT_NEAR(reference.duration() / quickest, 1, 0.005);
}

/// Ways on which the tool turns on the spot, one joint turns alone, or nothing turns at all.
Case standing_case(Random& random) {
  Case test{PlannedPath(3, 64), {}};
  for (int j = 0; j < 3; ++j) {
    test.limits.push_back({ten_to(random, -0.5, 0.5), ten_to(random, 0, 1), ten_to(random, 0, 2)});
  }
  PathPoint at;
  const auto way = static_cast<std::size_t>(random.integer(2, 6));
  for (std::size_t i = 0; i < way; ++i) {
    PathPoint next = at;
    const auto kind = random.integer(0, 2);
    for (std::size_t j = 0; j < 3; ++j) {
      // Level at its ends: a joint that only turns within a piece stands at both of its borders.
      const bool turns = kind == 0 || (kind == 1 && j == i % 3);
      next.q[j] = at.q[j] + (turns ? random.uniform(-1, 1) : 0);
      next.dq[j] = kind == 0 && i + 1 < way ? random.uniform(-1, 1) : 0;
    }
    const double length = random.uniform(0.1, 0.5);
    EXPECT_TRUE(test.path.joints.append_quintic(at, next, length));
    test.path.tool.push_back({kind == 0 ? 1.0 : 0.0, kind == 0 ? 1.0 : 0.0});
    at = next;
  }
  test.path.sections.push_back({0, 0, random.chance(0.5) ? 0.3 : 1e9, 2, 1});
  return test;
}

TEST(PathTiming, stretches_where_the_tool_or_some_joints_or_all_stand_keep_every_limit) {
  Planner planner;
  for_random_cases(200, [&](Random& random) {
    const Case test = standing_case(random);
    for (const LawUse use : {LawUse::kQuickest, LawUse::kChangeable}) {
      ASSERT_FALSE(planner.timing.prepare(test.path, test.limits, 1, use).has_value());
      ASSERT_FALSE(planner.timing.plan({}, 1, planner.law).has_value());
      EXPECT_LE(check(test.path, planner.law, test.limits, 1, 20).worst(), 1 + 1e-9);
      // Where nothing moves s is as quick as it likes.
      PathState most{1, 1, 1};
      for (const LawPhase& phase : planner.law.phases()) {
        most.v = std::max(most.v, phase.state.v);
        most.a = std::max(most.a, std::abs(phase.state.a));
      }
      const PathState jump = test_paths::largest_jump(planner.law);
      EXPECT_LE(jump.s, 1e-9);
      EXPECT_LE(jump.v, 1e-9 * most.v);
      EXPECT_LE(jump.a, 1e-9 * most.a);
      EXPECT_EQ(planner.law.end().s, test.path.joints.length());
      EXPECT_EQ(planner.law.end().v, 0);
    }
  });
}

// Once such a cell passed for a cubic, and a jerk came 0.8 % beyond its limit.
TEST(PathTiming, a_cell_whose_ends_have_the_same_third_derivative_may_still_bend_between) {
  Planner planner;
  for_random_cases(200, [&](Random& random) {
    Case test{PlannedPath(2, 3), {}};
    PathPoint at;
    for (int i = 0; i < 3; ++i) {
      PathPoint next;
      for (std::size_t j = 0; j < 2; ++j) next.q[j] = at.q[j] + random.uniform(-1, 1);
      ASSERT_TRUE(test.path.joints.append_quintic(at, next, random.uniform(0.1, 2)));
      test.path.tool.push_back({1, 1});
      at = next;
    }
    test.path.sections.push_back({});
    for (int j = 0; j < 2; ++j) test.limits.push_back({10, 10, ten_to(random, 0, 1)});
    ASSERT_FALSE(planner.plan(test).has_value());
    EXPECT_LE(check(test.path, planner.law, test.limits, 1, 20).worst(), 1 + 1e-9);
  });
}

TEST(PathTiming, a_plan_in_parts_looks_at_a_bounded_number_of_cells_and_is_the_same_plan) {
  Planner planner;
  TimeLaw law(planner.timing.phases_max());
  for_random_cases(40, [&](Random& random) {
    const Case test = test_paths::random_case(random);
    ASSERT_FALSE(planner.timing.prepare(test.path, test.limits).has_value());
    ASSERT_FALSE(planner.timing.begin(0, 1).has_value());
    ASSERT_TRUE(planner.timing.advance(std::numeric_limits<std::size_t>::max(), planner.law));
    const auto part = static_cast<std::size_t>(random.integer(1, 200));
    const test::AllocationCounter counter;
    ASSERT_FALSE(planner.timing.begin(0, 1).has_value());
    std::size_t parts = 1;
    while (!planner.timing.advance(part, law)) ++parts;
    EXPECT_EQ(counter.count(), 0U);
    EXPECT_LE(parts, PathTiming::kLooksMax * planner.timing.curve_cells() / part + 1);
    EXPECT_EQ(law.duration(), planner.law.duration());
    EXPECT_EQ(law.size(), planner.law.size());
    expect_within_limits(test, law, 1, 10);
  });
}

TEST(PathTiming, a_law_to_be_followed_as_it_is_begins_at_rest_anywhere_and_cannot_be_changed) {
  Planner planner;
  for_random_cases(100, [&](Random& random) {
    const Case test = test_paths::random_case(random);
    ASSERT_FALSE(planner.plan(test).has_value());
    const PathState moving = planner.law.sample(planner.law.duration() / 2);
    EXPECT_TRUE(planner.timing.plan(moving, 1, planner.law).has_value());
    EXPECT_TRUE(planner.timing.stop(moving, planner.law).has_value());
    const double from = test.path.joints.length() * random.uniform(0, 0.999);
    ASSERT_FALSE(planner.timing.plan({from, 0, 0}, 1, planner.law).has_value());
    expect_within_limits(test, planner.law, 1, 10);
    EXPECT_EQ(planner.law.sample(0).s, from);
    EXPECT_EQ(planner.law.end().s, test.path.joints.length());
  });
}

}  // namespace
}  // namespace sinew::planning
