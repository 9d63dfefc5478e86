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

TEST(TableCamera, tags_that_seem_to_be_elsewhere_tell_how_far_it_was_moved) {
  const auto sheet = table_sheet("a4");
  test::for_random_cases(100, [&](test::Random& random) {
    const TableCamera camera = some_camera(random);
    EXPECT_FALSE(sheet_shift(camera, *sheet, {}));
    TableCamera knocked = camera;
    const Vec3 way{random.uniform(-0.02, 0.02), random.uniform(-0.02, 0.02), 0};
    knocked.X_WC.p = knocked.X_WC.p + way;
    std::vector<SeenTag> tags;
    for (int id = sheet->first; id < sheet->first + 4; ++id) {
      SeenTag tag{.family = sheet->family, .id = id};
      for (std::size_t i = 0; i < 4; ++i) {
        const auto p = knocked.model.project(knocked.X_WC.inverse() * sheet->corner(id, i));
        if (!p) return random.discard();
        tag.corners[i] = *p;
      }
      tags.push_back(tag);
    }
    EXPECT_NEAR(*sheet_shift(camera, *sheet, tags), norm(way), 1e-6);
    EXPECT_NEAR(*sheet_shift(knocked, *sheet, tags), 0, 1e-6);
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
