#include "sinew/calibration/hand_eye.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <utility>

#include "sinew/calibration/f_distribution.h"
#include "sinew/calibration/hand_eye_start.h"
#include "sinew/calibration/least_squares.h"
#include "sinew/core/assert.h"

namespace sinew::calibration {
namespace {

constexpr std::size_t kViewsMin = 3;

using PoseBF = Pose<frame::Base, frame::Flange>;
using Eigen::Index;
using OffsetRows = Eigen::Matrix<double, 3, Eigen::Dynamic>;

struct MountState {
  PoseMC X_MC;
  PoseNB X_NB;
  Eigen::VectorXd offsets;  // rad, by joint; empty where zeros are exact
  double size = 1;          // of the board
};

OffsetRows rows_of(const std::array<Vec3, kMaxJoints>& columns, Index count) {
  OffsetRows rows(3, count);
  for (Index i = 0; i < count; ++i) rows.col(i) = to_eigen(columns[static_cast<std::size_t>(i)]);
  return rows;
}

/// The flange with its joints turned by `offsets`, to first order of the arm.
PoseBF offset_pose(const HandEyeView& view, const Eigen::VectorXd& offsets) {
  if (offsets.size() == 0) return view.X_BF;
  const Vec3 w = to_vec3(rows_of(view.jacobian->w, offsets.size()) * offsets);
  const Vec3 v = to_vec3(rows_of(view.jacobian->v, offsets.size()) * offsets);
  return {rotation_from_vector(w) * view.X_BF.R, view.X_BF.p + v};
}

/// d p_M / d offsets of a point that the board's mount carries.
OffsetRows by_offsets(const HandEyeView& view, CameraMounting mounting, const PoseBF& X_BF,
                      const Eigen::VectorXd& offsets, const ChainPoint& at) {
  OffsetRows w = rows_of(view.jacobian->w, offsets.size());
  const OffsetRows v = rows_of(view.jacobian->v, offsets.size());
  // Derivative of the exponential map, to second order.
  const Eigen::Matrix3d turn = cross_matrix(to_vec3(w * offsets));
  w = ((Eigen::Matrix3d::Identity() + turn / 2 + turn * turn / 6) * w).eval();
  if (mounting == CameraMounting::kFixed) return v - cross_matrix(X_BF.R * at.p_N) * w;
  return to_eigen(X_BF.R.transposed()) * (cross_matrix(at.p_N - X_BF.p) * w - v);
}

struct MountProblem {
  using State = MountState;
  const vision::CameraModel& camera;
  std::span<const HandEyeView> views;
  const HandEyeSettings& settings;
  Index joints = 0;          // with an offset
  Index sizes = 0;           // 1 where the board's size is estimated
  double pixel_sigma = 0.3;  // px; weighs pixels against what is known besides

  std::size_t points() const {
    std::size_t count = 0;
    for (const HandEyeView& view : views) count += view.seen.pixels.size();
    return count;
  }
  Index extra() const { return joints + sizes; }
  Index size() const { return kMountParameters + extra(); }
  bool has_priors() const { return extra() > 0 || !settings.known_points.empty(); }

  State moved(const State& from, const Eigen::VectorXd& step) const {
    return {calibration::moved(from.X_MC, Vector6(step.head<6>())),
            calibration::moved(from.X_NB, Vector6(step.segment<6>(6))),
            from.offsets + step.segment(kMountParameters, joints),
            from.size + (sizes > 0 ? step[size() - 1] : 0)};
  }

  bool add_to(NormalEquations& sum, const State& state) const {
    add_known_points(sum, state.X_NB);
    add_priors(sum, state);
    return add_pixels(sum, state);
  }

