#include "sinew/calibration/touch_points.h"

#include <gtest/gtest.h>

#include "sinew/calibration/scene_test_data.h"
#include "sinew/core/units.h"

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
  // From three points on, where the touches' own error is all but unknown.
  constexpr int kCases = 400;
  for (const std::size_t count : {3U, 4U, 6U}) {
    int inside = 0;
    test::for_random_cases(kCases, [&](test::Random& random) {
      const PoseBW X_BW = random_table(random);
      const std::vector<Vec3> marks{{-0.085, 0.12, 0}, {0.085, -0.1, 0}, {-0.085, -0.1, 0},
                                    {0.085, 0.12, 0},  {0, 0.01, 0},     {0.07, 0.08, 0}};
      const auto table = table_frame(
          touched(X_BW, {marks.begin(), marks.begin() + static_cast<std::ptrdiff_t>(count)}, 0.5e-3,
                  random));
      ASSERT_TRUE(table);
      const Vec3 p_W{0.105, 0.1485, 0};
      inside += norm(table->X_BW * p_W - X_BW * p_W) <= error_95(*table, p_W) ? 1 : 0;
    });
    EXPECT_GE(inside, 0.92 * kCases) << count;
    EXPECT_LE(inside, 0.985 * kCases) << count << ": a bound that is far too wide says nothing";
  }
}

TEST(TableFrame, of_a_table_that_is_nearly_level_three_touches_tell_more) {
  constexpr int kCases = 400;
  int inside = 0, nearer = 0;
  double plain = 0, level = 0;
  const Vec3 up{0, 0, 1};
  test::for_random_cases(kCases, [&](test::Random& random) {
    const double turn = random.uniform(-3, 3);
    const Rotation tilt = rotation_x(0.0175 * normal(random)) * rotation_y(0.0175 * normal(random));
    const PoseBW X_BW{tilt * rotation_z(turn), random_vector(random, 0.3)};
    const std::vector<Vec3> marks{{-0.085, 0.12, 0}, {0.085, -0.1, 0}, {-0.085, -0.1, 0}};
    const auto points = touched(X_BW, marks, 2e-3, random);
    const auto table = table_frame(points);
    ASSERT_TRUE(table);
    const TableFrame better = levelled(*table, points, up);
    const Vec3 p_W{0.105, 0.1485, 0};
    const double off = norm(better.X_BW * p_W - X_BW * p_W);
    inside += off <= error_95(better, p_W) ? 1 : 0;
    nearer += off < norm(table->X_BW * p_W - X_BW * p_W) ? 1 : 0;
    plain += error_95(*table, p_W);
    level += error_95(better, p_W);
  });
  EXPECT_GE(inside, 0.92 * kCases);
  EXPECT_LE(inside, 0.985 * kCases);
  EXPECT_GT(nearer, 0.55 * kCases);
  EXPECT_LT(level, 0.9 * plain);
}

TEST(TableFrame, of_a_table_that_is_not_quite_level_the_error_still_holds) {
  constexpr int kCases = 300;
  for (const double tilt : {from_deg(2), from_deg(4), from_deg(8)}) {
    for (const std::size_t count : {3U, 5U}) {
      int inside = 0;
      test::for_random_cases(kCases, [&](test::Random& random) {
        const PoseBW X_BW{rotation_x(tilt) * rotation_z(random.uniform(-3, 3)), {0.2, 0, 0}};
        std::vector<Vec3> marks{
            {-0.085, 0.12, 0}, {0.085, -0.1, 0}, {-0.085, -0.1, 0}, {0.085, 0.12, 0}, {0, 0, 0}};
        marks.resize(count);
        const auto points = touched(X_BW, marks, 2e-3, random);
        const auto table = table_frame(points);
        ASSERT_TRUE(table);
        const TableFrame level = levelled(*table, points, {0, 0, 1});
        const Vec3 p_W{0.105, 0.1485, 0};
        inside += norm(level.X_BW * p_W - X_BW * p_W) <= error_95(level, p_W) ? 1 : 0;
      });
      EXPECT_GE(inside, 0.88 * kCases) << to_deg(tilt) << " deg, " << count;
    }
  }
}

