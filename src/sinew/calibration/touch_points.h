#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "sinew/calibration/calibration_error.h"
#include "sinew/core/pose.h"

namespace sinew::calibration {

/// A point that the tool's tip touched, and the same point as the camera or a drawing gives it.
struct TouchedPoint {
  Vec3 p_B;  ///< m, in the robot's base
  Vec3 p_W;  ///< m, in the table's frame
};

/// The table's frame in the robot's base, measured.
struct TableFrame {
  Pose<frame::Base, frame::World> X_BW;
  std::vector<double> residuals;  ///< m, by point
  double rms = 0;                 ///< m, of the residuals
  std::size_t worst = 0;  ///< the point without which the others fit best; of three, the one with
                          ///< the largest residual
  double error_95 = 0;  ///< m, 95 % at a new point, each point predicted from the others; 0 with 3
};

/// Rigid transform between touched points and seen points, in the least-squares sense.
/// Source: W. Kabsch, A Solution for the Best Rotation to Relate Two Sets of Vectors, 1976.
///
/// @param points  3 or more
/// @return  1e-12 m for exact points; never a reflection
/// @error  kTooFewPoints; kPointsOnLine (narrower than 10 % of their length)
Calibrated<TableFrame> table_frame(std::span<const TouchedPoint> points);

}  // namespace sinew::calibration
