#include "sinew/calibration/table_calibration.h"

#include <gtest/gtest.h>

#include <cmath>

#include "sinew/core/units.h"
#include "sinew/render/view.h"
#include "support/property.h"

namespace sinew::calibration {
namespace {

/// Pictures of boards as a camera of 1280 x 720 px takes them.
class Studio {
 public:
  Studio() {
    camera_ = vision::pinhole(1280, 720, from_deg(58));
    camera_.center = {652, 351};
    camera_.lens = {-0.12, 0.03, 4e-4, -3e-4, 0};
  }
  const vision::CameraModel& camera() const { return camera_; }

  /// Corners that are off by `noise` px (1 sigma, of an even spread).
  BoardView points(const vision::TagBoard& board, const PoseWC& X_WC, double noise,
                   test::Random& random) const {
    BoardView view{1280, 720, {}};
    for (int i = 0; i < board.columns * board.rows; ++i) {
      for (std::size_t k = 0; k < 4; ++k) {
        const Vec3 p = board.corner(board.first + i, k);
        const auto pixel = camera_.project(X_WC.inverse() * p);
        if (!pixel || pixel->x < 5 || pixel->y < 5 || pixel->x > 1275 || pixel->y > 715) continue;
        const double half = noise * std::sqrt(3.0);
        view.seen.points_B.push_back(p);
        view.seen.pixels.push_back(
            *pixel + vision::Pixel{random.uniform(-half, half), random.uniform(-half, half)});
      }
    }
    return view;
  }

  /// The tags that are found in a rendered picture of the board on a table.
  BoardView picture(const vision::TagBoard& board, const PoseWC& X_WC, std::uint64_t seed) const {
    render::Scene scene;
    scene.solids.push_back({render::Ground{}, {}, {.color = {0.3F, 0.25F, 0.2F}}});
    render::Material paper{.color = {0.85F, 0.85F, 0.85F}};
    paper.print = {std::make_shared<const vision::Picture>(picture_of(board, 4000)), board.width,
                   board.height, true};
    scene.solids.push_back({render::box({board.width / 2, board.height / 2, 1e-5}),
                            {Rotation{}, {0, 0, -1e-5 + 1e-7}},
                            paper});
    scene.solids[0].X_WS.p.z = -1e-4;
    scene.lamps.push_back({{0.6, 0.4, 1.2}, 0.1, {0.8F, 0.8F, 0.8F}});
    const render::View view = render::view_of(scene, camera_, X_WC, seed);
    const auto taken = render::taken(view, {.exposure = exposure_of(view)}, seed);
    return {1280, 720, corners_in(board, vision::TagFinder({board.family}).find(taken))};
  }

 private:
  static double exposure_of(const render::View& view) {
    double sum = 0;
    for (const render::Rgb& light : view.light) sum += light.g;
    return 0.3 * static_cast<double>(view.light.size()) / sum;
  }