TEST(TableFrame, a_table_that_is_tilted_stays_so) {
  test::for_random_cases(100, [](test::Random& random) {
    const PoseBW X_BW{rotation_x(0.2) * rotation_z(random.uniform(-3, 3)), {0.2, 0, 0.05}};
    const std::vector<Vec3> marks{
        {-0.085, 0.12, 0}, {0.085, -0.1, 0}, {-0.085, -0.1, 0}, {0.085, 0.12, 0}, {0, 0, 0}};
    const auto points = touched(X_BW, marks, 0.5e-3, random);
    const auto table = table_frame(points);
    ASSERT_TRUE(table);
    EXPECT_EQ(levelled(*table, points, {0, 0, 1}).X_BW.p.x, table->X_BW.p.x);
    EXPECT_EQ(levelled(*table, points, {0, 0, 1}).freedom, table->freedom);
  });
}

TEST(TableFrame, one_more_touch_improves_the_error_as_predicted) {
  test::Random random(4);
  const PoseBW X_BW = random_table(random);
  std::vector<Vec3> marks{{-0.085, 0.12, 0}, {0.085, 0.12, 0}, {-0.085, 0, 0}, {0.085, 0, 0}};
  const auto before = table_frame(touched(X_BW, marks, 0, random), 0.5e-3);
  ASSERT_TRUE(before);
  EXPECT_EQ(before->sigma, 0.5e-3);
  const Vec3 corner{0.105, -0.1485, 0};
  const Vec3 added{0.085, -0.1, 0};
  marks.push_back(added);
  const auto after = table_frame(touched(X_BW, marks, 0, random), 0.5e-3);
  ASSERT_TRUE(after);
  EXPECT_NEAR(error_95(with_touch(*before, added), corner), error_95(*after, corner), 1e-9);
  EXPECT_LT(error_95(*after, corner), 0.7 * error_95(*before, corner));
}

TEST(TableFrame, a_wrong_touch_is_told_from_noise) {
  int found = 0;
  int false_alarms = 0;
  constexpr int kCases = 200;
  test::for_random_cases(kCases, [&](test::Random& random) {
    const PoseBW X_BW = random_table(random);
    auto points = touched(X_BW, grid(3, 2, 0.12), 0.5e-3, random);
    false_alarms += wrong_touch(points) ? 1 : 0;
    const auto wrong = static_cast<std::size_t>(random.integer(0, 5));
    points[wrong].p_B.x += 0.012;
    const auto told = wrong_touch(points);
    const bool is_found = told && told->point == wrong;
    found += is_found ? 1 : 0;
    EXPECT_NEAR(is_found ? told->off_B.x : 0.012, 0.012, 0.004);
    EXPECT_LT(is_found ? told->rms_others : 0, 2e-3);
  });
  EXPECT_GE(found, 0.95 * kCases);
  EXPECT_LE(false_alarms, 0.05 * kCases);
  test::Random random(1);
  EXPECT_FALSE(wrong_touch(touched({}, {{0, 0, 0}, {0.1, 0, 0}, {0, 0.1, 0}}, 0.01, random)));
}

TEST(TableFrame, exchanged_points_are_named) {
  test::for_random_cases(50, [](test::Random& random) {
    const PoseBW X_BW = random_table(random);
    auto points = touched(X_BW, grid(3, 2, 0.12), 0.5e-3, random);
    EXPECT_FALSE(exchanged(points));
    std::swap(points[1].p_W, points[5].p_W);
    const auto pair = exchanged(points);
    ASSERT_TRUE(pair);
    EXPECT_EQ(*pair, std::pair(std::size_t{1}, std::size_t{5}));
  });
}

TEST(TableFrame, a_print_that_was_scaled_shows_in_the_distances) {
  test::for_random_cases(100, [](test::Random& random) {
    const PoseBW X_BW = random_table(random);
    auto points = touched(X_BW, grid(3, 2, 0.12), 0.2e-3, random);
    for (TouchedPoint& point : points) point.p_W = (1 / 0.96) * point.p_W;
    const auto table = table_frame(points);
    ASSERT_TRUE(table);
    EXPECT_NEAR(table->scale, 0.96, 5 * table->scale_sigma + 1e-3);
    EXPECT_GT(std::abs(table->scale - 1), 4 * table->scale_sigma);
  });
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
