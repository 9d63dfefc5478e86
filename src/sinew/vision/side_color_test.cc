#include "sinew/vision/side_color.h"

#include <gtest/gtest.h>

#include <vector>

#include "sinew/core/rotation.h"
#include "sinew/core/units.h"
#include "sinew/render/cell_scene.h"
#include "sinew/vision/view_watch.h"

namespace sinew::vision {
namespace {

constexpr double kEdge = 0.025;  // m

TEST(SideColor, colours_are_called_by_their_hue_black_where_dark_and_nothing_where_grey) {
  EXPECT_EQ(name_by_hue({200, 40, 40}), ColorName::kRed);
  EXPECT_EQ(name_by_hue({230, 120, 30}), ColorName::kOrange);
  EXPECT_EQ(name_by_hue({220, 200, 40}), ColorName::kYellow);
  EXPECT_EQ(name_by_hue({60, 180, 80}), ColorName::kGreen);
  EXPECT_EQ(name_by_hue({40, 90, 200}), ColorName::kBlue);
  EXPECT_EQ(name_by_hue({120, 50, 190}), ColorName::kPurple);
  EXPECT_EQ(name_by_hue({240, 140, 170}), ColorName::kPink);
  EXPECT_EQ(name_by_hue({200, 110, 180}), ColorName::kPink);
  EXPECT_EQ(name_by_hue({40, 38, 35}), ColorName::kBlack);
  EXPECT_EQ(name_by_hue({200, 168, 128}), ColorName::kWood);
  EXPECT_FALSE(name_by_hue({150, 150, 140}));
  EXPECT_FALSE(name_by_hue({62, 60, 55})) << "the shaded side of a grey one";
  EXPECT_FALSE(name_by_hue({250, 245, 240}));
}

/// Tops that a lamp burns out; the camera stands a little aside.
TEST(SideColor, side_faces_show_the_color_of_a_cube_whose_top_is_burnt_out) {
  TableCamera camera;
  camera.model = pinhole(640, 480, from_deg(45));
  camera.X_WC = render::looking_at({0, -0.2, 0.5}, {0, 0, 0});
  int right = 0, wrong = 0;
  for (std::uint64_t seed = 1; seed <= 4; ++seed) {
    render::CellView view;
    view.seed = seed;
    view.top = render::TableTop::kPaper;
    view.reach = 0.25;
    std::vector<SeenCube> cubes;
    const ColorName colors[]{ColorName::kPink,  ColorName::kBlack, ColorName::kYellow,
                             ColorName::kGreen, ColorName::kBlue,  ColorName::kOrange};
    for (std::size_t i = 0; i < std::size(colors); ++i) {
      const double x = -0.1 + 0.1 * static_cast<double>(i % 3), y = i < 3 ? -0.04 : 0.06;
      const double turn = 0.2 * static_cast<double>(seed + i);
      view.cubes.push_back({{rotation_z(turn), {x, y, kEdge / 2}}, kEdge, colors[i]});
      SeenCube cube;
      cube.color = colors[i];
      cube.position = CubePosition{{x, y, kEdge}, turn, kEdge, 1};
      cubes.push_back(cube);
    }
    const auto picture =
        render::picture_of(view, camera.model, camera.X_WC, {.exposure = 1.5}, seed);
    const WhiteBalance balance(picture);
    for (const SeenCube& cube : cubes) {
      const auto color = side_color(picture, balance, camera, *cube.position, kEdge, {});
      if (!color) continue;
      ++(*color == cube.color ? right : wrong);
    }
  }
  EXPECT_GE(right, 20) << "of 24";
  EXPECT_LE(wrong, 2);
}

TEST(SideColor, a_face_behind_another_cube_says_nothing) {
  TableCamera camera;
  camera.model = pinhole(640, 480, from_deg(45));
  camera.X_WC = render::looking_at({0, 0, 0.5}, {0, 0.001, 0});
  const Picture picture = black_picture(640, 480);
  const WhiteBalance balance(picture);
  const CubePosition cube{{0.1, 0, kEdge}, 0, kEdge, 1};
  EXPECT_EQ(side_color(picture, balance, camera, cube, kEdge, {}), ColorName::kBlack);
  const Vec3 before{0.1 - kEdge, 0, kEdge};
  EXPECT_FALSE(side_color(picture, balance, camera, cube, kEdge, std::span(&before, 1)));
  const std::vector<bool> robot(grid_of(640, 480).size(), true);
  EXPECT_FALSE(side_color(picture, balance, camera, cube, kEdge, {}, robot)) << "a robot hides it";
}

}  // namespace
}  // namespace sinew::vision
