#include "sinew/planning/collision/shape_distance.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <vector>

#include "sinew/core/rotation.h"
#include "sinew/core/units.h"
#include "support/allocation_guard.h"
#include "support/property.h"

namespace sinew::planning {
namespace {

using test::Random;

Vec3 random_vector(Random& random, double size) {
  return {random.uniform(-size, size), random.uniform(-size, size), random.uniform(-size, size)};
}

Vec3 random_direction(Random& random) {
  for (;;) {
    const Vec3 v = random_vector(random, 1);
    if (norm(v) > 0.1 && norm(v) <= 1) return normalized(v);
  }
}

/// Of every tenth or so two things coincide: lengths of zero, parallel axes, the same place.
PlacedCapsule random_capsule(Random& random) {
  PlacedCapsule capsule;
  capsule.a = random_vector(random, 0.3);
  capsule.b = capsule.a + random_vector(random, 0.3);
  if (random.chance(0.1)) capsule.b = capsule.a;
  if (random.chance(0.2)) capsule.b = capsule.a + Vec3{0, 0, random.uniform(-0.4, 0.4)};
  capsule.radius = random.uniform(0.001, 0.1);
  return capsule;
}

PlacedBox random_box(Random& random) {
  PlacedBox box;
  box.X.p = random_vector(random, 0.3);
  if (random.chance(0.1)) box.X.p = {};
  if (!random.chance(0.3)) box.X.R = rotation_from_vector(random_vector(random, 3));
  box.half = {random.uniform(0.001, 0.2), random.uniform(0.001, 0.2), random.uniform(0.001, 0.2)};
  return box;
}

/// Farthest that a body reaches along n.
double support(const PlacedCapsule& c, const Vec3& n) {
  return std::max(dot(n, c.a), dot(n, c.b)) + c.radius * norm(n);
}
double support(const PlacedBox& box, const Vec3& n) {
  return dot(n, box.X.p) + box.half.x * std::abs(dot(n, box.X.R.x)) +
         box.half.y * std::abs(dot(n, box.X.R.y)) + box.half.z * std::abs(dot(n, box.X.R.z));
}

/// A point of a body, all of them for all numbers in [-1, 1].
Vec3 point_of(const PlacedCapsule& c, double u, double v, double w) {
  const Vec3 axis = 0.5 * (1 + u) * (c.b - c.a) + c.a;
  // The surface of a ball about the axis; what is inside the capsule does not matter to distances.
  const double sine = std::sqrt(1 - w * w);
  return axis + c.radius * Vec3{sine * std::cos(kPi * v), sine * std::sin(kPi * v), w};
}
Vec3 point_of(const PlacedBox& box, double u, double v, double w) {
  return box.X * Vec3{u * box.half.x, v * box.half.y, w * box.half.z};
}

/// The largest separation over all directions: what the distance is, whichever sign it has. Found
/// by trying: many directions, and from the best of them always smaller random steps.
template <class A, class B>
double separation_by_trying(const A& first, const B& second, Random& random) {
  const auto along = [&](const Vec3& n) { return -support(second, -n) - support(first, n); };
  std::vector<std::pair<double, Vec3>> tried;
  for (int i = 0; i < 400; ++i) {
    const Vec3 n = random_direction(random);
    tried.emplace_back(along(n), n);
  }
  std::ranges::sort(tried, std::greater<>(), [](const auto& one) { return one.first; });
  // Where two corners compete the way uphill is a ridge: steps shrink only where none of many
  // helps.
  const auto climb = [&](std::pair<double, Vec3>& top, double shrink, double step_min) {
    int rounds = 1000;
    for (double step = 0.2; step > step_min && rounds > 0; --rounds) {
      const double before = top.first;
      for (int k = 0; k < 16; ++k) {
        const Vec3 n = normalized(top.second + step * random_direction(random));
        if (along(n) > top.first) top = {along(n), n};
      }
      if (top.first <= before) step *= shrink;
    }
  };
  for (std::size_t i = 0; i < 12; ++i) climb(tried[i], 0.6, 1e-4);
  auto best = *std::ranges::max_element(tried, {}, [](const auto& one) { return one.first; });
  climb(best, 0.9, 1e-8);
  return best.first;
}

/// The least distance of some thousand points each; never less than the distance.
template <class A, class B>
double distance_of_points(const A& first, const B& second, Random& random) {
  double least = kInfinity;
  std::array<double, 6> at{}, best{};
  const auto apart = [&](const std::array<double, 6>& x) {
    return norm(point_of(first, x[0], x[1], x[2]) - point_of(second, x[3], x[4], x[5]));
  };
  for (int i = 0; i < 400; ++i) {
    for (double& x : at) x = random.uniform(-1, 1);
    if (apart(at) < least) least = apart(at), best = at;
  }
  for (double step = 0.5; step > 1e-6; step *= 0.8) {
    for (int k = 0; k < 40; ++k) {
      at = best;
      for (double& x : at) x = std::clamp(x + random.uniform(-step, step), -1.0, 1.0);
      if (apart(at) < least) least = apart(at), best = at;
    }
  }
  return least;
}

template <class A, class B>
void expect_what_trying_finds(const A& first, const B& second, Random& random) {
  const double found = distance(first, second);
  // Every direction proves that it is at least so much; the best one nearly reaches it, but in deep
  // overlaps there are many hills to climb and not every search finds the highest.
  double bound = separation_by_trying(first, second, random);
  for (int again = 0; again < 10 && found > bound + 1e-4; ++again) {
    bound = std::max(bound, separation_by_trying(first, second, random));
  }
  ASSERT_GE(found, bound - 1e-9);
  ASSERT_LE(found, bound + 1e-4);
  if (found > 1e-3) {
    ASSERT_LE(found, distance_of_points(first, second, random) + 1e-9);
  }
}

TEST(ShapeDistance, of_capsules_is_what_trying_finds) {
  test::for_random_cases(600, [](Random& random) {
    const PlacedCapsule first = random_capsule(random);
    expect_what_trying_finds(first, random_capsule(random), random);
  });
}

TEST(ShapeDistance, of_capsule_and_box_is_what_trying_finds) {
  test::for_random_cases(600, [](Random& random) {
    const PlacedCapsule first = random_capsule(random);
    expect_what_trying_finds(first, random_box(random), random);
  });
}

TEST(ShapeDistance, of_boxes_is_what_trying_finds) {
  test::for_random_cases(600, [](Random& random) {
    const PlacedBox first = random_box(random);
    expect_what_trying_finds(first, random_box(random), random);
  });
}

/// Shifted by its own distance along the direction that it was found in, a pair only touches: so
/// deep overlaps are measured right, too.
TEST(ShapeDistance, is_the_shift_that_makes_boxes_touch) {
  const PlacedBox low{{{}, {0, 0, 0}}, {0.1, 0.2, 0.05}};
  for (const double z : {0.3, 0.15, 0.1, 0.05, 0.01}) {
    const PlacedBox high{{rotation_z(0.4), {0.02, 0.03, z}}, {0.03, 0.02, 0.07}};
    EXPECT_NEAR(distance(low, high), z - 0.12, 1e-15) << z;
    EXPECT_NEAR(distance(high, low), z - 0.12, 1e-15) << z;
  }
  // A bar through a plate: no corner of one is inside the other, no edge of the plate in the bar.
  const PlacedBox plate{{}, {0.2, 0.2, 0.002}};
  const PlacedBox bar{{rotation_z(0.7), {0.05, 0.05, 0.01}}, {0.01, 0.01, 0.3}};
  EXPECT_LT(distance(plate, bar), -0.1);
}

TEST(ShapeDistance, of_lines_without_length_or_side_by_side_is_exact) {
  const PlacedCapsule ball{{0, 0, 0}, {0, 0, 0}, 0.01};
  const PlacedCapsule other{{0, 0.05, 0}, {0, 0.05, 0}, 0.02};
  EXPECT_DOUBLE_EQ(distance(ball, other), 0.02);
  const PlacedCapsule line{{-1, 0, 0}, {1, 0, 0}, 0.01};
  const PlacedCapsule beside{{3, 0.1, 0}, {0.5, 0.1, 0}, 0.01};
  const PlacedCapsule behind{{1.3, 0, 0.4}, {5, 0, 0.4}, 0.01};
  EXPECT_NEAR(distance(line, beside), 0.08, 1e-15);
  EXPECT_NEAR(distance(line, behind), 0.48, 1e-15);
  EXPECT_NEAR(distance(line, ball), -0.02, 1e-15);
  EXPECT_NEAR(distance(line, line), -0.02, 1e-15);
  const PlacedCapsule across{{0.2, -1, 0.01}, {0.2, 1, 0.01}, 0.01};
  EXPECT_NEAR(distance(line, across), -0.01, 1e-15);
  const PlacedBox box{{}, {0.1, 0.1, 0.1}};
  EXPECT_NEAR(distance(line, box), -0.11, 1e-15);
  EXPECT_NEAR(distance(ball, box), -0.11, 1e-15);
  EXPECT_NEAR(distance(beside, box), std::hypot(0.4, 0.0) - 0.01, 1e-15);
  const PlacedCapsule grazing{{-1, 0, 0.11}, {1, 0, 0.11}, 0.01};
  EXPECT_NEAR(distance(grazing, box), 0, 1e-15);
}

TEST(ShapeDistance, of_nearly_parallel_lines_that_nearly_touch_keeps_its_digits) {
  test::for_random_cases(100'000, [](Random& random) {
    const double tilt = std::pow(10, random.uniform(-14, -1));
    const double gap = random.chance(0.2) ? 0 : std::pow(10, random.uniform(-12, -2));
    const double crossing = random.uniform(-0.2, 0.2);
    const Rotation R = rotation_from_vector(random_vector(random, 3));
    const Vec3 shift = random_vector(random, 1);
    const auto placed = [&](const Vec3& p) { return R * p + shift; };
    // Two lines that cross at `crossing`, `gap` above each other.
    const PlacedCapsule first{placed({-0.3, 0, 0}), placed({0.3, 0, 0}), 0.01};
    const auto on_second = [&](double x) { return placed({x, tilt * (x - crossing), gap}); };
    const PlacedCapsule second{on_second(-0.25), on_second(0.4), 0.01};
    ASSERT_NEAR(distance(first, second), gap - 0.02, 1e-11) << tilt << " " << gap;
    ASSERT_NEAR(distance(second, first), gap - 0.02, 1e-11);
  });
}

template <class A, class B>
void expect_symmetric_and_continuous(const A& first, const B& second, Random& random) {
  const double before = distance(first, second);
  const double size = std::pow(10, random.uniform(-9, -1));
  const Vec3 shift = size * random_direction(random);
  B moved = second;
  if constexpr (requires { moved.a; }) {
    moved.a = moved.a + shift;
    moved.b = moved.b + shift;
  } else {
    moved.X.p = moved.X.p + shift;
  }
  ASSERT_LE(std::abs(distance(first, moved) - before), size + 1e-10);
}

TEST(ShapeDistance, is_symmetric_and_changes_no_more_than_a_body_is_shifted) {
  test::for_random_cases(200'000, [](Random& random) {
    const PlacedCapsule c = random_capsule(random), d = random_capsule(random);
    const PlacedBox a = random_box(random), b = random_box(random);
    expect_symmetric_and_continuous(c, d, random);
    expect_symmetric_and_continuous(c, a, random);
    expect_symmetric_and_continuous(a, b, random);
    ASSERT_NEAR(distance(c, d), distance(d, c), 1e-10);
    ASSERT_NEAR(distance(a, b), distance(b, a), 1e-12);
  });
}

TEST(ShapeDistance, above_a_table_is_that_of_the_lowest_point) {
  test::for_random_cases(2000, [](Random& random) {
    const PlacedCapsule c = random_capsule(random);
    const PlacedBox box = random_box(random);
    const double height = random.uniform(-0.2, 0.2);
    ASSERT_NEAR(distance_above(c, height), -support(c, {0, 0, -1}) - height, 1e-15);
    double lowest = kInfinity;
    for (const double x : {-1.0, 1.0}) {
      for (const double y : {-1.0, 1.0}) {
        for (const double z : {-1.0, 1.0}) lowest = std::min(lowest, point_of(box, x, y, z).z);
      }
    }
    ASSERT_NEAR(distance_above(box, height), lowest - height, 1e-15);
  });
}

}  // namespace
}  // namespace sinew::planning
