#include "sinew/calibration/intrinsics.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <utility>

#include "sinew/calibration/homography.h"
#include "sinew/calibration/least_squares.h"
#include "sinew/core/assert.h"

namespace sinew::calibration {
namespace {

constexpr std::size_t kViewsMin = 4;

/// Which parameters of the camera are estimated; the others stay as they are.
using CameraMask = std::array<bool, kCameraParameters>;
constexpr CameraMask kNoLens{true, true, true, true};
constexpr CameraMask kPlainLens{true, true, true, true, true, true};
constexpr CameraMask kLensAlone{false, false, false, false, true, true};

struct CameraState {
  vision::CameraModel camera;
  std::vector<PoseCB> X_CB;
};

struct CameraProblem {
  using State = CameraState;
  std::span<const BoardView> views;
  CameraMask mask{};

  std::size_t points() const {
    std::size_t count = 0;
    for (const BoardView& view : views) count += view.seen.pixels.size();
    return count;
  }
  Eigen::Index size() const { return kCameraParameters + 6 * std::ssize(views); }
  Eigen::Index free_parameters() const {
    return size() - std::count(mask.begin(), mask.end(), false);
  }
  State moved(const State& from, const Eigen::VectorXd& step) const {
    State to = from;
    to.camera = with_parameters(
        from.camera, parameters_of(from.camera) + CameraVector(step.head<kCameraParameters>()));
    for (std::size_t v = 0; v < views.size(); ++v) {
      to.X_CB[v] = calibration::moved(from.X_CB[v], Vector6(step.segment<6>(first_of(v))));
    }
    return to;
  }
  bool add_to(NormalEquations& sum, const State& state) const {
    std::size_t index = 0;
    PairRows J(2, kCameraParameters + 6);
    for (std::size_t v = 0; v < views.size(); ++v) {
      const vision::BoardCorners& seen = views[v].seen;
      for (std::size_t i = 0; i < seen.pixels.size(); ++i) {
        const Vec3 arm = state.X_CB[v].R * seen.points_B[i];
        auto there = projection(state.camera, arm + state.X_CB[v].p);
        if (!there) return false;
        for (std::size_t k = 0; k < mask.size(); ++k) {
          if (!mask[k]) there->by_camera.col(static_cast<Eigen::Index>(k)).setZero();
        }
        J << there->by_camera, -there->by_point * cross_matrix(arm), there->by_point;
        const Eigen::Vector2d pixel(seen.pixels[i].x, seen.pixels[i].y);
        sum.add_point(index++, there->pixel - pixel, J, {{0, kCameraParameters}, {first_of(v), 6}});
      }
    }
    return true;
  }
  static Eigen::Index first_of(std::size_t view) {
    return kCameraParameters + 6 * static_cast<Eigen::Index>(view);
  }
};

using CameraFit = Fit<CameraProblem>;

std::optional<CalibrationError> unusable(std::span<const BoardView> views) {
  using enum CalibrationFault;
  if (views.size() < kViewsMin) {
    return CalibrationError{kTooFewViews, -1, static_cast<double>(views.size()),
                            static_cast<double>(kViewsMin), 0};
  }
  for (std::size_t v = 0; v < views.size(); ++v) {
    const BoardView& view = views[v];
    SINEW_ASSERT(view.seen.points_B.size() == view.seen.pixels.size());
    const auto outside = [&](vision::Pixel p) {
      return !(p.x >= 0 && p.y >= 0 && p.x <= view.width && p.y <= view.height);
    };
    const int index = static_cast<int>(v);
    if (view.width <= 0 || view.height <= 0 || view.width != views[0].width ||
        view.height != views[0].height ||
        std::any_of(view.seen.pixels.begin(), view.seen.pixels.end(), outside)) {
      return CalibrationError{kPictureSize, index, 0, 0, 0};
    }
    if (auto error = calibration::unusable(view.seen)) {
      error->index = index;
      return error;
    }
  }
  return std::nullopt;
}

/// From board to picture; the picture's middle is 0 and its width 1.
std::optional<Eigen::Matrix3d> centered_homography(const BoardView& view) {
  if (calibration::unusable(view.seen)) return std::nullopt;
  Points2 from;
  Points2 to;
  for (std::size_t i = 0; i < view.seen.pixels.size(); ++i) {
    from.emplace_back(view.seen.points_B[i].x, view.seen.points_B[i].y);
    to.emplace_back((view.seen.pixels[i].x - view.width / 2.0) / view.width,
                    (view.seen.pixels[i].y - view.height / 2.0) / view.width);
  }
  return homography(from, to);
}

/// The largest angle between two boards. rad
double tilt_range(const std::vector<PoseCB>& X_CB) {
  double largest = 0;
  for (const PoseCB& one : X_CB) {
    for (const PoseCB& other : X_CB) {
      const double sine = norm(cross(one.R.z, other.R.z));
      largest = std::max(largest, std::atan2(sine, std::abs(dot(one.R.z, other.R.z))));
    }
  }
  return largest;
}

/// Poses of the boards for a camera with square pixels and a centred, straight lens.
Calibrated<std::vector<PoseCB>> board_poses(std::span<const BoardView> views, double focal) {
  std::vector<PoseCB> X_CB;
  for (std::size_t v = 0; v < views.size(); ++v) {
    auto H = centered_homography(views[v]);
    if (!H) {
      const Extent extent = extent_of(views[v].seen.points_B);
      return std::unexpected(CalibrationError{CalibrationFault::kPointsOnLine, static_cast<int>(v),
                                              extent.across, extent.across, extent.along});
    }
    H->topRows<2>() *= views[v].width / focal;
    X_CB.push_back(pose_of_homography(*H));
  }
  return X_CB;
}

/// kViewsParallel where that explains why a fit failed, else `error`.
CalibrationError explained(std::span<const BoardView> views, const CalibrationError& error) {
  constexpr double kTiltMin = from_deg(15);
  // The views of a failed fit do not tell the focal length; an ordinary one is near enough.
  vision::CameraModel ordinary = rough_camera(views);
  ordinary.fx = ordinary.fy = ordinary.width;
  auto X_CB = board_poses(views, ordinary.fx);
  if (!X_CB) return error;
  const CameraProblem problem{views, kLensAlone};
  const CameraFit fit = robust_fit(problem, {ordinary, *std::move(X_CB)});
  const double tilts = tilt_range(fit.state.X_CB);
  if (tilts > kTiltMin) return error;
  return {CalibrationFault::kViewsParallel, -1, tilts, kTiltMin, 0};
}

/// Bayesian information criterion; the smaller one is better. Differences below 0.001 px do not
/// count.
double criterion(const CameraFit& fit, const CameraProblem& problem) {
  constexpr double kUnseen = 1e-3;  // px
  const auto used = std::count(fit.weights.used.begin(), fit.weights.used.end(), 1);
  const auto n = static_cast<double>(2 * used);
  return n * std::log(fit.cost / n + kUnseen * kUnseen) +
         static_cast<double>(problem.free_parameters()) * std::log(n);
}

/// Whether every corner of the picture has a direction that is seen there.
bool invertible(const vision::CameraModel& camera) {
  for (const double x : {0, camera.width}) {
    for (const double y : {0, camera.height}) {
      const auto seen = camera.project(camera.direction({x, y}));
      if (!seen || length(*seen - vision::Pixel{x, y}) > 0.01) return false;
    }
  }
  return true;
}

/// Adds lens coefficients while the points that `fit` keeps show them. Sets the problem's mask.
CameraFit with_lens(CameraProblem& problem, CameraFit fit) {
  constexpr std::array<CameraMask, 4> kSteps{
      {{true, true, true, true, true},
       kPlainLens,
       {true, true, true, true, false, false, true, true},
       {true, true, true, true, true, true, false, false, true}}};
  fit.state.camera.lens = {};
  problem.mask = kNoLens;
  CameraFit best = minimise(problem, fit.state, fit.weights);
  for (const CameraMask& step : kSteps) {
    CameraProblem larger = problem;
    for (std::size_t i = 0; i < step.size(); ++i) larger.mask[i] = problem.mask[i] || step[i];
    CameraFit next = minimise(larger, best.state, fit.weights);
    if (!next.converged || !invertible(next.state.camera)) continue;
    if (best.converged && criterion(next, larger) >= criterion(best, problem)) continue;
    best = std::move(next);
    problem.mask = larger.mask;
  }
  return best;
}

Intrinsics result_of(const CameraFit& fit, const CameraProblem& problem) {
  Intrinsics out;
  out.camera = fit.state.camera;
  out.X_CB = fit.state.X_CB;
  out.pixel_sigma = sigma_of(fit, problem.free_parameters());
  CameraProblem all = problem;
  all.mask.fill(true);
  NormalEquations sum(all.size(), fit.weights);
  all.add_to(sum, fit.state);
  constexpr std::array<double, 5> kOrdinaryLens{0.3, 0.2, 1e-3, 1e-3, 0.05};
  for (std::size_t i = 0; i < kOrdinaryLens.size(); ++i) {
    if (problem.mask[4 + i]) continue;
    const Eigen::VectorXd axis =
        Eigen::VectorXd::Unit(all.size(), 4 + static_cast<Eigen::Index>(i));
    sum.add_prior(0, out.pixel_sigma / kOrdinaryLens[i] * axis);
  }
  out.covariance = out.pixel_sigma * out.pixel_sigma *
                   sum.inverse().topLeftCorner<kCameraParameters, kCameraParameters>();
  out.sigma = out.covariance.diagonal().cwiseMax(0).cwiseSqrt();
  const std::vector<double> kept = kept_norms(fit);
  out.rms = rms(kept);
  out.error_95 = quantile(kept, 0.95);
  std::size_t index = 0;
  for (std::size_t v = 0; v < problem.views.size(); ++v) {
    for (std::size_t i = 0; i < problem.views[v].seen.pixels.size(); ++i, ++index) {
      if (fit.weights.used[index] == 0) out.wrong_points.push_back({v, i, fit.norms[index]});
    }
  }
  return out;
}

}  // namespace

vision::CameraModel rough_camera(std::span<const BoardView> views) {
  // Zhang's constraints on the columns of H = K [r1 r2 t], with K = diag(f, f, 1): r1 and r2 are
  // orthogonal, and equally long. Linear in 1 / f^2.
  double left = 0;
  double right = 0;
  for (const BoardView& view : views) {
    const auto H = centered_homography(view);
    if (!H) continue;
    const Eigen::Vector3d a = H->col(0);
    const Eigen::Vector3d b = H->col(1);
    const double weight = 1 / (a.squaredNorm() * b.squaredNorm());
    const double dots = a.head<2>().dot(b.head<2>());
    const double lengths = a.head<2>().squaredNorm() - b.head<2>().squaredNorm();
    left += weight * (dots * dots + lengths * lengths);
    right -= weight * (dots * a.z() * b.z() + lengths * (a.z() * a.z() - b.z() * b.z()));
  }
  constexpr double kShortest = 0.3;  // times the width
  constexpr double kLongest = 10;
  const double f = std::sqrt(left / right);
  const bool known = right > 0 && f > kShortest && f < kLongest;
  if (views.empty()) return {};
  const double width = views[0].width;
  const double px = known ? f * width : width;
  return {views[0].width, views[0].height, px, px, {width / 2, views[0].height / 2.0}, {}};
}

Calibrated<Intrinsics> intrinsics(std::span<const BoardView> views) {
  if (const auto error = unusable(views)) return std::unexpected(*error);
  const vision::CameraModel rough = rough_camera(views);
  auto X_CB = board_poses(views, rough.fx);
  if (!X_CB) return std::unexpected(X_CB.error());

  CameraProblem problem{views, kPlainLens};
  CameraFit fit = robust_fit(problem, {rough, *std::move(X_CB)});
  CalibrationError lost{CalibrationFault::kNotConverged, -1, kInfinity, 0.01 * rough.width, 0};
  if (!fit.norms.empty()) lost.measured = rms(kept_norms(fit));
  if (!fit.converged) return std::unexpected(explained(views, lost));
  // The lens decides which points are wrong, and these may decide about the lens.
  for (int round = 0; round < 2; ++round) {
    const std::vector<char> used = fit.weights.used;
    fit = fit_without_wrong_points(problem, with_lens(problem, std::move(fit)));
    if (fit.weights.used == used) break;
  }
  Intrinsics out = result_of(fit, problem);
  lost.measured = out.rms;
  if (!fit.converged || !(out.rms <= lost.limit)) return std::unexpected(explained(views, lost));
  constexpr double kUncertainMax = 0.02;
  const double uncertain = std::max(out.sigma[0] / out.camera.fx, out.sigma[1] / out.camera.fy);
  if (!(uncertain <= kUncertainMax)) {
    return std::unexpected(
        explained(views, {CalibrationFault::kFocalUncertain, -1, uncertain, kUncertainMax, 0}));
  }
  return out;
}

}  // namespace sinew::calibration
