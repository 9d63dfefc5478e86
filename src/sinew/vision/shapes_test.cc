#include "sinew/vision/shapes.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "sinew/core/units.h"
#include "support/property.h"

namespace sinew::vision {
namespace {

Quad square(Pixel middle, double edge, double turn) {
  Quad quad;
  for (std::size_t i = 0; i < 4; ++i) {
    const double angle = turn + from_deg(45 + 90.0 * static_cast<double>(i));
    quad[i] = middle + (edge / std::sqrt(2.0)) * Pixel{std::cos(angle), std::sin(angle)};
  }
  return quad;
}

TEST(Shapes, hull_of_random_points_holds_all_of_them_and_has_no_corner_inside) {
  test::for_random_cases(200, [](test::Random& random) {
    std::vector<Pixel> points;
    for (int i = 0; i < 40; ++i) points.push_back({random.uniform(0, 9), random.uniform(0, 9)});
    std::ranges::sort(points, [](Pixel a, Pixel b) { return a.y != b.y ? a.y < b.y : a.x < b.x; });
    const auto hull = convex_hull(points);
    ASSERT_GE(hull.size(), 3U);
    for (const Pixel point : points) {
      for (std::size_t i = 0; i < hull.size(); ++i) {
        EXPECT_GE(cross(hull[(i + 1) % hull.size()] - hull[i], point - hull[i]), -1e-9);
      }
    }
    for (std::size_t i = 0; i < hull.size(); ++i) {
      const Pixel next = hull[(i + 1) % hull.size()];
      EXPECT_GT(cross(next - hull[i], hull[(i + 2) % hull.size()] - next), 0);
    }
  });
}

TEST(Shapes, four_corners_of_a_square_with_cut_corners_are_nearly_its_own) {
  const Quad whole = square({50, 40}, 30, 0.3);
  std::vector<Pixel> cut;
  for (std::size_t i = 0; i < 4; ++i) {
    const Pixel side = whole[(i + 1) % 4] - whole[i];
    cut.push_back(whole[i] + 0.04 * side);
    cut.push_back(whole[i] + 0.96 * side);
  }
  const auto quad = four_corners(cut);
  ASSERT_TRUE(quad);
  EXPECT_GT(area_of(*quad), 0.9 * area_of(whole));
  EXPECT_LT(side_ratio(*quad), 1.1);
  EXPECT_FALSE(four_corners({{0, 0}, {1, 0}, {0, 1}}));
}

TEST(Shapes, yaw_of_a_square_is_the_same_after_each_quarter_turn) {
  test::for_random_cases(200, [](test::Random& random) {
    const double turn = random.uniform(0, 2 * kPi);
    const double said = yaw(square({0, 0}, random.uniform(5, 50), turn));
    const double off = std::remainder(said - turn, kPi / 2);
    EXPECT_NEAR(off, 0, 1e-9);
    EXPECT_GE(said, 0);
    EXPECT_LE(said, kPi / 2 + 1e-12);
  });
}

TEST(Shapes, what_two_squares_share_is_counted_by_points) {
  test::for_random_cases(60, [](test::Random& random) {
    const Quad one = square({20, 20}, 20, random.uniform(0, kPi));
    const Quad other =
        square({random.uniform(8, 32), random.uniform(8, 32)}, 14, random.uniform(0, kPi));
    double counted = 0;
    constexpr double kStep = 0.1;
    for (double y = 0; y < 45; y += kStep) {
      for (double x = 0; x < 45; x += kStep) {
        if (is_inside(one, {x, y}) && is_inside(other, {x, y})) counted += kStep * kStep;
      }
    }
    EXPECT_NEAR(common_area(one, other), counted, 2);
  });
}

TEST(Shapes, skew_and_side_ratio_tell_what_is_no_square) {
  EXPECT_NEAR(skew(square({0, 0}, 10, 1)), 0, 1e-9);
  EXPECT_NEAR(skew({{{0, 0}, {10, 0}, {15, 5 * std::sqrt(3.0)}, {5, 5 * std::sqrt(3.0)}}}),
              from_deg(30), 1e-9);
  EXPECT_NEAR(side_ratio({{{0, 0}, {20, 0}, {20, 10}, {0, 10}}}), 2, 1e-9);
}

}  // namespace
}  // namespace sinew::vision
