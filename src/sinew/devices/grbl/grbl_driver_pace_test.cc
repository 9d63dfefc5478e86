#include "sinew/devices/grbl/grbl_driver_pace.h"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "sinew/core/units.h"
#include "sinew/devices/grbl/grbl_device_planner.h"
#include "support/property.h"

namespace sinew {
namespace {

using grbl::AxisRates;
using grbl::Planner;
using grbl::Values;

/// A motion along a cosine in pieces of 50 ms, each as its line says it, through a board's planner.
/// @return  s that it takes
double time_of(double way, double seconds, double acceleration, bool paced) {
  const std::vector<double> limits(2, acceleration);
  Planner planner(std::vector<AxisRates>(2, {1e4, acceleration}), 0.01);
  GrblPace pace(limits);
  const int pieces = static_cast<int>(std::lround(seconds / 0.05));
  const auto at = [&](int k) {
    const double q = way * (1 - std::cos(kPi * k / pieces)) / 2;
    Values all;
    all.push_back(q), all.push_back(-q / 2);
    return all;
  };
  const auto speed = [&](int k) {
    return way * kPi / 2 * std::sin(kPi * k / pieces) / seconds * std::hypot(1, 0.5);
  };
  double time = 0;
  int next = 1;
  while (next <= pieces || !planner.empty()) {
    while (next <= pieces && planner.size() < 8) {
      Values piece;
      for (std::size_t i = 0; i < 2; ++i) piece.push_back(at(next)[i] - at(next - 1)[i]);
      const double peak = std::max(speed(next - 1), speed(next));
      const double said = pace.line_duration(piece, peak, 0.05, next == pieces);
      planner.push(at(next), paced ? said : 0.05);
      ++next;
    }
    planner.advance(1e-4);
    time += 1e-4;
  }
  return time;
}

TEST(GrblPace, a_motion_takes_its_time) {
  for (const double acceleration : {150.0, 400.0, 3000.0}) {
    EXPECT_NEAR(time_of(20, 1, acceleration, true), 1, 0.02) << acceleration;
    EXPECT_NEAR(time_of(60, 2, acceleration, true), 2, 0.02) << acceleration;
    EXPECT_NEAR(time_of(100, 5, acceleration, true), 5, 0.02) << acceleration;
  }
  // With mean speeds it comes later.
  EXPECT_GT(time_of(20, 1, 150, false), 1.06);
}

TEST(GrblPace, no_line_is_faster_than_the_highest_speed_of_its_piece_or_slower_than_its_mean) {
  test::for_random_cases(2000, [](test::Random& random) {
    const std::vector<double> limits{random.uniform(10, 1000), random.uniform(10, 1000)};
    GrblPace pace(limits);
    for (int k = 0; k < 20; ++k) {
      Values way;
      way.push_back(random.uniform(-5, 5)), way.push_back(random.uniform(-5, 5));
      const double length = std::hypot(way[0], way[1]);
      const double peak = random.uniform(0, 200);
      const double said = pace.line_duration(way, peak, 0.05, false);
      ASSERT_LE(said, 0.05 * (1 + 1e-9));
      ASSERT_GE(said, 0.025 * (1 - 1e-9));
      ASSERT_LE(length / said, std::max(peak, length / 0.05) * (1 + 1e-9));
    }
  });
}

}  // namespace
}  // namespace sinew
