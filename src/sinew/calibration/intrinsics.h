#pragma once

#include <array>
#include <cstddef>
#include <span>
#include <vector>

#include "sinew/calibration/calibration_error.h"
#include "sinew/calibration/plane_pose.h"
#include "sinew/calibration/projection.h"
#include "sinew/vision/tag_board.h"

namespace sinew::calibration {

/// One picture of a plane board. Views may show different points of it.
struct BoardView {
  int width = 0;              ///< px, of the picture
  int height = 0;             ///< px
  vision::BoardCorners seen;  ///< at least 4 points with z = 0
};

/// A point that a fit left out because it is far from its model.
struct WrongPoint {
  std::size_t view = 0;
  std::size_t point = 0;  ///< index in the view
  double error = 0;       ///< px

  friend bool operator==(const WrongPoint&, const WrongPoint&) = default;
};

/// A camera, measured.
struct Intrinsics {
  vision::CameraModel camera;
  CameraMatrix covariance;               ///< of the parameters, as in projection.h
  CameraVector sigma;                    ///< standard deviations: the roots of its diagonal
  std::vector<PoseCB> X_CB;              ///< of the board, by view
  double pixel_sigma = 0;                ///< px, standard deviation of one coordinate
  double rms = 0;                        ///< px, distance between points and their model
  double error_95 = 0;                   ///< px, not exceeded by 95 % of these distances
  std::vector<WrongPoint> wrong_points;  ///< left out; not part of the figures
};

/// Focal lengths, centre and lens of a camera from pictures of a plane board.
///
/// Starts from Zhang's closed form with square pixels and the centre of the picture; then
/// Levenberg-Marquardt steps over all parameters and poses, with Huber's weights until wrong points
/// are known. Lens coefficients are added in the order k1, k2, p1 and p2, k3 while the data shows
/// them (Bayesian information criterion) and the lens stays invertible over the picture.
/// Sources: Z. Zhang, A Flexible New Technique for Camera Calibration, 2000; G. Schwarz, Estimating
/// the Dimension of a Model, 1978.
///
/// A coefficient that is held at 0 is not known to be 0. The covariance contains what it may be, in
/// an ordinary lens: 0.3 for k1, 0.2 for k2, 0.001 for p1 and p2, 0.05 for k3 (standard
/// deviations).
///
/// @param views  at least 4, with 3 or more different tilts for good figures (view_coverage.h)
/// @return  without pixel errors: 1e-6 px, 1e-9 in k1
/// @error  kPictureSize, kTooFewViews, kTooFewPoints, kPointsOnLine, kNotConverged (rms over 1 %
///         of the width), kFocalUncertain (over 2 %), kViewsParallel (either of these, and all
///         tilts within 15 deg)
Calibrated<Intrinsics> intrinsics(std::span<const BoardView> views);

/// A camera with square pixels and a centred, straight lens that explains the views best; 1 px of
/// focal length per px of width where they cannot tell it. For a first look at tilts and distances.
vision::CameraModel rough_camera(std::span<const BoardView> views);

}  // namespace sinew::calibration
