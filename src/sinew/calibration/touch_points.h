#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "sinew/calibration/calibration_error.h"
#include "sinew/calibration/geometry.h"
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
  std::size_t worst = 0;   ///< the point without which the others fit best; of three, the one with
                           ///< the largest residual
  double sigma = 0;        ///< m, standard deviation of a coordinate of a touched point
  double freedom = 0;      ///< residuals less parameters, which sigma was estimated from
  Matrix6 covariance;      ///< of X_BW, as in moved(); for that sigma
  double scale = 1;        ///< touched distances over those of the drawing
  double scale_sigma = 0;  ///< its standard deviation
};

/// Rigid transform between touched points and seen points, in the least-squares sense.
/// Source: W. Kabsch, A Solution for the Best Rotation to Relate Two Sets of Vectors, 1976.
///
/// @param points       3 or more
/// @param sigma_least  m, of a coordinate; residuals may show a larger one
/// @return  1e-12 m for exact points; never a reflection
/// @error  kTooFewPoints; kPointsOnLine (narrower than 10 % of their length)
Calibrated<TableFrame> table_frame(std::span<const TouchedPoint> points, double sigma_least = 0);

/// The frame of a table that probably is level: its z along `up` with a standard deviation of 1
/// deg. Touches then tell more of the rest. Unchanged where they show that it is not level (1 %),
/// or more than 3 deg of tilt.
/// @param points  that it was measured with
/// @param up      unit vector, in B
TableFrame levelled(TableFrame frame, std::span<const TouchedPoint> points, const Vec3& up);

/// m, what X_BW * p_W is off by with a probability of 95 %. Contains that sigma was estimated from
/// few points, so 3 touches give a wide bound. Errors that all touches share (the tool's length)
/// are not seen.
double error_95(const TableFrame& frame, const Vec3& p_W);

/// The frame's accuracy with one more point touched; only covariance and freedom change.
TableFrame with_touch(TableFrame frame, const Vec3& p_W);

/// A point that does not fit the others.
struct WrongTouch {
  std::size_t point = 0;
  Vec3 off_B;             ///< m, from where the others expect it to where it was touched
  double rms_others = 0;  ///< m, of the others without it
};

/// The point that is wrong where one is: the others fit so much better without it that chance
/// explains it in less than 2 % of all cases. Nothing for 3 points.
std::optional<WrongTouch> wrong_touch(std::span<const TouchedPoint> points);

/// Two points whose exchange makes the rms a quarter or less: touched in the wrong order.
std::optional<std::pair<std::size_t, std::size_t>> exchanged(std::span<const TouchedPoint> points);

}  // namespace sinew::calibration
