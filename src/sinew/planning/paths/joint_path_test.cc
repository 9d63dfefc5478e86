#include "sinew/planning/paths/joint_path.h"

#include <gtest/gtest.h>

#include <cmath>

#include "support/allocation_guard.h"
#include "support/property.h"

namespace sinew::planning {
namespace {

using test::for_random_cases;
using test::Random;

JointArray random_joints(Random& random, std::size_t joints, double scale) {
  JointArray values{};
  for (std::size_t j = 0; j < joints; ++j) values[j] = random.uniform(-scale, scale);
  return values;
}

void expect_continuous(const JointPath& path) {
  for (std::size_t i = 0; i + 1 < path.size(); ++i) {
    PathPoint before;
    PathPoint behind;
    path.sample_piece(i, path.begin(i + 1) - path.begin(i), before);
    path.sample_piece(i + 1, 0, behind);
    for (std::size_t j = 0; j < path.joints(); ++j) {
      EXPECT_NEAR(before.q[j], behind.q[j], 1e-10);
      EXPECT_NEAR(before.dq[j], behind.dq[j], 1e-8);
      EXPECT_NEAR(before.ddq[j], behind.ddq[j], 1e-6);
    }
  }
}

TEST(JointPath, a_quintic_has_the_values_and_derivatives_that_it_was_given_at_both_ends) {
  for_random_cases(2000, [](Random& random) {
    const std::size_t joints = static_cast<std::size_t>(random.integer(1, kMaxJoints));
    JointPath path(joints, 4);
    PathPoint ends[2];
    for (PathPoint& end : ends) {
      end.q = random_joints(random, joints, 3);
      end.dq = random_joints(random, joints, 3);
      end.ddq = random_joints(random, joints, 3);
    }
    const double length = random.uniform(0.1, 3);
    ASSERT_TRUE(path.append_quintic(ends[0], ends[1], length));
    for (int k = 0; k < 2; ++k) {
      PathPoint at;
      path.sample(k * length, at);
      for (std::size_t j = 0; j < joints; ++j) {
        EXPECT_NEAR(at.q[j], ends[k].q[j], 1e-10);
        EXPECT_NEAR(at.dq[j], ends[k].dq[j], 1e-9);
        EXPECT_NEAR(at.ddq[j], ends[k].ddq[j], 1e-7);
      }
    }
  });
}

TEST(JointPath, a_spline_goes_through_its_points_without_a_jump_in_its_second_derivative) {
  for_random_cases(500, [](Random& random) {
    const std::size_t joints = static_cast<std::size_t>(random.integer(1, kMaxJoints));
    const std::size_t n = static_cast<std::size_t>(random.integer(2, 31));
    JointPath path(joints, 64);
    const JointArray first = random_joints(random, joints, 1);
    ASSERT_TRUE(
        path.append_line(std::span(first.data(), joints), std::span(first.data(), joints), 0.5));
    std::vector<double> knots{0};
    std::vector<JointArray> points{random_joints(random, joints, 1)};
    for (std::size_t i = 1; i < n; ++i) {
      knots.push_back(knots.back() + random.uniform(0.05, 0.5));
      points.push_back(random_joints(random, joints, 1));
    }
    const JointArray begin = random_joints(random, joints, 2);
    const JointArray end = random_joints(random, joints, 2);
    ASSERT_TRUE(path.append_spline(knots, points, begin, end));
    ASSERT_EQ(path.size(), n);
    for (std::size_t i = 0; i < n; ++i) {
      PathPoint at;
      path.sample(0.5 + knots[i], at);
      for (std::size_t j = 0; j < joints; ++j) EXPECT_NEAR(at.q[j], points[i][j], 1e-10);
    }
    PathPoint at;
    path.sample_piece(1, 0, at);
    for (std::size_t j = 0; j < joints; ++j) EXPECT_NEAR(at.dq[j], begin[j], 1e-9);
    path.sample(path.length(), at);
    for (std::size_t j = 0; j < joints; ++j) EXPECT_NEAR(at.dq[j], end[j], 1e-9);
    JointPath alone(joints, 64);
    ASSERT_TRUE(alone.append_spline(knots, points, begin, end));
    expect_continuous(alone);
  });
}

TEST(JointPath, a_spline_of_a_sine_is_as_near_as_the_fourth_power_of_its_step) {
  double last_error = 0;
  for (const int n : {10, 20, 40}) {
    std::vector<double> knots;
    std::vector<JointArray> points;
    for (int i = 0; i <= n; ++i) {
      knots.push_back(3.0 * i / n);
      points.push_back({std::sin(3.0 * i / n)});
    }
    JointPath path(1, 64);
    ASSERT_TRUE(path.append_spline(knots, points, {1}, {std::cos(3.0)}));
    double error = 0;
    for (int i = 0; i <= 1000; ++i) {
      PathPoint at;
      path.sample(0.003 * i, at);
      error = std::max(error, std::abs(at.q[0] - std::sin(0.003 * i)));
    }
    EXPECT_LT(error, 0.01 * std::pow(3.0 / n, 4));
    if (last_error > 0) {
      EXPECT_LT(error, last_error / 12);
    }
    last_error = error;
  }
}

TEST(JointPath, derivatives_are_those_of_the_values) {
  for_random_cases(300, [](Random& random) {
    JointPath path(1, 4);
    PathPoint ends[2];
    for (PathPoint& end : ends) {
      end.q[0] = random.uniform(-1, 1), end.dq[0] = random.uniform(-1, 1),
      end.ddq[0] = random.uniform(-1, 1);
    }
    ASSERT_TRUE(path.append_quintic(ends[0], ends[1], 1));
    const double s = random.uniform(0.1, 0.9);
    constexpr double kStep = 1e-4;
    PathPoint below;
    PathPoint at;
    PathPoint above;
    path.sample(s - kStep, below), path.sample(s, at), path.sample(s + kStep, above);
    EXPECT_NEAR(at.dq[0], (above.q[0] - below.q[0]) / (2 * kStep), 1e-5);
    EXPECT_NEAR(at.ddq[0], (above.dq[0] - below.dq[0]) / (2 * kStep), 1e-4);
    EXPECT_NEAR(at.dddq[0], (above.ddq[0] - below.ddq[0]) / (2 * kStep), 1e-3);
  });
}

TEST(JointPath, finds_the_piece_whatever_the_hint_and_holds_its_ends) {
  JointPath path(2, 8);
  const std::array<double, 2> a{0, 1};
  const std::array<double, 2> b{1, 3};
  ASSERT_TRUE(path.append_line(a, b, 0.5));
  ASSERT_TRUE(path.append_line(b, a, 0.25));
  for (const std::size_t hint : {0U, 1U, 7U}) {
    EXPECT_EQ(path.piece_at(-1, hint), 0U);
    EXPECT_EQ(path.piece_at(0.49, hint), 0U);
    EXPECT_EQ(path.piece_at(0.5, hint), 1U);
    EXPECT_EQ(path.piece_at(9, hint), 1U);
  }
  PathPoint at;
  path.sample(-1, at);
  EXPECT_EQ(at.q[1], 1);
  path.sample(5, at);
  EXPECT_NEAR(at.q[1], 1, 1e-15);
  path.truncate(1);
  EXPECT_EQ(path.length(), 0.5);
}

TEST(JointPath, what_does_not_fit_is_refused_and_nothing_allocates) {
  JointPath path(6, 5);
  const JointArray zero{};
  const std::vector<double> knots{0, 1, 2, 3, 4, 5};
  const std::vector<JointArray> points(6);
  const test::AllocationCounter counter;
  EXPECT_TRUE(path.append_spline(knots, points, zero, zero));
  EXPECT_FALSE(path.append_line(std::span(zero.data(), 6), std::span(zero.data(), 6), 1));
  EXPECT_FALSE(path.append_quintic({}, {}, 1));
  path.truncate(1);
  EXPECT_FALSE(path.append_spline(knots, points, zero, zero));
  EXPECT_EQ(path.length(), 1);
  EXPECT_EQ(counter.count(), 0U);
}

}  // namespace
}  // namespace sinew::planning
