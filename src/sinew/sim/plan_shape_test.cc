#include "sinew/sim/plan_shape.h"

#include <gtest/gtest.h>

#include <cmath>

#include "sinew/core/split_mix.h"
#include "sinew/core/units.h"

namespace sinew::sim {
namespace {

PlanShape any_square(SplitMix64& random, double reach) {
  return rectangle({random.uniform(-reach, reach), random.uniform(-reach, reach)},
                   random.uniform(-kPi, kPi), {random.uniform(0.1, 1), random.uniform(0.1, 1)});
}

PlanShape moved(PlanShape shape, PlanPoint step) {
  for (PlanPoint& p : shape) p = p + step;
  return shape;
}

TEST(PlanShape, the_step_out_is_enough_and_a_shorter_one_is_not) {
  SplitMix64 random(1);
  int overlapping = 0;
  for (int i = 0; i < 500; ++i) {
    const PlanShape a = any_square(random, 1);
    const PlanShape b = any_square(random, 1);
    const auto step = step_out(a, b);
    EXPECT_EQ(step.has_value(), area_of(common_part(a, b)) > 1e-12);
    if (!step) continue;
    ++overlapping;
    EXPECT_LT(area_of(common_part(a, moved(b, 1.000001 * *step))), 1e-9);
    EXPECT_GT(area_of(common_part(a, moved(b, 0.99 * *step))), 0);
    const double turn = random.uniform(-kPi, kPi);
    const PlanPoint toward{std::cos(turn), std::sin(turn)};
    const double way = slide_out(a, b, toward);
    EXPECT_GE(way, length(*step) - 1e-12) << "no direction is shorter";
    EXPECT_LT(area_of(common_part(a, moved(b, (way + 1e-9) * toward))), 1e-9);
    EXPECT_GT(area_of(common_part(a, moved(b, 0.99 * way * toward))), 0);
  }
  EXPECT_GT(overlapping, 100);
}

TEST(PlanShape, common_part_holds_the_points_that_both_hold) {
  SplitMix64 random(2);
  int inside = 0;
  for (int i = 0; i < 100; ++i) {
    const PlanShape a = any_square(random, 0.5);
    const PlanShape b = any_square(random, 0.5);
    const PlanShape both = common_part(a, b);
    for (int k = 0; k < 50; ++k) {
      const PlanPoint p{random.uniform(-1, 1), random.uniform(-1, 1)};
      const bool in_both = contains(a, p, 1e-9) && contains(b, p, 1e-9);
      if (in_both) {
        EXPECT_TRUE(contains(both, p));
        ++inside;
      } else {
        EXPECT_FALSE(contains(both, p, 1e-9));
      }
    }
  }
  EXPECT_GT(inside, 100);
}

TEST(PlanShape, hull_has_the_corners_and_nothing_of_what_lies_between) {
  const PlanShape hull =
      hull_of({{0, 0}, {1, 0}, {0.5, 0.5}, {1, 1}, {0, 1}, {0.5, 0}, {1, 0}, {0.2, 0.7}});
  EXPECT_EQ(hull, (PlanShape{{0, 0}, {1, 0}, {1, 1}, {0, 1}}));
  EXPECT_NEAR(area_of(hull), 1, 1e-15) << "counterclockwise";
  EXPECT_TRUE(hull_of({}).empty());
  EXPECT_EQ(hull_of({{1, 2}}).size(), 1U);
}

TEST(PlanShape, slab_of_a_tilted_block_is_its_part_between_two_heights) {
  // A plate on its edge, 45 deg: at height z its middle is at x = z.
  const Block plate{{rotation_y(kPi / 4), {0, 0, 0}}, {0.01, 0.2, 1}};
  const PlanShape slab = slab_of(plate, {0.30, 0.31});
  double low = 1, high = -1;
  for (const PlanPoint p : slab) {
    low = std::min(low, p.x);
    high = std::max(high, p.x);
    EXPECT_NEAR(std::abs(p.y), 0.2, 1e-12);
  }
  EXPECT_NEAR(low, 0.30 - 0.01 * std::sqrt(2.0), 1e-9);
  EXPECT_NEAR(high, 0.31 + 0.01 * std::sqrt(2.0), 1e-9);
  EXPECT_TRUE(slab_of(plate, {2, 3}).empty());
  EXPECT_NEAR(heights_of(plate).high, (1 + 0.01) / std::sqrt(2.0), 1e-12);
}

}  // namespace
}  // namespace sinew::sim
