#pragma once

#include <Eigen/Core>
#include <span>
#include <vector>

#include "sinew/core/pose.h"
#include "sinew/core/units.h"

namespace sinew::calibration {

using Vector6 = Eigen::Matrix<double, 6, 1>;
using Matrix6 = Eigen::Matrix<double, 6, 6>;

inline Eigen::Vector3d to_eigen(const Vec3& v) {
  return {v.x, v.y, v.z};
}
inline Vec3 to_vec3(const Eigen::Vector3d& v) {
  return {v.x(), v.y(), v.z()};
}
inline Eigen::Matrix3d to_eigen(const Rotation& R) {
  Eigen::Matrix3d M;
  M << R.x.x, R.y.x, R.z.x, R.x.y, R.y.y, R.z.y, R.x.z, R.y.z, R.z.z;
  return M;
}
/// [v]x, with [v]x u = v x u.
inline Eigen::Matrix3d cross_matrix(const Vec3& v) {
  Eigen::Matrix3d M;
  M << 0, -v.z, v.y, v.z, 0, -v.x, -v.y, v.x, 0;
  return M;
}

/// The rotation nearest to M in the least-squares sense; never a reflection.
Rotation nearest_rotation(const Eigen::Matrix3d& M);

/// X_AB after a small step: rotated by step[0..2] (rad, axes of A) about B's origin and shifted by
/// step[3..5] (m, in A). Every pose covariance in this folder has these six parameters.
template <class A, class B>
Pose<A, B> moved(const Pose<A, B>& X_AB, const Vector6& step) {
  return {rotation_from_vector(to_vec3(step.head<3>())) * X_AB.R, X_AB.p + to_vec3(step.tail<3>())};
}

/// The step with moved(from, step) = to.
template <class A, class B>
Vector6 step_between(const Pose<A, B>& from, const Pose<A, B>& to) {
  Vector6 step;
  step << to_eigen(rotation_vector(to.R * from.R.transposed())), to_eigen(to.p - from.p);
  return step;
}

/// Covariance of X_BA, from that of X_AB.
template <class A, class B>
Matrix6 inverse_covariance(const Pose<A, B>& X_AB, const Matrix6& covariance) {
  const Eigen::Matrix3d R_BA = to_eigen(X_AB.R.transposed());
  Matrix6 map = Matrix6::Zero();
  map.topLeftCorner<3, 3>() = -R_BA;
  map.bottomLeftCorner<3, 3>() = -R_BA * cross_matrix(X_AB.p);
  map.bottomRightCorner<3, 3>() = -R_BA;
  return map * covariance * map.transpose();
}

/// How far points reach along the line that fits them best, and across it. m
struct Extent {
  double along = 0;
  double across = 0;
};
Extent extent_of(std::span<const Vec3> points);

/// The value that a share of all values does not exceed (nearest rank); 0 for no values. With
/// fewer than 20 values, 0.95 gives the largest one.
double quantile(std::vector<double> values, double share);

/// sqrt(mean of squares); 0 for no values.
double rms(std::span<const double> values);

}  // namespace sinew::calibration
