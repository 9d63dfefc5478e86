#include "sinew/render/silhouette.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <vector>

#include "sinew/core/units.h"
#include "sinew/render/cell_scene.h"
#include "sinew/vision/view_watch.h"
#include "support/robots.h"

/// A camera over a table with an arm that moves: what the arm does is expected, what comes into
/// view beside it is not.
namespace sinew::render {
namespace {

const vision::CameraModel& camera() {
  static const auto model = vision::pinhole(192, 144, from_deg(55));
  return model;
}
Pose<frame::World, frame::Camera> above() {
  return looking_at({0.05, 0, 0.52}, {0.05, 0, 0});
}
/// Cells: one and a half cubes.
constexpr double kLeast = 1.5 * 4.4 * 4.4;
constexpr double kMargin = 0.03;

ViewedRobot learm(double base, double shoulder) {
  ViewedRobot robot{test::robot("learm"), {Rotation{}, {-0.15, 0, 0}}, {}, 0.04};
  for (const double q : {base, shoulder, 0.6, 0.9, 0.0}) robot.q.push_back(q);
  return robot;
}

CellView table(std::uint64_t seed) {
  CellView view;
  view.seed = seed;
  view.middle_W = {0.05, 0, 0};
  view.lamps = 2;
  view.cubes = {{{rotation_z(0.4), {0.12, 0.1, 0.0125}}, 0.025, vision::ColorName::kRed},
                {{rotation_z(1.0), {0.1, -0.1, 0.0125}}, 0.025, vision::ColorName::kBlue}};
  return view;
}

std::vector<bool> expected(const CellView& view) {
  return silhouette(view.robots, camera(), above(), kMargin);
}

TEST(Silhouette, holds_the_arm_and_no_more_than_a_part_of_the_picture) {
  CellView view = table(1);
  EXPECT_EQ(std::ranges::count(expected(view), true), 0) << "no robot";
  view.robots = {learm(0.2, 0.7)};
  const auto cells = expected(view);
  const auto count = std::ranges::count(cells, true);
  EXPECT_GT(count, 200);
  EXPECT_LT(count, static_cast<std::ptrdiff_t>(cells.size() / 2));
  const auto without = picture_of(table(1), camera(), above(), {}, 1);
  const auto with = picture_of(view, camera(), above(), {}, 1);
  vision::ViewWatch watch(kLeast);
  const std::vector<bool> none(cells.size(), false);
  EXPECT_FALSE(watch.look(without, none));
  EXPECT_FALSE(watch.look(with, none)) << "once may be an error";
  EXPECT_TRUE(watch.look(with, none)) << "an arm that is not expected";
  vision::ViewWatch knowing(kLeast);
  EXPECT_FALSE(knowing.look(without, none));
  for (int k = 0; k < 3; ++k) EXPECT_FALSE(knowing.look(with, cells));
}

TEST(Silhouette, an_arm_that_works_with_its_shadow_is_no_disturbance_and_a_hand_is) {
  int noticed = 0, late = 0;
  for (std::uint64_t seed = 1; seed <= 6; ++seed) {
    CellView view = table(seed);
    vision::ViewWatch watch(kLeast);
    Sensor sensor{.jpeg = 75, .shutter = 0.02, .read_out = 0.02};
    constexpr int kPictures = 8;
    for (int k = 0; k < kPictures; ++k) {
      view.robots = {learm(-0.5 + 0.09 * k, 0.5 + 0.04 * k)};
      // A cube that is taken away under the hand.
      if (k == 5) view.cubes.pop_back();
      if (k == 5) view.robots[0] = learm(-0.5, 0.9);
      if (k % 4 == 1) view.robots[0].qd = {0.5, 0.3, 0, 0, 0};
      sensor.exposure = 1 + 0.02 * (k % 3);
      const float tint = k < 4 ? 0.0F : 0.2F;
      sensor.balance = {1 + tint, 1, 1 - tint};  // as phones have it
      const auto cells = expected(view);
      const auto there = watch.look(picture_of(view, camera(), above(), sensor, seed + 10), cells);
      EXPECT_FALSE(there) << "seed " << seed << ", picture " << k;
    }
    view.hand = ViewedHand{{0.14, 0.12, 0.06}, 0.6};
    bool seen = false;
    for (int k = 0; k < 3; ++k) {
      const auto there =
          watch.look(picture_of(view, camera(), above(), sensor, seed + 20), expected(view));
      if (there && !seen) late += k;
      seen = seen || there.has_value();
    }
    noticed += seen ? 1 : 0;
  }
  EXPECT_GE(noticed, 5) << "one lies on a table of its own color";
  EXPECT_EQ(late, noticed) << "in the second picture";
}

/// Plain, with what differs in it.
vision::Picture plain(const std::array<int, 3>& table, const std::array<int, 3>& patch) {
  vision::Picture picture{192, 144, {}};
  for (int y = 0; y < picture.height; ++y) {
    for (int x = 0; x < picture.width; ++x) {
      const bool here = x >= 60 && x < 120 && y >= 40 && y < 100;
      for (const int value : here ? patch : table) {
        picture.rgb.push_back(static_cast<std::uint8_t>(value));
      }
    }
  }
  return picture;
}

TEST(Silhouette, a_shadow_that_comes_or_goes_is_nothing_new_and_skin_on_wood_is) {
  const std::array<int, 3> wood{163, 128, 91}, shaded{98, 77, 56}, skin{200, 160, 130};
  const std::vector<bool> none(vision::grid_of(192, 144).size(), false);
  const auto told = [&](const std::array<int, 3>& before, const std::array<int, 3>& now) {
    vision::ViewWatch watch(kLeast);
    EXPECT_FALSE(watch.look(plain(wood, before), none));
    bool any = false;
    for (int k = 0; k < 3; ++k) any = watch.look(plain(wood, now), none).has_value() || any;
    return any;
  };
  EXPECT_FALSE(told(wood, shaded));
  EXPECT_FALSE(told(shaded, wood)) << "it was there when the watch began";
  EXPECT_TRUE(told(wood, skin));
  EXPECT_TRUE(told(shaded, skin));
  EXPECT_TRUE(told(wood, {40, 60, 150}));
  // A channel, or all, that the sensor cuts off.
  const std::array<int, 3> red{255, 165, 163}, red_shaded{250, 121, 119}, white{255, 255, 255};
  EXPECT_FALSE(told(red, red_shaded));
  EXPECT_FALSE(told(red_shaded, red));
  EXPECT_FALSE(told({255, 205, 199}, white));
  EXPECT_TRUE(told(red, skin));
  EXPECT_TRUE(told(red_shaded, skin));
  EXPECT_TRUE(told(white, skin));
  EXPECT_TRUE(told(red, {60, 60, 70}));
  EXPECT_TRUE(told(red_shaded, white));
  EXPECT_TRUE(told({245, 230, 200}, {200, 150, 120})) << "skin on a bright table";
}

TEST(Silhouette, a_camera_that_is_covered_while_the_arm_moves_is_a_disturbance) {
  const CellView view = table(3);
  auto picture = picture_of(view, camera(), above(), {}, 1);
  vision::ViewWatch watch(kLeast);
  const auto cells = expected(view);
  EXPECT_FALSE(watch.look(picture, cells));
  std::ranges::fill(picture.rgb, std::uint8_t{9});
  EXPECT_FALSE(watch.look(picture, cells));
  EXPECT_TRUE(watch.look(picture, cells));
  watch.begin_again();
  EXPECT_FALSE(watch.look(picture, cells)) << "as it is now";
  EXPECT_FALSE(watch.look(picture, cells));
}

}  // namespace
}  // namespace sinew::render
