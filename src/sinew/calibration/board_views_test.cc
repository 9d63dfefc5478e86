#include "sinew/calibration/board_views.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "sinew/core/units.h"
#include "sinew/render/cell_scene.h"

namespace sinew::calibration {
namespace {

constexpr int kWidth = 640;

/// A picture of a printed sheet on a table.
vision::Picture picture(const vision::TagBoard& board, double aside, double turn, double blur = 0.6,
                        int width = kWidth, double distance = 0.5) {
  render::CellView view;
  view.sheets.push_back({board, {}, nullptr});
  const Vec3 eye = distance * Vec3{std::sin(aside) * std::cos(turn),
                                   std::sin(aside) * std::sin(turn), std::cos(aside)};
  render::Sensor sensor;
  sensor.blur = blur;
  return picture_of(view, vision::pinhole(width, 3 * width / 4, from_deg(50)),
                    render::looking_at(eye, {}), sensor, 1);
}

std::string code(const std::expected<TakenView, ViewRefusal>& view) {
  return view ? "" : view.error().code;
}

TEST(BoardViews, each_view_that_is_none_is_refused_with_a_reason) {
  auto views = BoardViews::of("a4");
  ASSERT_TRUE(views);
  EXPECT_FALSE(BoardViews::of("a5"));
  const auto flat = picture(views->board(), 0.1, 0);
  EXPECT_EQ(code(views->add(flat)), "");
  const auto again = views->add(flat);
  ASSERT_EQ(code(again), "same_view");
  EXPECT_EQ(again.error().sentence,
            "The board is where view 1 shows it already. Move, tilt or turn the board.");
  EXPECT_EQ(code(views->add(picture(views->board(), 0.5, 1))), "");
  EXPECT_EQ(code(views->add(picture(views->sheet(), 0.1, 0))), "no_board") << "the other sheet";
  EXPECT_EQ(code(views->lay(flat)), "no_sheet");
  EXPECT_EQ(code(views->add(vision::black_picture(kWidth, 480))), "no_board");
  const auto blurred = views->add(picture(views->board(), 0.3, 2, 2.5, kWidth, 0.28));
  ASSERT_EQ(code(blurred), "blurred");
  EXPECT_TRUE(blurred.error().is_spare());
  const auto larger = views->add(picture(views->board(), 0.3, 2, 0.6, 320));
  ASSERT_EQ(code(larger), "picture_size");
  EXPECT_EQ(larger.error().sentence,
            "The picture has 320 x 240 px, the views before have 640 x 480 px. Set the camera to "
            "its former size, or begin the calibration again.");
  // Three tags of the sheet do, two do not.
  auto sheet = picture(views->sheet(), 0.1, 0);
  const auto whiten = [&](int from_x, int to_x, int from_y, int to_y) {
    for (int y = from_y; y < to_y; ++y) {
      for (int x = from_x; x < to_x; ++x) std::fill_n(sheet.at(x, y), 3, 200);
    }
  };
  whiten(0, 320, 0, 240);
  EXPECT_EQ(code(views->lay(sheet)), "");
  whiten(0, 640, 0, 240);
  EXPECT_EQ(code(views->lay(sheet)), "few_tags");
  EXPECT_TRUE(views->table()) << "the one before stays";
  EXPECT_EQ(views->views().size(), 2U);
}

TEST(BoardViews, views_have_numbers_that_stay) {
  auto views = BoardViews::of("a4");
  for (int i = 0; i < 5; ++i) {
    ASSERT_EQ(code(views->add(picture(views->board(), 0.15 * i, 1.3 * i))), "") << i;
  }
  EXPECT_EQ(views->result().residuals.size(), 5U);
  EXPECT_FALSE(views->result().camera);
  EXPECT_TRUE(views->drop(2));
  EXPECT_FALSE(views->drop(2));
  EXPECT_EQ(views->views()[1].number, 3U);
  const auto view = views->add(picture(views->board(), 0.6, 3.2));
  ASSERT_TRUE(view);
  EXPECT_EQ(view->number, 6U);
  ASSERT_TRUE(views->lay(picture(views->sheet(), 0.2, 1)));
  const auto result = views->result();
  ASSERT_TRUE(result.camera) << (result.trouble ? sentence(*result.trouble) : "");
  EXPECT_EQ(result.camera->camera.sheet, "a4");
  ASSERT_EQ(result.residuals.size(), 5U);
  for (const double residual : result.residuals) EXPECT_LT(residual, 1);
  EXPECT_LT(result.camera->camera.accuracy, 0.004);
  EXPECT_TRUE(result.better) << "five views are few";
}

}  // namespace
}  // namespace sinew::calibration
