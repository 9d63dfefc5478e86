#include "sinew/vision/camera_model.h"

#include <gtest/gtest.h>

#include <cmath>

#include "sinew/core/units.h"
#include "support/property.h"

namespace sinew::vision {
namespace {

TEST(CameraModel, a_pixel_s_direction_is_seen_at_that_pixel) {
  test::for_random_cases(300, [](test::Random& random) {
    CameraModel camera = pinhole(1280, 720, from_deg(random.uniform(30, 70)));
    camera.lens = {random.uniform(-0.2, 0.1), random.uniform(-0.02, 0.05),
                   random.uniform(-1e-3, 1e-3), random.uniform(-1e-3, 1e-3), 0};
    const Pixel p{random.uniform(0, 1280), random.uniform(0, 720)};
    const Vec3 toward = camera.direction(p);
    EXPECT_NEAR(norm(toward), 1, 1e-12);
    const auto seen = camera.project(random.uniform(0.1, 3) * toward);
    ASSERT_TRUE(seen);
    EXPECT_NEAR(seen->x, p.x, 1e-6);
    EXPECT_NEAR(seen->y, p.y, 1e-6);
  });
}

TEST(CameraModel, field_of_view_ends_at_the_border_and_nothing_is_behind_the_lens) {
  const CameraModel camera = pinhole(640, 480, from_deg(60));
  const Vec3 left = camera.direction({0, 240});
  EXPECT_NEAR(std::atan2(left.x, left.z), -from_deg(30), 1e-12);
  EXPECT_FALSE(camera.project({0.1, 0, 0}));
  EXPECT_FALSE(camera.project({0, 0, -1}));
  CameraModel bent = camera;
  bent.lens = {-0.4, 0, 0, 0, 0};
  EXPECT_FALSE(bent.project({2, 0, 1})) << "the model folds back there";
  bent.lens = {-2, 0, 0, 0, 0};
  EXPECT_NEAR(norm(bent.direction({0, 0})), 1, 1e-12) << "no direction is seen there, yet no NaN";
}

}  // namespace
}  // namespace sinew::vision
