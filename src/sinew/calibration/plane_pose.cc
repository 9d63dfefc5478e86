#include "sinew/calibration/plane_pose.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <utility>

#include "sinew/calibration/homography.h"
#include "sinew/calibration/least_squares.h"
#include "sinew/core/assert.h"

namespace sinew::calibration {
namespace {

constexpr std::size_t kPointsMin = 4;

struct PoseProblem {
  using State = PoseCB;
  const vision::CameraModel& camera;
  const vision::BoardCorners& seen;

  std::size_t points() const { return seen.pixels.size(); }
  Eigen::Index size() const { return 6; }
  State moved(const State& X, const Eigen::VectorXd& step) const {
    return calibration::moved(X, Vector6(step));
  }
  bool add_to(NormalEquations& sum, const State& X_CB) const {
    for (std::size_t i = 0; i < points(); ++i) {
      const Vec3 arm = X_CB.R * seen.points_B[i];
      const auto there = projection(camera, arm + X_CB.p);
      if (!there) return false;
      PairRows J(2, 6);
      J << -there->by_point * cross_matrix(arm), there->by_point;
      const Eigen::Vector2d pixel(seen.pixels[i].x, seen.pixels[i].y);
      sum.add_point(i, there->pixel - pixel, J, {{0, 6}});
    }
    return true;
  }
};

/// The pose that looks the same from far away: every axis mirrored along the line of sight to the
/// middle of the points, and turned so that it is a rotation again.
PoseCB mirrored(const PoseCB& X_CB, const std::vector<Vec3>& points_B) {
  Vec3 middle_B;
  for (const Vec3& p : points_B) middle_B = middle_B + p;
  middle_B = (1.0 / static_cast<double>(points_B.size())) * middle_B;
  const Vec3 middle_C = X_CB * middle_B;
  const Vec3 sight = normalized(middle_C);
  const auto mirror = [&](const Vec3& v) { return v - 2 * dot(v, sight) * sight; };
  const Rotation R{mirror(X_CB.R.x), mirror(X_CB.R.y), -mirror(X_CB.R.z)};
  return {R, middle_C - R * middle_B};
}

/// The better of the fits from a homography and, where that leads nowhere, from an affine map.
Fit<PoseProblem> first_fit(const PoseProblem& problem, double rms_max) {
  Points2 on_board;
  Points2 on_plane;
  for (std::size_t i = 0; i < problem.points(); ++i) {
    on_board.emplace_back(problem.seen.points_B[i].x, problem.seen.points_B[i].y);
    const Vec3 d = problem.camera.direction(problem.seen.pixels[i]);
    on_plane.emplace_back(d.x / d.z, d.y / d.z);
  }
  Fit<PoseProblem> best{{}, {0, std::vector<char>(problem.points(), 1)}, false, kInfinity, {}};
  for (const auto& map : {homography, affine_map}) {
    const auto H = map(on_board, on_plane);
    if (!H) continue;
    Fit<PoseProblem> fit = robust_fit(problem, pose_of_homography(*H));
    if (!fit.converged || !(fit.cost < best.cost)) continue;
    best = std::move(fit);
    if (rms(kept_norms(best)) < rms_max) break;
  }
  return best;
}

PlanePose result_of(const Fit<PoseProblem>& fit, const PoseProblem& problem, double sigma) {
  PlanePose out;
  out.X_CB = fit.state;
  out.sigma = std::max(sigma, sigma_of(fit, problem.size()));
  NormalEquations sum(problem.size(), fit.weights);
  problem.add_to(sum, fit.state);
  out.covariance = out.sigma * out.sigma * sum.inverse();
  out.rms = rms(kept_norms(fit));
  for (std::size_t i = 0; i < problem.points(); ++i) {
    if (fit.weights.used[i] == 0) out.wrong_points.push_back(i);
  }
  return out;
}

}  // namespace

std::optional<CalibrationError> unusable(const vision::BoardCorners& seen) {
  constexpr double kWidthMin = 0.05;  // times the length
  const std::size_t count = seen.points_B.size();
  if (count < kPointsMin) {
    return CalibrationError{CalibrationFault::kTooFewPoints, -1, static_cast<double>(count),
                            static_cast<double>(kPointsMin), 0};
  }
  const Extent extent = extent_of(seen.points_B);
  if (extent.across < kWidthMin * extent.along || extent.along == 0) {
    return CalibrationError{CalibrationFault::kPointsOnLine, -1, extent.across,
                            kWidthMin * extent.along, extent.along};
  }
  return std::nullopt;
}

Calibrated<PlanePose> plane_pose(const vision::CameraModel& camera,
                                 const vision::BoardCorners& seen, double sigma) {
  SINEW_ASSERT(seen.points_B.size() == seen.pixels.size());
  if (const auto error = unusable(seen)) return std::unexpected(*error);
  CalibrationError lost{CalibrationFault::kNotConverged, -1, kInfinity, 0.01 * camera.width, 0};
  const PoseProblem problem{camera, seen};
  Fit<PoseProblem> best = first_fit(problem, lost.limit);
  if (!best.converged) return std::unexpected(lost);
  Fit<PoseProblem> second =
      minimise(problem, mirrored(best.state, seen.points_B), {0, best.weights.used});
  if (second.converged && second.cost < best.cost) {
    std::swap(best, second);
    best = fit_without_wrong_points(problem, std::move(best));
  }
  lost.measured = rms(kept_norms(best));
  if (!best.converged || !(lost.measured <= lost.limit)) return std::unexpected(lost);

  PlanePose out = result_of(best, problem, sigma);
  constexpr double kSame = 1e-3;   // rad
  constexpr double kExact = 1e-9;  // px
  if (second.converged && angle_between(second.state.R, best.state.R) > kSame) {
    out.other = second.state;
    out.ambiguity = std::max(1.0, rms(kept_norms(second)) / std::max(out.rms, kExact));
  }
  return out;
}

std::optional<Vec3> ray_to_plane(const vision::CameraModel& camera, const PoseWC& X_WC,
                                 vision::Pixel pixel, double height) {
  const Vec3 ray = X_WC.R * camera.direction(pixel);
  if (std::abs(ray.z) < 1e-6) return std::nullopt;
  const double length = (height - X_WC.p.z) / ray.z;
  if (!(length > 0)) return std::nullopt;
  Vec3 p_W = X_WC.p + length * ray;
  p_W.z = height;
  return p_W;
}

Eigen::Matrix2d table_covariance(const vision::CameraModel& camera, const PoseWC& X_WC,
                                 vision::Pixel pixel, double height,
                                 const CameraUncertainty& uncertainty) {
  const auto p_W = ray_to_plane(camera, X_WC, pixel, height);
  SINEW_ASSERT(p_W.has_value());
  const Vec3 arm = *p_W - X_WC.p;
  const auto there = projection(camera, transposed_times(X_WC.R, arm));
  SINEW_ASSERT(there.has_value());
  // The pixel stays where it is: 0 = by_W dp_W + by_pose dX_WC + by_camera dK - dpixel.
  const Eigen::Matrix<double, 2, 3> by_W = there->by_point * to_eigen(X_WC.R).transpose();
  Eigen::Matrix<double, 2, 6> by_pose;
  by_pose << by_W * cross_matrix(arm), -by_W;
  const Eigen::Matrix2d inverse = by_W.leftCols<2>().inverse();
  const Eigen::Matrix2d of_pixel =
      uncertainty.pixel * uncertainty.pixel * Eigen::Matrix2d::Identity() +
      by_pose * uncertainty.pose * by_pose.transpose() +
      there->by_camera * uncertainty.camera * there->by_camera.transpose();
  return inverse * of_pixel * inverse.transpose();
}

}  // namespace sinew::calibration
