#pragma once

#include <cmath>
#include <vector>

#include "sinew/calibration/plane_pose.h"
#include "support/property.h"

namespace sinew::calibration {

/// A number with mean 0 and standard deviation 1 (Box and Muller), the same on every platform.
inline double normal(test::Random& random) {
  const double radius = std::sqrt(-2 * std::log(random.uniform(1e-300, 1)));
  return radius * std::cos(random.uniform(0, 2 * kPi));
}

inline Vec3 random_vector(test::Random& random, double size) {
  return {random.uniform(-size, size), random.uniform(-size, size), random.uniform(-size, size)};
}

/// Whether the mean of `count` values of chi-square with so many degrees of freedom is as it should
/// be, within 4.5 standard deviations and what linearisation and a fitted sigma change.
inline void expect_chi_square(double sum, int count, int freedom) {
  const double mean = sum / count;
  EXPECT_NEAR(mean, freedom, 4.5 * std::sqrt(2.0 * freedom / count) + 0.05 * freedom);
}

/// A webcam of about 65 deg with a visible barrel distortion.
inline vision::CameraModel webcam() {
  return {1280, 720, 1000, 1005, {652, 351}, {-0.21, 0.07, 8e-4, -6e-4, 0}};
}

/// Points of a board in rows, its middle at 0.
inline std::vector<Vec3> grid(int columns, int rows, double pitch) {
  std::vector<Vec3> points;
  for (int row = 0; row < rows; ++row) {
    for (int column = 0; column < columns; ++column) {
      points.push_back(
          {(column - (columns - 1) / 2.0) * pitch, (row - (rows - 1) / 2.0) * pitch, 0});
    }
  }
  return points;
}

/// The points that the camera shows, with errors of `sigma` px in each coordinate.
inline vision::BoardCorners seen_points(const vision::CameraModel& camera, const PoseCB& X_CB,
                                        const std::vector<Vec3>& points_B, double sigma,
                                        test::Random& random) {
  vision::BoardCorners seen;
  for (const Vec3& p_B : points_B) {
    const auto pixel = camera.project(X_CB * p_B);
    if (!pixel) continue;
    const vision::Pixel p = *pixel + sigma * vision::Pixel{normal(random), normal(random)};
    if (p.x < 0 || p.y < 0 || p.x > camera.width || p.y > camera.height) continue;
    seen.points_B.push_back(p_B);
    seen.pixels.push_back(p);
  }
  return seen;
}

/// A board that faces the camera, upright at 0; tilted about the picture's axes, then turned.
inline PoseCB facing(double tilt_x, double tilt_y, double turn, const Vec3& p_CB) {
  return {rotation_y(tilt_y) * rotation_x(tilt_x) * rotation_x(kPi) * rotation_z(turn), p_CB};
}

}  // namespace sinew::calibration
