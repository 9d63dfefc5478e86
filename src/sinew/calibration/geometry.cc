#include "sinew/calibration/geometry.h"

#include <Eigen/Eigenvalues>
#include <Eigen/SVD>
#include <algorithm>
#include <cmath>

namespace sinew::calibration {

Rotation nearest_rotation(const Eigen::Matrix3d& M) {
  const Eigen::JacobiSVD<Eigen::Matrix3d> svd(M, Eigen::ComputeFullU | Eigen::ComputeFullV);
  Eigen::Vector3d signs(1, 1, 1);
  signs.z() = svd.matrixU().determinant() * svd.matrixV().determinant() < 0 ? -1 : 1;
  const Eigen::Matrix3d R = svd.matrixU() * signs.asDiagonal() * svd.matrixV().transpose();
  return {to_vec3(R.col(0)), to_vec3(R.col(1)), to_vec3(R.col(2))};
}

Extent extent_of(std::span<const Vec3> points) {
  if (points.empty()) return {};
  Vec3 mean;
  for (const Vec3& p : points) mean = mean + p;
  mean = (1.0 / static_cast<double>(points.size())) * mean;
  Eigen::Matrix3d scatter = Eigen::Matrix3d::Zero();
  for (const Vec3& p : points) {
    scatter += to_eigen(p - mean) * to_eigen(p - mean).transpose();
  }
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> axes(scatter);
  const auto reach = [&](int axis) {
    double lowest = 0;
    double highest = 0;
    for (const Vec3& p : points) {
      const double at = axes.eigenvectors().col(axis).dot(to_eigen(p - mean));
      lowest = std::min(lowest, at);
      highest = std::max(highest, at);
    }
    return highest - lowest;
  };
  return {.along = reach(2), .across = reach(1)};
}

double quantile(std::vector<double> values, double share) {
  if (values.empty()) return 0;
  const auto count = static_cast<double>(values.size());
  const auto rank = static_cast<std::ptrdiff_t>(std::ceil(share * count));
  const auto at = std::clamp<std::ptrdiff_t>(rank - 1, 0, std::ssize(values) - 1);
  std::nth_element(values.begin(), values.begin() + at, values.end());
  return values[static_cast<std::size_t>(at)];
}

double rms(std::span<const double> values) {
  double sum = 0;
  for (const double value : values) sum += value * value;
  return values.empty() ? 0 : std::sqrt(sum / static_cast<double>(values.size()));
}

}  // namespace sinew::calibration
