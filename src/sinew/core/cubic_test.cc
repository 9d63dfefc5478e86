#include "sinew/core/cubic.h"

#include <gtest/gtest.h>

#include "support/property.h"

namespace sinew {
namespace {

using test::Random;

Cubic any_cubic(Random& random) {
  const auto number = [&] { return random.chance(0.1) ? 0.0 : random.uniform(-2, 2); };
  return Cubic({number(), number()}, {number(), number()}, random.uniform(0.01, 3));
}

TEST(Cubic, has_both_positions_and_both_speeds) {
  const Cubic way({1, -0.5}, {2, 0.25}, 0.8);
  EXPECT_EQ(way.at(0).q, 1);
  EXPECT_EQ(way.at(0).qd, -0.5);
  EXPECT_NEAR(way.at(0.8 - 1e-9).q, 2, 1e-8);
  EXPECT_NEAR(way.at(0.8 - 1e-9).qd, 0.25, 1e-7);
  EXPECT_EQ(way.at(0.8).q, 2);
  EXPECT_EQ(way.at(5).qd, 0.25);
}

TEST(Cubic, its_speed_is_the_slope_of_its_position) {
  test::for_random_cases(2000, [](Random& random) {
    const Cubic way = any_cubic(random);
    const double t = random.uniform(0.001, way.duration() - 0.001);
    constexpr double kStep = 1e-6;
    const double slope = (way.at(t + kStep).q - way.at(t - kStep).q) / (2 * kStep);
    EXPECT_NEAR(way.at(t).qd, slope, 1e-5 * (1 + std::abs(slope)));
  });
}

TEST(Cubic, peak_and_turns_are_the_most_that_it_comes_to) {
  test::for_random_cases(2000, [](Random& random) {
    const Cubic way = any_cubic(random);
    double lowest = std::min(way.at(0).q, way.end().q);
    double highest = std::max(way.at(0).q, way.end().q);
    way.for_turns([&](double q) { lowest = std::min(lowest, q), highest = std::max(highest, q); });
    double fastest = 0;
    for (int i = 0; i <= 200; ++i) {
      const Cubic::State there = way.at(way.duration() * i / 200);
      EXPECT_GE(there.q, lowest - 1e-12);
      EXPECT_LE(there.q, highest + 1e-12);
      fastest = std::max(fastest, std::abs(there.qd));
    }
    EXPECT_GE(way.peak_speed(), fastest - 1e-12);
    EXPECT_LE(way.peak_speed(), fastest * 1.01 + 1e-3);
  });
}

}  // namespace
}  // namespace sinew
