#include "sinew/calibration/touch_points.h"

#include <gtest/gtest.h>

#include "sinew/calibration/scene_test_data.h"

namespace sinew::calibration {
namespace {

using PoseBW = Pose<frame::Base, frame::World>;

/// Points around the middle of a table, touched with errors of `sigma` m.
std::vector<TouchedPoint> touched(const PoseBW& X_BW, const std::vector<Vec3>& points_W,
                                  double sigma, test::Random& random) {
  std::vector<TouchedPoint> out;
  for (const Vec3& p_W : points_W) {
    const Vec3 error{normal(random), normal(random), normal(random)};
    out.push_back({X_BW * p_W + sigma * error, p_W});
  }
  return out;
}

PoseBW random_table(test::Random& random) {
  return {rotation_from_vector(random_vector(random, 1.5)), random_vector(random, 0.3)};
}

TEST(TableFrame, exact_points_of_a_plane_give_the_rotation_and_no_reflection) {
  test::for_random_cases(300, [](test::Random& random) {
    const PoseBW X_BW = random_table(random);
    auto points_W = grid(2, 2, 0.2);
    points_W.resize(static_cast<std::size_t>(random.integer(3, 4)));
    const auto table = table_frame(touched(X_BW, points_W, 0, random));
    ASSERT_TRUE(table);
    EXPECT_LT(step_between(X_BW, table->X_BW).norm(), 1e-12);
    EXPECT_LT(table->rms, 1e-12);
    EXPECT_EQ(table->residuals.size(), points_W.size());
  });
}

TEST(TableFrame, worst_point_is_named) {
  test::for_random_cases(200, [](test::Random& random) {
    const PoseBW X_BW = random_table(random);
    auto points = touched(X_BW, grid(3, 2, 0.12), 0.2e-3, random);
    const auto wrong = static_cast<std::size_t>(random.integer(0, 5));
    points[wrong].p_B.z += 0.01;
    const auto table = table_frame(points);
    ASSERT_TRUE(table);
    EXPECT_EQ(table->worst, wrong);
  });
}

TEST(TableFrame, error_95_holds_at_new_points) {
  int inside = 0;
  constexpr int kCases = 400;
  test::for_random_cases(kCases, [&](test::Random& random) {
    const PoseBW X_BW = random_table(random);
    const auto table = table_frame(touched(X_BW, grid(3, 2, 0.12), 0.5e-3, random));
    ASSERT_TRUE(table);
    const Vec3 p_W{random.uniform(-0.12, 0.12), random.uniform(-0.06, 0.06), 0};
    const Vec3 p_B = X_BW * p_W + 0.5e-3 * Vec3{normal(random), normal(random), normal(random)};
    inside += norm(table->X_BW * p_W - p_B) <= table->error_95 ? 1 : 0;
  });
  EXPECT_GE(inside, 0.9 * kCases);
}

TEST(TableFrame, points_nearly_on_a_line_are_refused_with_their_extent) {
  test::Random random(1);
  const std::vector<Vec3> points_W{{0, 0, 0}, {0.1, 0.004, 0}, {0.2, 0, 0}};
  const auto table = table_frame(touched({}, points_W, 0, random));
  ASSERT_FALSE(table);
  EXPECT_EQ(sentence(table.error()),
            "The points are nearly on one line: 200 mm long, 4 mm wide, at least 20 mm wide "
            "needed. Add a point away from the line.");
  const auto two = table_frame(touched({}, {points_W.begin(), points_W.begin() + 2}, 0, random));
  ASSERT_FALSE(two);
  EXPECT_EQ(two.error().fault, CalibrationFault::kTooFewPoints);
}

}  // namespace
}  // namespace sinew::calibration
