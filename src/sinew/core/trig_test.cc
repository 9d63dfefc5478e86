#include "sinew/core/trig.h"

#include <gtest/gtest.h>

#include <cmath>

#include "support/property.h"

namespace sinew {
namespace {

TEST(Trig, sine_and_cosine_agree_with_the_c_library) {
  double worst = 0;
  test::for_random_cases(1'000'000, [&](test::Random& random) {
    const double range = random.chance(0.5) ? 2 * kPi : kSinCosRange;
    const double angle = random.uniform(-range, range);
    const SinCos result = sin_cos(angle);
    worst = std::max(
        {worst, std::abs(result.sin - std::sin(angle)), std::abs(result.cos - std::cos(angle))});
    EXPECT_LE(worst, 2.3e-16) << angle;
  });
  std::cout << "  worst error " << worst << "\n";
}

TEST(Trig, arc_tangent_agrees_with_the_c_library) {
  double worst = 0;
  test::for_random_cases(1'000'000, [&](test::Random& random) {
    const double scale = std::exp2(random.uniform(-60, 60));
    const double y = random.uniform(-1, 1) * scale;
    const double x = random.uniform(-1, 1) * (random.chance(0.9) ? scale : 1.0);
    worst = std::max(worst, std::abs(arc_tangent(y, x) - std::atan2(y, x)));
    EXPECT_LE(worst, 5e-16) << y << " " << x;
  });
  std::cout << "  worst error " << worst << "\n";
}

TEST(Trig, corners_are_exact) {
  EXPECT_EQ(sin_cos(0).sin, 0);
  EXPECT_EQ(sin_cos(0).cos, 1);
  EXPECT_EQ(arc_tangent(0, 0), 0);
  EXPECT_EQ(arc_tangent(0, 1), 0);
  EXPECT_EQ(arc_tangent(1, 0), kPi / 2);
  EXPECT_EQ(arc_tangent(-1, 0), -kPi / 2);
  EXPECT_EQ(arc_tangent(0, -1), kPi);
  EXPECT_DOUBLE_EQ(arc_tangent(1, 1), kPi / 4);
  EXPECT_DOUBLE_EQ(arc_tangent(-1, -1), -3 * kPi / 4);
}

TEST(Trig, not_a_number_stays_one) {
  EXPECT_TRUE(std::isnan(sin_cos(std::nan("")).sin));
  EXPECT_TRUE(std::isnan(arc_tangent(std::nan(""), 1)));
}

TEST(Trig, wrap_comes_within_half_a_turn) {
  EXPECT_NEAR(wrap_near(from_deg(350), 0), from_deg(-10), 1e-15);
  EXPECT_NEAR(wrap_near(from_deg(-10), from_deg(300)), from_deg(350), 1e-15);
}

}  // namespace
}  // namespace sinew
