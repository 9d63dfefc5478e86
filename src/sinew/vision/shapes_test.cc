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

}  // namespace
}  // namespace sinew::vision
