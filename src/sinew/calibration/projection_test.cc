#include "sinew/calibration/projection.h"

#include <gtest/gtest.h>

#include "sinew/calibration/scene_test_data.h"

namespace sinew::calibration {
namespace {

Eigen::Vector2d pixel_of(const vision::CameraModel& camera, const Vec3& p_CQ) {
  const vision::Pixel p = camera.project(p_CQ).value();
  return {p.x, p.y};
}

TEST(Projection, is_that_of_the_camera_model_and_its_derivatives_are_differences) {
  test::for_random_cases(200, [](test::Random& random) {
    const vision::CameraModel camera = with_parameters(
        webcam(), parameters_of(webcam()) + CameraVector::Constant(random.uniform(0, 0.01)));
    const Vec3 p = Vec3{0, 0, 0.5} + random_vector(random, 0.15);
    const auto found = projection(camera, p);
    ASSERT_TRUE(found);
    EXPECT_LT((found->pixel - pixel_of(camera, p)).norm(), 1e-9);
    constexpr double kStep = 1e-6;
    for (Eigen::Index i = 0; i < 3; ++i) {
      const Vec3 step = to_vec3(kStep * Eigen::Vector3d::Unit(i));
      const Eigen::Vector2d slope =
          (pixel_of(camera, p + step) - pixel_of(camera, p - step)) / (2 * kStep);
      EXPECT_LT((found->by_point.col(i) - slope).norm(), 1e-4) << i;
    }
    for (Eigen::Index i = 0; i < kCameraParameters; ++i) {
      const CameraVector step = kStep * CameraVector::Unit(i);
      const auto at = [&](const CameraVector& change) {
        return pixel_of(with_parameters(camera, parameters_of(camera) + change), p);
      };
      const Eigen::Vector2d slope = (at(step) - at(-step)) / (2 * kStep);
      EXPECT_LT((found->by_camera.col(i) - slope).norm(), 1e-4) << i;
    }
  });
  EXPECT_FALSE(projection(webcam(), {0.1, 0, -0.5}));
}

}  // namespace
}  // namespace sinew::calibration
