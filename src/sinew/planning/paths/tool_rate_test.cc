#include "sinew/planning/paths/tool_rate.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>

#include "support/property.h"

namespace sinew::planning {
namespace {

using test::for_random_cases;
using test::Random;

constexpr std::size_t kParts = 4;

/// p(s) = p1 s + p2 s^2 + p3 s^3.
struct Cubic {
  std::array<Vec3, 3> p;

  Vec3 at(double s) const { return s * (p[0] + s * (p[1] + s * p[2])); }
  Vec3 rate(double s) const { return p[0] + s * (2 * p[1] + 3 * s * p[2]); }
  Vec3 bend(double s) const { return 2 * p[1] + 6 * s * p[2]; }
};

ToolRate bound_of(const Cubic& curve, double length) {
  std::array<Vec3, kParts + 1> p;
  for (std::size_t i = 0; i <= kParts; ++i) {
    p[i] = curve.at(length * static_cast<double>(i) / kParts);
  }
  return tool_rate(p, length / kParts);
}

TEST(ToolRate, bounds_the_speed_of_a_tool_that_is_quickest_at_an_end) {
  // Slows down ever less from where it begins: half a change alone was 0.4 % short of it.
  const Cubic curve{{Vec3{1, 0, 0}, Vec3{-16, 0, 0}, Vec3{500, 0, 0}}};
  EXPECT_GE(bound_of(curve, 8e-3).speed, 1);
  EXPECT_LE(bound_of(curve, 8e-3).speed, 1.02);
}

TEST(ToolRate, bounds_speed_and_bends_of_random_cubics) {
  for_random_cases(20'000, [](Random& random) {
    const auto vector = [&](double size) {
      return Vec3{random.uniform(-size, size), random.uniform(-size, size),
                  random.uniform(-size, size)};
    };
    // Up to where a tool turns round between two places: there is no speed to speak of there.
    const double length = 8e-3;
    const Cubic curve{{vector(1), vector(0.2 / length), vector(0.1 / (length * length))}};
    if (norm(curve.p[0]) < 0.5) return random.discard();
    const ToolRate bound = bound_of(curve, length);
    double speed = 0;
    double bend = 0;
    for (int k = 0; k <= 400; ++k) {
      speed = std::max(speed, norm(curve.rate(length * k / 400)));
      bend = std::max(bend, norm(curve.bend(length * k / 400)));
    }
    EXPECT_LE(speed, bound.speed * (1 + 1e-9));
    EXPECT_LE(bend, bound.curvature * (1 + 1e-9));
    // What a bound costs in time.
    EXPECT_LE(bound.speed, speed * 1.4);
  });
}

}  // namespace
}  // namespace sinew::planning
