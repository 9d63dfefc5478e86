#include "sinew/calibration/touch_points.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "sinew/calibration/f_distribution.h"
#include "sinew/core/units.h"

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

std::vector<TouchedPoint> without(std::span<const TouchedPoint> points, std::size_t point) {
  std::vector<TouchedPoint> others(points.begin(), points.end());
  others.erase(others.begin() + static_cast<std::ptrdiff_t>(point));
  return others;
}

double sum_of_squares(std::span<const TouchedPoint> points) {
  double sum = 0;
  for (const double error : errors_of(kabsch(points), points)) sum += error * error;
  return sum;
}

/// The point without which the others fit best.
std::size_t worst_of(std::span<const TouchedPoint> points) {
  double least = kInfinity;
  std::size_t worst = 0;
  for (std::size_t i = 0; i < points.size(); ++i) {
    const double rest = sum_of_squares(without(points, i));
    if (rest >= least) continue;
    least = rest;
    worst = i;
  }
  return worst;
}

/// d (X_BW * p_W) by the step of moved().
Eigen::Matrix<double, 3, 6> by_step(const PoseBW& X_BW, const Vec3& p_W) {
  Eigen::Matrix<double, 3, 6> J;
  J << -cross_matrix(X_BW.R * p_W), Eigen::Matrix3d::Identity();
  return J;
}

/// Fills sigma, freedom, covariance and scale.
void estimate_errors(std::span<const TouchedPoint> points, double sigma_least, TableFrame& out) {
  Matrix6 information = Matrix6::Zero();
  Vec3 middle_W;
  for (const TouchedPoint& point : points) {
    const auto J = by_step(out.X_BW, point.p_W);
    information += J.transpose() * J;
    middle_W = middle_W + (1.0 / static_cast<double>(points.size())) * point.p_W;
  }
  double squares = 0;
  double along = 0;
  double length = 0;
  for (std::size_t i = 0; i < points.size(); ++i) {
    squares += out.residuals[i] * out.residuals[i];
    const Vec3 arm = out.X_BW.R * (points[i].p_W - middle_W);
    along += dot(arm, points[i].p_B - out.X_BW * points[i].p_W);
    length += dot(arm, arm);
  }
  out.freedom = 3.0 * static_cast<double>(points.size()) - 6;
  out.sigma = std::max(sigma_least, std::sqrt(squares / out.freedom));
  out.covariance = out.sigma * out.sigma * information.inverse();
  out.scale = 1 + along / length;
  // The part of the residuals that a scale explains is no error of touching.
  const double rest = std::max(0.0, squares - along * along / length) / (out.freedom - 1);
  out.scale_sigma = std::max(sigma_least, std::sqrt(rest)) / std::sqrt(length);
}

}  // namespace

Calibrated<TableFrame> table_frame(std::span<const TouchedPoint> points, double sigma_least) {
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
  if (points.size() > kPointsMin) out.worst = worst_of(points);
  estimate_errors(points, sigma_least, out);
  return out;
}

TableFrame levelled(TableFrame frame, std::span<const TouchedPoint> points, const Vec3& up) {
  constexpr double kSigma = 1 * kPi / 180;
  constexpr double kMost = 3 * kPi / 180;
  constexpr double kChance = 0.01;
  if (!(frame.sigma > 0)) return frame;
  // About the two axes across `up`, by which the table would be level.
  const Eigen::Vector3d z = to_eigen(up);
  const Eigen::Matrix3d across = Eigen::Matrix3d::Identity() - z * z.transpose();
  const Eigen::Vector3d tilt = across * to_eigen(cross(frame.X_BW.R.z, up));
  const Eigen::Matrix3d known = frame.covariance.topLeftCorner<3, 3>();
  const Eigen::Matrix3d spread =
      across * known * across + kSigma * kSigma * across + z * z.transpose();
  const double square = tilt.dot(spread.inverse() * tilt) / 2;
  const bool is_tilted = tilt.norm() > kMost || square > f_quantile(1 - kChance, 2, frame.freedom);
  if (is_tilted) return frame;
  Matrix6 information = frame.covariance.inverse();
  Vector6 pull = Vector6::Zero();
  information.topLeftCorner<3, 3>() += across / (kSigma * kSigma);
  pull.head<3>() = tilt / (kSigma * kSigma);
  frame.covariance = information.inverse();
  frame.X_BW = moved(frame.X_BW, Vector6(frame.covariance * pull));
  frame.residuals = errors_of(frame.X_BW, points);
  frame.rms = rms(frame.residuals);
  frame.freedom += 2;
  // A tilt that was levelled away shows in what is left.
  double squares = 0;
  for (const double off : frame.residuals) squares += off * off;
  const double sigma = std::max(frame.sigma, std::sqrt(squares / frame.freedom));
  frame.covariance *= sigma * sigma / (frame.sigma * frame.sigma);
  frame.sigma = sigma;
  return frame;
}

double error_95(const TableFrame& frame, const Vec3& p_W) {
  const auto J = by_step(frame.X_BW, p_W);
  const Eigen::Matrix3d C = J * frame.covariance * J.transpose();
  const double variance = C.trace();
  if (!(variance > 0)) return 0;
  // Length of an error with unequal axes, as one with equal axes of the same mean and spread.
  const double axes = variance * variance / (C * C).trace();
  return std::sqrt(variance * f_quantile(0.95, axes, frame.freedom));
}

TableFrame with_touch(TableFrame frame, const Vec3& p_W) {
  const auto J = by_step(frame.X_BW, p_W);
  // An exact frame has no covariance to improve.
  if (frame.sigma > 0) {
    const Matrix6 information = frame.covariance.inverse();
    frame.covariance = (information + J.transpose() * J / (frame.sigma * frame.sigma)).inverse();
  }
  frame.freedom += 3;
  return frame;
}

std::optional<WrongTouch> wrong_touch(std::span<const TouchedPoint> points) {
  constexpr double kChance = 0.02;
  if (points.size() <= kPointsMin) return std::nullopt;
  const std::size_t worst = worst_of(points);
  const std::vector<TouchedPoint> others = without(points, worst);
  const double rest = sum_of_squares(others);
  const double freedom = 3.0 * static_cast<double>(others.size()) - 6;
  const double ratio = (sum_of_squares(points) - rest) / 3 / (rest / freedom);
  // Any of them might have been the worst one.
  const double share = 1 - kChance / static_cast<double>(points.size());
  if (!(ratio > f_quantile(share, 3, freedom))) return std::nullopt;
  const PoseBW X_BW = kabsch(others);
  return WrongTouch{worst, points[worst].p_B - X_BW * points[worst].p_W,
                    rms(errors_of(X_BW, others))};
}

std::optional<std::pair<std::size_t, std::size_t>> exchanged(std::span<const TouchedPoint> points) {
  constexpr double kBetter = 1.0 / 16;  // of the sum of squares
  double least = kBetter * sum_of_squares(points);
  std::optional<std::pair<std::size_t, std::size_t>> found;
  for (std::size_t i = 0; i < points.size(); ++i) {
    for (std::size_t j = i + 1; j < points.size(); ++j) {
      std::vector<TouchedPoint> other(points.begin(), points.end());
      std::swap(other[i].p_W, other[j].p_W);
      const double sum = sum_of_squares(other);
      if (sum >= least) continue;
      least = sum;
      found = {i, j};
    }
  }
  return found;
}

}  // namespace sinew::calibration
