#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <optional>
#include <vector>

#include "sinew/calibration/calibration_error.h"
#include "sinew/calibration/geometry.h"
#include "sinew/calibration/projection.h"
#include "sinew/vision/tag_board.h"

namespace sinew::calibration {

using PoseCB = Pose<frame::Camera, frame::Board>;
using PoseWC = Pose<frame::World, frame::Camera>;

/// Standard deviation (px) of a coordinate of a corner in a sharp picture, where nothing better is
/// known.
inline constexpr double kCornerSigma = 0.2;

/// Pose of a plane target in one picture.
struct PlanePose {
  PoseCB X_CB;
  Matrix6 covariance;            ///< of X_CB: rad and m, as in moved(); of pixel errors alone
  double rms = 0;                ///< px, distance between points and their model
  double sigma = 0;              ///< px, of one coordinate, that the covariance is for
  std::optional<PoseCB> other;   ///< the second pose that looks nearly the same, where there is one
  double ambiguity = kInfinity;  ///< rms of the second pose over rms of the first, >= 1
  std::vector<std::size_t> wrong_points;  ///< that the fit left out, with 8 points or more

  /// Both poses explain the picture: take another picture, from another side or nearer.
  bool ambiguous() const { return ambiguity < 2; }
};

/// Pose of a target whose points lie in its plane z = 0: a tag, or all tags of a table.
///
/// Both minima of the reprojection error are searched, by Levenberg-Marquardt steps from a
/// homography and from its mirror image along the line of sight.
/// Source: G. Schweighofer, A. Pinz, Robust Pose Estimation from a Planar Target, 2006.
///
/// @param seen   at least 4 points
/// @param sigma  px, least standard deviation of a coordinate; the residuals may show a larger one
/// @return  1e-9 m and rad without pixel errors
/// @error  kTooFewPoints, kPointsOnLine (narrower than 5 % of their length), kNotConverged
Calibrated<PlanePose> plane_pose(const vision::CameraModel& camera,
                                 const vision::BoardCorners& seen, double sigma = kCornerSigma);

/// kTooFewPoints or kPointsOnLine, where a view cannot give a pose; index -1.
std::optional<CalibrationError> unusable(const vision::BoardCorners& seen);

/// Where the ray of a pixel meets the plane z = height (m) of the world, p_W. Nothing where the
/// plane is behind the camera, or the ray is within 1e-6 rad of it.
std::optional<Vec3> ray_to_plane(const vision::CameraModel& camera, const PoseWC& X_WC,
                                 vision::Pixel pixel, double height);

/// What is uncertain about a camera over a table. The default is an exact camera.
struct CameraUncertainty {
  Matrix6 pose = Matrix6::Zero();              ///< of X_WC, as in moved(); see inverse_covariance()
  CameraMatrix camera = CameraMatrix::Zero();  ///< of the parameters, as in projection.h
  double pixel = kCornerSigma;                 ///< px, standard deviation of a coordinate
};

/// Covariance (m^2) of x and y of ray_to_plane(). Pose and lens count as independent; where both
/// come from the same pictures their errors partly cancel, and the result is on the safe side.
/// @pre ray_to_plane() has a result
Eigen::Matrix2d table_covariance(const vision::CameraModel& camera, const PoseWC& X_WC,
                                 vision::Pixel pixel, double height,
                                 const CameraUncertainty& uncertainty);

}  // namespace sinew::calibration
