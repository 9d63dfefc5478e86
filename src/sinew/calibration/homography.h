#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "sinew/core/pose.h"
#include "sinew/vision/camera_model.h"

namespace sinew::calibration {

using Points2 = std::vector<Eigen::Vector2d>;

/// H with to ~ H (from, 1), scaled to length 1, for four or more pairs of points; nothing where
/// they lie on a line. Where a few pairs are wrong, the fit is repeated without them.
///
/// Source: R. Hartley, In Defense of the Eight-Point Algorithm, 1997 (normalisation); P. Rousseeuw,
/// Least Median of Squares Regression, 1984.
std::optional<Eigen::Matrix3d> homography(const Points2& from, const Points2& to);

/// The affine map with to ~ H (from, 1), as a homography: rough, but sound where three of four
/// points are on a line. Nothing where all are.
std::optional<Eigen::Matrix3d> affine_map(const Points2& from, const Points2& to);

/// Pose of a board whose plane z = 0 (m) appears on the plane z = 1 of the camera by H.
Pose<frame::Camera, frame::Board> pose_of_homography(const Eigen::Matrix3d& H);

}  // namespace sinew::calibration