  vision::CameraModel camera_;
};

/// Around the board, from above and aside.
PoseWC around(double aside, double turn, double distance) {
  const Vec3 eye{distance * std::sin(aside) * std::cos(turn),
                 distance * std::sin(aside) * std::sin(turn), distance * std::cos(aside)};
  return render::looking_at(eye, {0.02 * std::cos(turn), 0.02 * std::sin(turn), 0});
}

/// m, rms of where a calibrated camera sees points of the table, against where they are.
double error_on_table(const Studio& studio, const PoseWC& X_WC, const TableCalibration& result) {
  double sum = 0;
  int count = 0;
  for (double x = -0.2; x <= 0.2; x += 0.05) {
    for (double y = -0.1; y <= 0.1; y += 0.05) {
      const auto pixel = studio.camera().project(X_WC.inverse() * Vec3{x, y, 0});
      const auto seen = vision::on_plane(result.camera, *pixel, 0);
      sum += std::pow(norm(*seen - Vec3{x, y, 0}), 2);
      ++count;
    }
  }
  return std::sqrt(sum / count);
}

TEST(TableCalibration, camera_is_found_and_its_error_is_what_it_says) {
  const auto board = vision::calibration_board("a4");
  const auto sheet = vision::table_sheet("a4");
  const Studio studio;
  std::vector<double> real;
  std::vector<double> told;
  test::for_random_cases(12, [&](test::Random& random) {
    std::vector<BoardView> views;
    for (int i = 0; i < 9; ++i) {
      views.push_back(studio.points(
          *board, around(from_deg(random.uniform(10, 42)), 0.7 * i, random.uniform(0.32, 0.5)), 0.2,
          random));
    }
    const PoseWC X_WC = around(from_deg(random.uniform(8, 20)), random.uniform(0, 6), 0.55);
    const auto result = table_calibration(views, studio.points(*sheet, X_WC, 0.2, random));
    ASSERT_TRUE(result) << sentence(result.error());
    EXPECT_NEAR(result->camera.model.fx, studio.camera().fx, 8);
    EXPECT_LT(norm(result->camera.X_WC.p - X_WC.p), 0.006);
    real.push_back(error_on_table(studio, X_WC, *result));
    told.push_back(result->camera.accuracy);
    EXPECT_LT(real.back(), 0.0015);
  });
  EXPECT_LT(quantile(real, 0.5), 2 * quantile(told, 0.5)) << "it tells less than it is off";
  EXPECT_LT(quantile(told, 0.5), 0.002);
}

TEST(TableCalibration, rendered_boards_at_720p_give_two_millimetres_at_the_table) {
  const auto board = vision::calibration_board("a4");
  const auto sheet = vision::table_sheet("a4");
  const Studio studio;
  std::vector<BoardView> views;
  for (int i = 0; i < 6; ++i) {
    views.push_back(studio.picture(*board, around(from_deg(8 + 6.0 * i), 1.1 * i, 0.36 + 0.02 * i),
                                   static_cast<std::uint64_t>(i)));
    EXPECT_GT(views.back().seen.pixels.size(), 60U);
  }
  const PoseWC X_WC = around(from_deg(12), 0.4, 0.55);
  const auto result = table_calibration(views, studio.picture(*sheet, X_WC, 9));
  ASSERT_TRUE(result) << sentence(result.error());
  EXPECT_LT(result->intrinsics.rms, 0.6);
  EXPECT_LT(error_on_table(studio, X_WC, *result), 0.002);
  EXPECT_LT(result->camera.accuracy, 0.003);
}

TEST(TableCalibration, what_is_missing_is_said) {
  const auto board = vision::calibration_board("a4");
  const auto sheet = vision::table_sheet("a4");
  const Studio studio;
  test::Random random(3);
  std::vector<BoardView> views;
  for (int i = 0; i < 6; ++i) {
    views.push_back(studio.points(*board, around(0.2 + 0.1 * i, 1.0 * i, 0.4), 0.2, random));
  }
  const BoardView table = studio.points(*sheet, around(0.2, 0, 0.55), 0.2, random);
  const auto fault = [&](std::size_t count, const BoardView& of_sheet) {
    const auto result = table_calibration(std::span(views).first(count), of_sheet);
    return result ? std::pair(CalibrationFault{}, 99)
                  : std::pair(result.error().fault, result.error().index);
  };
  EXPECT_EQ(fault(4, table), std::pair(CalibrationFault::kTooFewViews, -1));
  BoardView smaller = table;
  smaller.width = 640;
  EXPECT_EQ(fault(6, smaller), std::pair(CalibrationFault::kPictureSize, 6));
  BoardView three = table;
  three.seen.pixels.resize(3);
  three.seen.points_B.resize(3);
  EXPECT_EQ(fault(6, three), std::pair(CalibrationFault::kTooFewPoints, 6));
}

}  // namespace
}  // namespace sinew::calibration
