#include "sinew/calibration/homography.h"

#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <span>

#include "sinew/calibration/geometry.h"
#include "sinew/core/split_mix.h"

namespace sinew::calibration {
namespace {

using Chosen = std::vector<std::size_t>;

/// Moves the middle of points to 0 and their mean distance from it to sqrt(2).
Eigen::Matrix3d normalising(const Points2& points, const Chosen& chosen) {
  Eigen::Vector2d mean(0, 0);
  for (const std::size_t i : chosen) mean += points[i];
  mean /= static_cast<double>(chosen.size());
  double distance = 0;
  for (const std::size_t i : chosen) distance += (points[i] - mean).norm();
  const double scale = std::numbers::sqrt2 * static_cast<double>(chosen.size()) / distance;
  Eigen::Matrix3d T;
  T << scale, 0, -scale * mean.x(), 0, scale, -scale * mean.y(), 0, 0, 1;
  return T;
}

/// Direct linear transformation of the chosen pairs.
std::optional<Eigen::Matrix3d> linear(const Points2& from, const Points2& to,
                                      const Chosen& chosen) {
  using Row = Eigen::Matrix<double, 9, 1>;
  const Eigen::Matrix3d T_from = normalising(from, chosen);
  const Eigen::Matrix3d T_to = normalising(to, chosen);
  if (!T_from.allFinite() || !T_to.allFinite()) return std::nullopt;
  Eigen::Matrix<double, 9, 9> sum = Eigen::Matrix<double, 9, 9>::Zero();
  for (const std::size_t i : chosen) {
    const Eigen::Vector3d p = T_from * from[i].homogeneous();
    const Eigen::Vector3d q = T_to * to[i].homogeneous();
    Row a;
    Row b;
    a << p, Eigen::Vector3d::Zero(), -q.x() * p;
    b << Eigen::Vector3d::Zero(), p, -q.y() * p;
    sum += a * a.transpose() + b * b.transpose();
  }
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix<double, 9, 9>> solved(sum);
  if (solved.eigenvalues()[1] < 1e-9 * solved.eigenvalues()[8]) return std::nullopt;
  const Row h = solved.eigenvectors().col(0);
  Eigen::Matrix3d H;
  H << h[0], h[1], h[2], h[3], h[4], h[5], h[6], h[7], h[8];
  H = (T_to.inverse() * H * T_from).eval();
  return H / H.norm();
}

std::vector<double> errors_of(const Eigen::Matrix3d& H, const Points2& from, const Points2& to) {
  std::vector<double> errors(from.size());
  for (std::size_t i = 0; i < from.size(); ++i) {
    errors[i] = ((H * from[i].homogeneous()).hnormalized() - to[i]).norm();
  }
  return errors;
}

Chosen all_of(std::size_t count) {
  Chosen all(count);
  for (std::size_t i = 0; i < count; ++i) all[i] = i;
  return all;
}

/// Of random quadruples, the homography with the smallest median error.
Eigen::Matrix3d least_median(const Points2& from, const Points2& to, Eigen::Matrix3d best) {
  constexpr int kDraws = 100;
  SplitMix64 random(1);
  double least = quantile(errors_of(best, from, to), 0.5);
  Chosen order = all_of(from.size());
  for (int draw = 0; draw < kDraws; ++draw) {
    for (std::size_t i = 0; i < 4; ++i) {
      std::swap(order[i], order[i + random.bits() % (order.size() - i)]);
    }
    const auto H = linear(from, to, {order.begin(), order.begin() + 4});
    if (!H) continue;
    const double median = quantile(errors_of(*H, from, to), 0.5);
    if (!(median < least)) continue;
    least = median;
    best = *H;
  }
  return best;
}

}  // namespace

std::optional<Eigen::Matrix3d> homography(const Points2& from, const Points2& to) {
  constexpr std::size_t kRedundant = 8;  // points from which a wrong one can be told
  constexpr double kSuspicious = 5;      // times the median
  constexpr double kWrong = 4;           // times the least median
  const auto H = linear(from, to, all_of(from.size()));
  if (!H || from.size() < kRedundant) return H;
  const std::vector<double> errors = errors_of(*H, from, to);
  if (quantile(errors, 1) <= kSuspicious * quantile(errors, 0.5)) return H;
  const std::vector<double> strict = errors_of(least_median(from, to, *H), from, to);
  const double limit = kWrong * quantile(strict, 0.5);
  Chosen right;
  for (std::size_t i = 0; i < strict.size(); ++i) {
    if (strict[i] <= limit) right.push_back(i);
  }
  const auto refined = linear(from, to, right);
  return refined ? refined : H;
}

std::optional<Eigen::Matrix3d> affine_map(const Points2& from, const Points2& to) {
  Eigen::Matrix3d left = Eigen::Matrix3d::Zero();
  Eigen::Matrix3d right = Eigen::Matrix3d::Zero();
  for (std::size_t i = 0; i < from.size(); ++i) {
    const Eigen::Vector3d p = from[i].homogeneous();
    const Eigen::Vector3d q = to[i].homogeneous();
    left += p * p.transpose();
    right += q * p.transpose();
  }
  const Eigen::FullPivLU<Eigen::Matrix3d> lu(left);
  if (!lu.isInvertible()) return std::nullopt;
  Eigen::Matrix3d H = right * lu.inverse();
  H.row(2) << 0, 0, 1;
  return H;
}

Pose<frame::Camera, frame::Board> pose_of_homography(const Eigen::Matrix3d& H) {
  // H ~ [x y p]: the board's axes have length 1, and the board is in front of the lens.
  const double scale = std::sqrt(H.col(0).norm() * H.col(1).norm()) * (H(2, 2) < 0 ? -1 : 1);
  Eigen::Matrix3d M = H / scale;
  const Vec3 p = to_vec3(M.col(2));
  M.col(2) = M.col(0).cross(M.col(1)).eval();
  return {nearest_rotation(M), p};
}

}  // namespace sinew::calibration
