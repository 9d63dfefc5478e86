#include "sinew/planning/paths/move_check.h"

#include <gtest/gtest.h>

#include <cmath>

#include "support/property.h"

namespace sinew::planning {
namespace {

using test::for_random_cases;
using test::Random;

Joint joint_within(double lower, double upper) {
  Joint joint;
  joint.lower = lower;
  joint.upper = upper;
  joint.velocity_max = 1;
  joint.acceleration_max = 1;
  return joint;
}

PathPoint random_end(Random& random) {
  PathPoint end;
  for (std::size_t j = 0; j < 2; ++j) {
    end.q[j] = random.uniform(-1, 1);
    end.dq[j] = random.uniform(-5, 5);
    end.ddq[j] = random.uniform(-20, 20);
  }
  return end;
}

TEST(LimitBreak, is_found_inside_of_a_polynomial_where_a_dense_look_finds_it) {
  int broken = 0;
  for_random_cases(500, [&](Random& random) {
    JointPath path(2, 4);
    PathPoint last = random_end(random);
    for (int i = 0; i < 3; ++i) {
      const PathPoint next = random_end(random);
      ASSERT_TRUE(path.append_quintic(last, next, random.uniform(0.1, 1)));
      last = next;
    }
    const std::vector<Joint> joints{joint_within(-1.3, 1.3), joint_within(-1.3, 1.3)};
    const auto fault = first_limit_break(path, {0, path.size()}, joints);
    constexpr int kLooks = 5000;
    double first = path.length();
    double margin = 1;
    for (int k = 0; k <= kLooks; ++k) {
      PathPoint at;
      const double s = path.length() * k / kLooks;
      path.sample(s, at);
      for (std::size_t j = 0; j < 2; ++j) {
        margin = std::min(margin, 1.3 - std::abs(at.q[j]));
        if (!within_limits(joints[j], at.q[j])) first = std::min(first, s);
      }
    }
    if (!fault) {
      EXPECT_GT(margin, -1e-6);
      return;
    }
    ++broken;
    EXPECT_LT(margin, 1e-6);
    EXPECT_NEAR(fault->s, first, 2 * path.length() / kLooks + (margin > -1e-6 ? 3 : 0));
    PathPoint at;
    path.sample(fault->s, at);
    const auto j = static_cast<std::size_t>(fault->error.index);
    EXPECT_NEAR(std::abs(at.q[j]), 1.3, 1e-3);
    EXPECT_GT(excess(fault->error), 0);
  });
  EXPECT_GT(broken, 100);
}

TEST(LimitBreak, a_path_that_touches_its_limit_is_inside) {
  JointPath path(1, 2);
  PathPoint from;
  PathPoint top;
  PathPoint to;
  top.q[0] = 1;
  ASSERT_TRUE(path.append_quintic(from, top, 1));
  ASSERT_TRUE(path.append_quintic(top, to, 1));
  const std::vector<Joint> joints{joint_within(-1, 1)};
  EXPECT_FALSE(first_limit_break(path, {0, 2}, joints));
  const std::vector<Joint> narrower{joint_within(-1, 1 - 1e-6)};
  const auto fault = first_limit_break(path, {0, 2}, narrower);
  ASSERT_TRUE(fault);
  EXPECT_NEAR(fault->error.measured, 1, 1e-12);
  EXPECT_LT(fault->s, 1);
}

TEST(SlowestPlace, is_where_a_joint_turns_most) {
  JointPath path(1, 4);
  const std::array<double, 1> a{0};
  const std::array<double, 1> b{1};
  const std::array<double, 1> c{11};
  ASSERT_TRUE(path.append_line(a, b, 1));
  ASSERT_TRUE(path.append_line(b, c, 1));
  const std::vector<Joint> joints{joint_within(-20, 20)};
  const SlowestPlace slowest = slowest_place(path, {0, 2}, joints, 0.5);
  EXPECT_NEAR(slowest.rate, 0.05, 1e-15);
  EXPECT_NEAR(slowest.rate_elsewhere, 0.5, 1e-15);
  EXPECT_GE(slowest.s, 1);
}

}  // namespace
}  // namespace sinew::planning
