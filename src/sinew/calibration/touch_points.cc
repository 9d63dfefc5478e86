#include "sinew/calibration/touch_points.h"

#include <algorithm>
#include <cmath>

#include "sinew/calibration/geometry.h"

namespace sinew::calibration {
namespace {

constexpr std::size_t kPointsMin = 3;

using PoseBW = Pose<frame::Base, frame::World>;

PoseBW kabsch(std::span<const TouchedPoint> points) {
  Vec3 mean_B;
  Vec3 mean_W;
  for (const TouchedPoint& point : points) {
    mean_B = mean_B + point.p_B;
    mean_W = mean_W + point.p_W;
  }
  mean_B = (1.0 / static_cast<double>(points.size())) * mean_B;
  mean_W = (1.0 / static_cast<double>(points.size())) * mean_W;
  Eigen::Matrix3d sum = Eigen::Matrix3d::Zero();
  for (const TouchedPoint& point : points) {
    sum += to_eigen(point.p_B - mean_B) * to_eigen(point.p_W - mean_W).transpose();
  }
  const Rotation R = nearest_rotation(sum);
  return {R, mean_B - R * mean_W};
}

double error_of(const PoseBW& X_BW, const TouchedPoint& point) {
  return norm(X_BW * point.p_W - point.p_B);
}

std::vector<double> errors_of(const PoseBW& X_BW, std::span<const TouchedPoint> points) {
  std::vector<double> errors;
  for (const TouchedPoint& point : points) errors.push_back(error_of(X_BW, point));
  return errors;
}

/// Fills `worst` and `error_95` from fits that leave one point out each.
void leave_one_out(std::span<const TouchedPoint> points, TableFrame& out) {
  std::vector<double> left_out;
  double least = kInfinity;
  for (std::size_t i = 0; i < points.size(); ++i) {
    std::vector<TouchedPoint> others(points.begin(), points.end());
    others.erase(others.begin() + static_cast<std::ptrdiff_t>(i));
    const PoseBW X_BW = kabsch(others);
    left_out.push_back(error_of(X_BW, points[i]));
    const double rest = rms(errors_of(X_BW, others));
    if (rest >= least) continue;
    least = rest;
    out.worst = i;
  }
  constexpr double kRmsTo95 = 1.614;  // of the length of a vector with three normal coordinates
  out.error_95 = std::max(quantile(left_out, 0.95), kRmsTo95 * rms(left_out));
}

}  // namespace

Calibrated<TableFrame> table_frame(std::span<const TouchedPoint> points) {
  using enum CalibrationFault;
  if (points.size() < kPointsMin) {
    return std::unexpected(CalibrationError{kTooFewPoints, -1, static_cast<double>(points.size()),
                                            static_cast<double>(kPointsMin), 0});
  }
  std::vector<Vec3> touched;
  std::vector<Vec3> seen;
  for (const TouchedPoint& point : points) {
    touched.push_back(point.p_B);
    seen.push_back(point.p_W);
  }
  constexpr double kWidthMin = 0.1;  // times the length
  for (const Extent& extent : {extent_of(touched), extent_of(seen)}) {
    if (extent.across >= kWidthMin * extent.along && extent.along > 0) continue;
    return std::unexpected(
        CalibrationError{kPointsOnLine, -1, extent.across, kWidthMin * extent.along, extent.along});
  }
  TableFrame out;
  out.X_BW = kabsch(points);
  out.residuals = errors_of(out.X_BW, points);
  out.rms = rms(out.residuals);
  out.worst = static_cast<std::size_t>(
      std::max_element(out.residuals.begin(), out.residuals.end()) - out.residuals.begin());
  if (points.size() > kPointsMin) leave_one_out(points, out);
  return out;
}

}  // namespace sinew::calibration