  bool add_pixels(NormalEquations& sum, const State& state) const {
    std::size_t index = 0;
    PairRows J(2, size());
    for (const HandEyeView& view : views) {
      const PoseBF X_BF = offset_pose(view, state.offsets);
      const PoseMN X_MN = between_mounts(settings.mounting, X_BF);
      for (std::size_t i = 0; i < view.seen.pixels.size(); ++i) {
        const ChainPoint at =
            chain_point(state.X_MC, X_MN, state.X_NB, state.size * view.seen.points_B[i]);
        const auto there = projection(camera, at.p_C);
        if (!there) return false;
        J.leftCols<kMountParameters>() = there->by_point * at.by_mounts;
        if (joints > 0) {
          J.middleCols(kMountParameters, joints) =
              there->by_point * to_eigen(state.X_MC.R.transposed()) *
              by_offsets(view, settings.mounting, X_BF, state.offsets, at);
        }
        if (sizes > 0) {
          const Vec3 arm_M = X_MN.R * (state.X_NB.R * view.seen.points_B[i]);
          J.rightCols<1>() = there->by_point * to_eigen(transposed_times(state.X_MC.R, arm_M));
        }
        const Eigen::Vector2d pixel(view.seen.pixels[i].x, view.seen.pixels[i].y);
        sum.add_point(index++, there->pixel - pixel, J, {{0, size()}});
      }
    }
    return true;
  }

  void add_known_points(NormalEquations& sum, const PoseNB& X_NB) const {
    for (const KnownPoint& known : settings.known_points) {
      const Vec3 arm = X_NB.R * known.p_B;
      const Eigen::Vector3d off = to_eigen(arm + X_NB.p - known.p_N);
      const double weight = pixel_sigma / known.sigma;
      OffsetRows rows = OffsetRows::Zero(3, size());
      rows.middleCols<3>(6) = -cross_matrix(arm);
      rows.middleCols<3>(9).setIdentity();
      for (Index k = 0; k < 3; ++k) {
        sum.add_prior(weight * off[k], weight * rows.row(k).transpose());
      }
    }
  }

