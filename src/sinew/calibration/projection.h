#pragma once

#include <Eigen/Core>
#include <optional>

#include "sinew/core/vec3.h"
#include "sinew/vision/camera_model.h"

namespace sinew::calibration {

/// Parameters of a camera in every vector and matrix here: fx, fy, centre x, centre y (px), then
/// k1, k2, p1, p2, k3.
inline constexpr int kCameraParameters = 9;
using CameraVector = Eigen::Matrix<double, kCameraParameters, 1>;
using CameraMatrix = Eigen::Matrix<double, kCameraParameters, kCameraParameters>;

CameraVector parameters_of(const vision::CameraModel& camera);
vision::CameraModel with_parameters(vision::CameraModel camera, const CameraVector& parameters);

/// CameraModel::project() with its derivatives.
struct Projection {
  Eigen::Vector2d pixel;
  Eigen::Matrix<double, 2, 3> by_point;                   ///< px/m, by p_CQ
  Eigen::Matrix<double, 2, kCameraParameters> by_camera;  ///< px per unit of each parameter
};

/// Nothing for a point behind the lens. Unlike project(), a lens that folds back is not refused:
/// a fit may pass through such lenses.
std::optional<Projection> projection(const vision::CameraModel& camera, const Vec3& p_CQ);

}  // namespace sinew::calibration
