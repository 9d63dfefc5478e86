#include "sinew/vision/table_camera.h"

#include <gtest/gtest.h>

#include <cmath>

#include "sinew/core/units.h"
#include "sinew/vision/shapes.h"
#include "support/property.h"

namespace sinew::vision {
namespace {

constexpr double kEdge = 0.025;  // m

TableCamera some_camera(test::Random& random) {
  TableCamera camera;
  camera.model = pinhole(1280, 720, from_deg(random.uniform(40, 70)));
  camera.model.lens = {random.uniform(-0.1, 0.1), 0.01, 0, 0, 0};
  // Straight down, tilted by up to 30 deg.
  camera.X_WC = {
      rotation_z(random.uniform(-kPi, kPi)) * rotation_x(kPi + from_deg(random.uniform(-30, 30))),
      {random.uniform(-0.05, 0.05), random.uniform(-0.05, 0.05), 0.45}};
  return camera;
}

/// The cube as a perfect detection has it; nothing where it is not in view.
std::optional<SeenCube> seen(const TableCamera& camera, const Vec3& top_W, double turn) {
  SeenCube cube;
  for (std::size_t i = 0; i < 4; ++i) {
    const double angle = turn + from_deg(45 + 90.0 * static_cast<double>(i));
    const double out = kEdge / std::numbers::sqrt2;
    const auto p = camera.model.project(
        camera.X_WC.inverse() * (top_W + Vec3{out * std::cos(angle), out * std::sin(angle), 0}));
    if (!p) return std::nullopt;
    cube.top[i] = *p;
  }
  cube.size = std::sqrt(area_of(cube.top));
  cube.center = middle_of(cube.top);
  return cube;
}

TEST(TableCamera, cube_on_the_table_or_in_a_tower_is_where_it_is) {
  test::for_random_cases(300, [](test::Random& random) {
    const TableCamera camera = some_camera(random);
    const int level = static_cast<int>(random.integer(1, 4));
    const Vec3 top{random.uniform(-0.1, 0.1), random.uniform(-0.08, 0.08), level * kEdge};
    const double turn = random.uniform(0, kPi / 2);
    const auto cube = seen(camera, top, turn);
    if (!cube) return random.discard();
    const auto place = cube_position(camera, *cube, kEdge);
    ASSERT_TRUE(place);
    EXPECT_EQ(place->level, level);
    EXPECT_LT(norm(place->top_W - top), 1e-6);
    EXPECT_NEAR(place->edge, kEdge, 1e-6);
    EXPECT_NEAR(std::remainder(place->yaw - turn, kPi / 2), 0, 1e-6);
    EXPECT_FALSE(cube_position(camera, *cube, 2 * kEdge));
  });
}

TEST(TableCamera, pixel_of_a_point_leads_back_to_it_and_above_the_horizon_there_is_no_table) {
  test::for_random_cases(200, [](test::Random& random) {
    const TableCamera camera = some_camera(random);
    const double height = random.uniform(0, 0.1);
    const Vec3 p_W{random.uniform(-0.15, 0.15), random.uniform(-0.1, 0.1), height};
    const auto p = camera.model.project(camera.X_WC.inverse() * p_W);
    if (!p) return random.discard();
    const auto back = on_plane(camera, *p, height);
    ASSERT_TRUE(back);
    EXPECT_LT(norm(*back - p_W), 1e-8);
    EXPECT_FALSE(on_plane(camera, *p, 1)) << "above the camera";
  });
}

}  // namespace
}  // namespace sinew::vision