  void add_priors(NormalEquations& sum, const State& state) const {
    for (Index j = 0; j < joints; ++j) {
      const double weight = pixel_sigma / settings.joint_offset_sigma;
      const Eigen::VectorXd row = weight * Eigen::VectorXd::Unit(size(), kMountParameters + j);
      sum.add_prior(weight * state.offsets[j], row);
    }
    if (sizes == 0) return;
    const double weight = pixel_sigma / settings.size_sigma;
    sum.add_prior(weight * (state.size - 1), weight * Eigen::VectorXd::Unit(size(), size() - 1));
  }
};

using MountFit = Fit<MountProblem>;

/// Number of joints whose zeros are estimated.
Index offset_joints(std::span<const HandEyeView> views, const HandEyeSettings& settings) {
  if (!(settings.joint_offset_sigma > 0)) return 0;
  std::size_t joints = kMaxJoints;
  for (const HandEyeView& view : views) {
    joints = std::min(joints, view.jacobian ? view.jacobian->size : 0);
  }
  return static_cast<Index>(joints);
}

Calibrated<std::vector<PoseCB>> boards_of(const vision::CameraModel& camera,
                                          std::span<const HandEyeView> views) {
  std::vector<PoseCB> out;
  for (std::size_t v = 0; v < views.size(); ++v) {
    auto pose = plane_pose(camera, views[v].seen);
    if (!pose) {
      pose.error().index = static_cast<int>(v);
      return std::unexpected(pose.error());
    }
    out.push_back(pose->X_CB);
  }
  return out;
}

/// The best fit of all starts.
MountFit best_fit(const MountProblem& problem, std::span<const PoseCB> X_CB) {
  std::vector<PoseMN> X_MN;
  for (const HandEyeView& view : problem.views) {
    X_MN.push_back(between_mounts(problem.settings.mounting, view.X_BF));
  }
  MountProblem exact = problem;
  exact.joints = exact.sizes = 0;
  MountFit best{{}, {}, false, kInfinity, {}};
  double least = kInfinity;
  constexpr double kGood = 1;  // px; with all points kept, no other start can do better
  constexpr double kCut = 20;  // px; beyond it, wrong is wrong
  for (const MountStart& start : mount_starts(X_MN, X_CB)) {
    MountFit fit = robust_fit(exact, {start.X_MC, start.X_NB, {}});
    if (problem.extra() > 0) {
      fit.state.offsets = Eigen::VectorXd::Zero(problem.joints);
      fit = robust_fit(problem, std::move(fit.state));
    }
    if (!fit.converged) continue;
    // Over all points: those of a single view may be all that shows one of the directions.
    double sum = 0;
    for (const double norm : fit.norms) sum += std::min(norm, kCut);
    if (!(sum < least)) continue;
    least = sum;
    best = std::move(fit);
    if (quantile(best.norms, 1) < kGood) break;
  }
  return best;
}

/// px, of one coordinate, by the pixels alone.
double pixel_sigma_of(const MountFit& fit) {
  constexpr double kSigmaMin = 1e-6;
  const std::vector<double> norms = kept_norms(fit);
  const double residuals = 2 * static_cast<double>(norms.size());
  const double free = std::max(1.0, residuals - kMountParameters);
  return std::max(kSigmaMin, rms(norms) * std::sqrt(residuals / 2 / free));
}

/// Distances on the board (m) between its points and where the pixels' rays meet it, each view
/// with mounts that were fitted to the others; these mounts into `out`.
std::vector<double> left_out_errors(const MountProblem& problem, const MountFit& all,
                                    HandEye& out) {
  std::vector<double> errors;
  std::size_t first = 0;
  for (const HandEyeView& view : problem.views) {
    const std::size_t count = view.seen.pixels.size();
    PointWeights weights = all.weights;
    std::fill_n(weights.used.begin() + static_cast<std::ptrdiff_t>(first), count, 0);
    const MountState state = minimise(problem, all.state, std::move(weights)).state;
    out.X_MC_without.push_back(state.X_MC);
    out.X_NB_without.push_back(state.X_NB);
    const PoseMN X_MN = between_mounts(problem.settings.mounting, offset_pose(view, state.offsets));
    const PoseCB X_CB = state.X_MC.inverse() * X_MN * state.X_NB;
    const auto X_BC = relabel<frame::World, frame::Camera>(X_CB.inverse());
    for (std::size_t i = 0; i < count; ++i) {
      if (all.weights.used[first + i] == 0) continue;
      const auto p = ray_to_plane(problem.camera, X_BC, view.seen.pixels[i], 0);
      errors.push_back(p ? norm(*p - state.size * view.seen.points_B[i]) : kInfinity);
    }
    first += count;
  }
  return errors;
}

/// H of the pixels for the two mounts alone, with what else is estimated free within its prior.
MountMatrix mount_information(const MountProblem& problem, const MountFit& fit) {
  NormalEquations sum(problem.size(), fit.weights);
  problem.add_pixels(sum, fit.state);
  problem.add_priors(sum, fit.state);
  const Eigen::MatrixXd H = sum.full_H();
  const MountMatrix mounts = H.topLeftCorner<kMountParameters, kMountParameters>();
  if (problem.extra() == 0) return mounts;
  const Eigen::MatrixXd coupling = H.topRightCorner(kMountParameters, problem.extra());
  const Eigen::MatrixXd inner = H.bottomRightCorner(problem.extra(), problem.extra());
  return mounts - coupling * inner.inverse() * coupling.transpose();
}

/// Inverse covariance of the mounts by the known points alone.
MountMatrix prior_information(MountProblem problem, const MountFit& fit) {
  problem.pixel_sigma = 1;
  NormalEquations sum(problem.size(), fit.weights);
  problem.add_known_points(sum, fit.state.X_NB);
  return sum.full_H().topLeftCorner<kMountParameters, kMountParameters>();
}

double mean_distance(const MountProblem& problem, const MountState& state) {
  double sum = 0;
  for (const HandEyeView& view : problem.views) {
    const PoseMN X_MN = between_mounts(problem.settings.mounting, view.X_BF);
    for (const Vec3& p_B : view.seen.points_B) {
      sum += norm(chain_point(state.X_MC, X_MN, state.X_NB, p_B).p_C);
    }
  }
  return sum / static_cast<double>(problem.points());
}

/// m, 95 % of the length of a point's error, from its places without one view each.
double jackknife_95(std::span<const Vec3> places) {
  Eigen::Vector3d mean = Eigen::Vector3d::Zero();
  for (const Vec3& p : places) mean += to_eigen(p) / static_cast<double>(places.size());
  Eigen::Matrix3d C = Eigen::Matrix3d::Zero();
  for (const Vec3& p : places) C += (to_eigen(p) - mean) * (to_eigen(p) - mean).transpose();
  const double freedom = static_cast<double>(places.size()) - 1;
  C *= freedom / static_cast<double>(places.size());
  const double variance = C.trace();
  if (!(variance > 0)) return 0;
  const double axes = variance * variance / (C * C).trace();
  return std::sqrt(variance * f_quantile(0.95, axes, freedom));
}

template <class A, class B>
double error_95_of(std::span<const Pose<A, B>> X_AB, const Vec3& p_B) {
  std::vector<Vec3> places;
  for (const auto& X : X_AB) places.push_back(X * p_B);
  return jackknife_95(places);
}

HandEye result_of(const MountProblem& problem, const MountFit& fit) {
  HandEye out;
  out.X_MC = fit.state.X_MC;
  out.X_NB = fit.state.X_NB;
  out.size = fit.state.size;
  out.joint_offsets.assign(fit.state.offsets.begin(), fit.state.offsets.end());
  const std::vector<double> kept = kept_norms(fit);
  out.rms = rms(kept);
  out.pixel_sigma = problem.pixel_sigma;
  NormalEquations sum(problem.size(), fit.weights);
  problem.add_to(sum, fit.state);
  out.covariance = problem.pixel_sigma * problem.pixel_sigma *
                   sum.inverse().topLeftCorner<kMountParameters, kMountParameters>();
  out.error_95 = quantile(left_out_errors(problem, fit, out), 0.95);
  std::size_t index = 0;
  for (std::size_t v = 0; v < problem.views.size(); ++v) {
    const std::size_t count = problem.views[v].seen.pixels.size();
    out.view_rms.push_back(calibration::rms(std::span(fit.norms).subspan(index, count)));
    for (std::size_t i = 0; i < problem.views[v].seen.pixels.size(); ++i, ++index) {
      if (fit.weights.used[index] == 0) out.wrong_points.push_back({v, i, fit.norms[index]});
    }
  }
  Observability& seen = out.observability;
  seen.mounting = problem.settings.mounting;
  seen.information = mount_information(problem, fit);
  seen.prior = prior_information(problem, fit);
  seen.distance = mean_distance(problem, fit.state);
  seen.focal = std::sqrt(problem.camera.fx * problem.camera.fy);
  seen.points = static_cast<double>(kept.size());
  find_weak_directions(seen);
  return out;
}

}  // namespace

double camera_error_95(const HandEye& found, const Vec3& p_C) {
  return error_95_of(std::span<const PoseMC>(found.X_MC_without), p_C);
}

double board_error_95(const HandEye& found, const Vec3& p_B) {
  return error_95_of(std::span<const PoseNB>(found.X_NB_without), p_B);
}

Calibrated<HandEye> hand_eye(const vision::CameraModel& camera, std::span<const HandEyeView> views,
                             const HandEyeSettings& settings) {
  using enum CalibrationFault;
  if (views.size() < kViewsMin) {
    return std::unexpected(CalibrationError{kTooFewViews, -1, static_cast<double>(views.size()),
                                            static_cast<double>(kViewsMin), 0});
  }
  const auto X_CB = boards_of(camera, views);
  if (!X_CB) return std::unexpected(X_CB.error());

  MountProblem problem{camera, views, settings, offset_joints(views, settings),
                       settings.size_sigma > 0 ? 1 : 0};
  MountFit fit = best_fit(problem, *X_CB);
  CalibrationError lost{kNotConverged, -1, kInfinity, 0.1 * camera.width, 0};
  if (!fit.norms.empty()) lost.measured = rms(kept_norms(fit));
  if (!fit.converged || !(lost.measured <= lost.limit)) return std::unexpected(lost);

  // Pixels and priors are weighed by what the pixels turned out to be.
  for (int round = 0; round < 2 && problem.has_priors(); ++round) {
    problem.pixel_sigma = pixel_sigma_of(fit);
    fit = fit_without_wrong_points(problem, std::move(fit));
  }
  problem.pixel_sigma = pixel_sigma_of(fit);
  return result_of(problem, fit);
}

}  // namespace sinew::calibration
