#include "sinew/vision/table_thing.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "sinew/core/rotation.h"
#include "sinew/core/units.h"
#include "sinew/render/cell_scene.h"
#include "support/property.h"

namespace sinew::vision {
namespace {

constexpr double kEdge = 0.025;  // m

/// From 0.5 m above the table, aslant by 20 deg.
TableCamera camera_above() {
  TableCamera camera;
  camera.model = pinhole(640, 360, from_deg(60));
  camera.X_WC = {rotation_x(kPi + from_deg(20)), {0, -0.15, 0.5}};
  return camera;
}

Picture picture_with(const TableCamera& camera, const render::ViewedThing& thing,
                     std::uint64_t seed) {
  render::CellView view;
  view.seed = seed;
  view.top = render::TableTop::kWood;
  view.clutter = {thing};
  return render::picture_of(view, camera.model, camera.X_WC, {}, seed);
}

TEST(TableThing, measures_length_width_and_yaw_of_a_brick) {
  const TableCamera camera = camera_above();
  test::for_random_cases(12, [&](test::Random& random) {
    render::ViewedThing brick;
    brick.half = {random.uniform(0.015, 0.035), random.uniform(0.007, 0.014), kEdge / 4};
    const double yaw = random.uniform(0, kPi);
    brick.X_WS = {rotation_z(yaw),
                  {random.uniform(-0.1, 0.1), random.uniform(-0.08, 0.08), brick.half.z}};
    brick.srgb = random.uniform(0, 1) < 0.5 ? 0xC02020 : 0x303236;
    const auto picture = picture_with(camera, brick, random.bits());
    const auto p =
        camera.model.project(camera.X_WC.inverse() * (brick.X_WS.p + Vec3{0, 0, brick.half.z}));
    const auto found = thing_position(picture, camera, *p, kEdge);
    ASSERT_TRUE(found);
    const Vec3 off = found->top_W - brick.X_WS.p;
    EXPECT_LT(std::hypot(off.x, off.y), 4e-3);
    EXPECT_EQ(found->top_W.z, kEdge);
    EXPECT_NEAR(std::max(found->half_x, found->half_y), brick.half.x, 4e-3);
    EXPECT_NEAR(std::min(found->half_x, found->half_y), brick.half.y, 4e-3);
    const double long_side = found->yaw + (found->half_x < found->half_y ? kPi / 2 : 0);
    EXPECT_NEAR(std::sin(long_side - yaw), 0, 0.15);
  });
}

TEST(TableThing, rejects_the_table_large_sheets_and_pixels_outside_the_picture) {
  const TableCamera camera = camera_above();
  render::ViewedThing sheet;
  sheet.half = {0.09, 0.07, 5e-5};
  sheet.X_WS.p = {0.05, 0, 1e-4};
  sheet.srgb = 0xF4F4F0;
  const auto picture = picture_with(camera, sheet, 3);
  const auto at = [&](double x, double y) {
    const auto p = camera.model.project(camera.X_WC.inverse() * Vec3{x, y, 0});
    return thing_position(picture, camera, *p, kEdge);
  };
  EXPECT_FALSE(at(-0.15, 0)) << "the table";
  EXPECT_FALSE(at(0.05, 0)) << "larger than anything";
  EXPECT_FALSE(thing_position(picture, camera, {-500, 300}, kEdge));
}

}  // namespace
}  // namespace sinew::vision
