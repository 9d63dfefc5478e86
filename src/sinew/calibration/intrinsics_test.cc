#include "sinew/calibration/intrinsics.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "sinew/calibration/scene_test_data.h"
#include "sinew/calibration/view_coverage.h"

namespace sinew::calibration {
namespace {

BoardView view_of(const vision::CameraModel& camera, const PoseCB& X_CB, double sigma,
                  test::Random& random) {
  return {camera.width, camera.height, seen_points(camera, X_CB, grid(9, 6, 0.028), sigma, random)};
}

/// Tilted to all sides and all over the picture, partly beyond its border.
std::vector<BoardView> good_views(const vision::CameraModel& camera, int count, double sigma,
                                  test::Random& random) {
  std::vector<BoardView> views;
  while (std::ssize(views) < count) {
    const double z = random.uniform(0.25, 0.5);
    const PoseCB X_CB =
        facing(random.uniform(-0.6, 0.6), random.uniform(-0.6, 0.6), random.uniform(-0.5, 0.5),
               {random.uniform(-0.45, 0.45) * z, random.uniform(-0.25, 0.25) * z, z});
    BoardView view = view_of(camera, X_CB, sigma, random);
    if (view.seen.pixels.size() >= 20) views.push_back(std::move(view));
  }
  return views;
}

TEST(Intrinsics, exact_pixels_give_the_camera) {
  test::for_random_cases(10, [](test::Random& random) {
    const auto views = good_views(webcam(), 10, 0, random);
    const auto found = intrinsics(views);
    ASSERT_TRUE(found) << sentence(found.error());
    const CameraVector off = parameters_of(found->camera) - parameters_of(webcam());
    EXPECT_LT(off.head<4>().norm(), 1e-6);
    EXPECT_LT(off.tail<5>().norm(), 1e-8);
    EXPECT_LT(found->rms, 1e-7);
    EXPECT_EQ(found->X_CB.size(), views.size());
    EXPECT_EQ(found->camera.width, 1280);
  });
}

TEST(Intrinsics, errors_are_as_large_as_their_sigma_says) {
  double sum = 0;
  double rms_sum = 0;
  constexpr int kCases = 20;
  test::for_random_cases(kCases, [&](test::Random& random) {
    const auto found = intrinsics(good_views(webcam(), 10, 0.3, random));
    ASSERT_TRUE(found) << sentence(found.error());
    const CameraVector off = parameters_of(found->camera) - parameters_of(webcam());
    for (Eigen::Index i = 0; i < 6; ++i) sum += std::pow(off[i] / found->sigma[i], 2) / 6;
    rms_sum += found->rms;
    EXPECT_NEAR(found->pixel_sigma, 0.3, 0.05);
    EXPECT_GT(found->error_95, found->rms);
  });
  EXPECT_GT(sum / kCases, 0.5);
  EXPECT_LT(sum / kCases, 1.8);
  EXPECT_NEAR(rms_sum / kCases, 0.3 * std::sqrt(2.0), 0.02);
}

TEST(Intrinsics, lens_coefficients_that_the_data_does_not_show_are_0) {
  vision::CameraModel straight = webcam();
  straight.lens = {};
  int held = 0;
  constexpr int kCases = 10;
  test::for_random_cases(kCases, [&](test::Random& random) {
    const auto found = intrinsics(good_views(straight, 8, 0.3, random));
    ASSERT_TRUE(found) << sentence(found.error());
    held += static_cast<int>(std::count(found->camera.lens.begin(), found->camera.lens.end(), 0.0));
    EXPECT_GT(found->sigma.minCoeff(), 0) << "of a coefficient that is held at 0 too";
  });
  EXPECT_GE(held, 5 * kCases - 4);
  test::Random random(2);
  vision::CameraModel wide = webcam();
  wide.fx = wide.fy = 700;
  wide.lens = {-0.3, 0.1, 0, 0, 0.03};
  const auto found = intrinsics(good_views(wide, 20, 0.1, random));
  ASSERT_TRUE(found) << sentence(found.error());
  EXPECT_NEAR(found->camera.lens[4], 0.03, 0.01) << "k3 is visible in a wide picture";
  EXPECT_EQ(found->camera.lens[2], 0);
}

TEST(Intrinsics, wrong_points_are_named_and_do_not_count) {
  test::for_random_cases(10, [](test::Random& random) {
    auto views = good_views(webcam(), 8, 0.2, random);
    std::vector<std::pair<std::size_t, std::size_t>> wrong;
    for (std::size_t v = 0; v < views.size(); v += 2) {
      for (const std::size_t i : {v, v + 7}) {
        vision::Pixel& p = views[v].seen.pixels[i];
        p.x += p.x > 640 ? -random.uniform(4, 60) : random.uniform(4, 60);
        wrong.emplace_back(v, i);
      }
    }
    const auto found = intrinsics(views);
    ASSERT_TRUE(found) << sentence(found.error());
    ASSERT_EQ(found->wrong_points.size(), wrong.size());
    for (std::size_t i = 0; i < wrong.size(); ++i) {
      EXPECT_EQ(std::pair(found->wrong_points[i].view, found->wrong_points[i].point), wrong[i]);
    }
    EXPECT_LT(std::abs(found->camera.fx - 1000), 5 * found->sigma[0]);
  });
}

TEST(Intrinsics, parallel_views_are_refused_and_a_tilt_is_asked_for) {
  test::for_random_cases(10, [](test::Random& random) {
    std::vector<BoardView> views;
    const double tilt = random.chance(0.5) ? 0.4 : 0;
    for (int i = 0; i < 6; ++i) {
      views.push_back(view_of(webcam(),
                              facing(tilt, 0, random.uniform(-1, 1),
                                     {random.uniform(-0.1, 0.1), 0, random.uniform(0.3, 0.6)}),
                              0.2, random));
    }
    const auto found = intrinsics(views);
    ASSERT_FALSE(found);
    EXPECT_EQ(found.error().fault, CalibrationFault::kViewsParallel) << sentence(found.error());
    EXPECT_NE(
        sentence(found.error()).find("Tilt the board by about 30 deg about its horizontal edge."),
        std::string::npos);
  });
}

TEST(Intrinsics, unusable_views_are_refused_by_number) {
  test::Random random(3);
  auto views = good_views(webcam(), 5, 0.2, random);
  const auto fault = [](std::span<const BoardView> tried) {
    const auto found = intrinsics(tried);
    return found ? std::pair(CalibrationFault{}, 99)
                 : std::pair(found.error().fault, found.error().index);
  };
  using enum CalibrationFault;
  EXPECT_EQ(fault(std::span(views).first(3)), std::pair(kTooFewViews, -1));
  auto size = views;
  size[2].width = 640;
  EXPECT_EQ(fault(size), std::pair(kPictureSize, 2));
  auto outside = views;
  outside[1].seen.pixels[0].y = 721;
  EXPECT_EQ(fault(outside), std::pair(kPictureSize, 1));
  auto line = views;
  for (Vec3& p : line[4].seen.points_B) p.y = 0;
  EXPECT_EQ(fault(line), std::pair(kPointsOnLine, 4));
  auto few = views;
  few[3].seen.points_B.resize(3);
  few[3].seen.pixels.resize(3);
  EXPECT_EQ(fault(few), std::pair(kTooFewPoints, 3));
}

TEST(Intrinsics, another_board_than_given_does_not_pass) {
  test::Random random(4);
  auto views = good_views(webcam(), 6, 0.2, random);
  for (BoardView& view : views) {
    for (Vec3& p : view.seen.points_B) p.x += 0.3 * std::abs(p.y);
  }
  const auto found = intrinsics(views);
  ASSERT_FALSE(found);
  EXPECT_EQ(found.error().fault, CalibrationFault::kNotConverged) << sentence(found.error());
}

TEST(Coverage, asks_for_what_is_missing_until_nothing_is) {
  test::Random random(5);
  std::vector<BoardView> views;
  EXPECT_NE(what_to_add(coverage(views)).value().find("Hold the board flat"), std::string::npos);
  const auto add = [&](double tilt_x, double tilt_y, const Vec3& p) {
    views.push_back(view_of(webcam(), facing(tilt_x, tilt_y, 0, p), 0.2, random));
    return what_to_add(coverage(views));
  };
  EXPECT_EQ(add(0, 0, {0, 0, 0.4}), "Tilt the board by about 30 deg about its horizontal edge.");
  EXPECT_EQ(add(0.6, 0, {0, 0, 0.4}), "Tilt the board by about 30 deg about its vertical edge.");
  EXPECT_EQ(add(0, 0.6, {0, 0, 0.4}), "Move the board to the upper left corner of the picture.");
  const Coverage middle = coverage(views);
  EXPECT_TRUE(middle.tilt_x_suffices() && middle.tilt_y_suffices());
  EXPECT_NEAR(middle.tilt_x, 0.6, 0.1);
  EXPECT_TRUE(middle.seen[1][1] && middle.seen[1][2]);
  EXPECT_FALSE(middle.seen[0][0] || middle.all_cells_seen());
  EXPECT_NE(add(0, 0, {-0.17, -0.07, 0.4}),
            "Move the board to the upper left corner of the picture.");
  add(0, 0, {0.16, -0.07, 0.4});
  add(0, 0, {0.16, 0.08, 0.4});
  EXPECT_EQ(add(0, 0, {-0.17, 0.08, 0.4}), "Move the board to twice its distance, or half of it.");
  EXPECT_EQ(add(0.3, 0.2, {0, 0, 0.6}), std::nullopt);
}

}  // namespace
}  // namespace sinew::calibration
