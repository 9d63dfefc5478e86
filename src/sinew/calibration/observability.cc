#include "sinew/calibration/observability.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <utility>

#include "sinew/core/number_text.h"

namespace sinew::calibration {
namespace {

using Eigen::Index;
using Solver = Eigen::SelfAdjointEigenSolver<MountMatrix>;

/// H in units of rad and of the distance, per point and per rad of the field of view.
MountMatrix scaled(const Observability& o, const MountMatrix& information, double points) {
  MountVector unit = MountVector::Ones();
  unit.segment<3>(3).setConstant(o.distance);
  unit.segment<3>(9).setConstant(o.distance);
  const double per_point = 1 / (o.focal * o.focal * std::max(points, 1.0));
  const double per_prior = std::pow(kSingularValueMin * kPriorSigmaMax, 2);
  const MountMatrix sum = per_point * information + per_prior * o.prior;
  return unit.asDiagonal() * sum * unit.asDiagonal();
}

MountVector singular_values_of(const Solver& solved) {
  return solved.eigenvalues().cwiseMax(0).cwiseSqrt();
}

/// Another basis of the same space, with as many zeros as can be: Gauss-Jordan elimination with
/// rotations as the first pivots, so that a vector without rotation is a pure shift.
void make_sparse(Eigen::MatrixXd& basis) {
  constexpr std::array<Index, kMountParameters> kOrder{0, 1, 2, 6, 7, 8, 3, 4, 5, 9, 10, 11};
  constexpr double kPivotMin = 0.05;
  Index done = 0;
  for (const Index row : kOrder) {
    if (done == basis.cols()) break;
    Index pivot = 0;
    const Index left = basis.cols() - done;
    if (basis.row(row).tail(left).cwiseAbs().maxCoeff(&pivot) < kPivotMin) continue;
    basis.col(done).swap(basis.col(done + pivot));
    basis.col(done) /= basis(row, done);
    for (Index other = 0; other < basis.cols(); ++other) {
      if (other != done) basis.col(other) -= basis(row, other) * basis.col(done);
    }
    ++done;
  }
  basis.colwise().normalize();
}

/// The axis that a vector is along within 25 deg; nothing for a slanted one.
std::optional<Index> axis_of(const Eigen::Vector3d& v) {
  Index axis = 0;
  if (v.cwiseAbs().maxCoeff(&axis) < 0.9 * v.norm()) return std::nullopt;
  return axis;
}

std::string axis_text(const Eigen::Vector3d& v, const std::string& mount) {
  constexpr std::array<const char*, 3> kNames{"x", "y", "z"};
  if (const auto axis = axis_of(v)) {
    return "the " + mount + "'s " + kNames[static_cast<std::size_t>(*axis)] + " axis";
  }
  const Eigen::Vector3d u = v.normalized();
  return "(" + number_text(u.x(), 2) + ", " + number_text(u.y(), 2) + ", " + number_text(u.z(), 2) +
         ") of the " + mount;
}

/// Rotation and position of one of the two bodies within a direction.
struct Part {
  Eigen::Vector3d rotation;
  Eigen::Vector3d position;
  std::string body;
  std::string mount;

  double size() const { return std::max(rotation.norm(), position.norm()); }
  bool turns() const { return rotation.norm() > 0.1; }
  Eigen::Vector3d axis() const { return turns() ? rotation : position; }
  std::string text() const {
    return "the " + body + (turns() ? "'s rotation about " : "'s position along ") +
           axis_text(axis(), mount);
  }
};

WeakDirection described(const Observability& o, const MountVector& direction, double value) {
  const bool on_flange = o.mounting == CameraMounting::kOnFlange;
  const Part camera{direction.segment<3>(0), direction.segment<3>(3), "camera",
                    on_flange ? "flange" : "base"};
  const Part board{direction.segment<3>(6), direction.segment<3>(9), "board",
                   on_flange ? "base" : "flange"};
  constexpr double kSeen = 0.1;
  WeakDirection out{direction, value, {}, {}};
  if (camera.size() > kSeen) out.what = camera.text();
  if (board.size() > kSeen) {
    out.what += (out.what.empty() ? "" : ", together with ") + board.text();
  }
  // A rotation of the flange about an axis across the direction tells its two ends apart.
  const Part& at_flange = on_flange ? camera : board;
  constexpr std::array<const char*, 3> kAcross{"y or z", "x or z", "x or y"};
  const auto axis = axis_of(at_flange.axis());
  const std::string about =
      axis ? std::string("its ") + kAcross[static_cast<std::size_t>(*axis)] + " axis"
           : "an axis across " + axis_text(at_flange.axis(), "flange");
  out.remedy = "Add poses with the flange tilted by about 30 deg about " + about + ".";
  return out;
}

/// Whether a camera sees a point of the board, and not too flat.
bool visible(const vision::CameraModel& camera, const Vec3& p_C, const Vec3& normal_C) {
  const double flattest = std::cos(from_deg(70));
  const auto pixel = camera.project(p_C);
  if (!pixel) return false;
  return pixel->x > 0 && pixel->y > 0 && pixel->x < camera.width && pixel->y < camera.height &&
         std::abs(dot(normal_C, normalized(p_C))) > flattest;
}

/// What one more view would add to H, and the points that it shows.
struct Gain {
  MountMatrix information = MountMatrix::Zero();
  double points = 0;
};

Gain gain_of(const vision::CameraModel& camera, const PoseMC& X_MC, const PoseMN& X_MN,
             const PoseNB& X_NB, std::span<const Vec3> points_B) {
  Gain gain;
  const Vec3 normal_C = transposed_times(X_MC.R, X_MN.R * X_NB.R.z);
  for (const Vec3& p_B : points_B) {
    const ChainPoint at = chain_point(X_MC, X_MN, X_NB, p_B);
    if (!visible(camera, at.p_C, normal_C)) continue;
    const auto there = projection(camera, at.p_C);
    if (!there) continue;
    const Eigen::Matrix<double, 2, kMountParameters> J = there->by_point * at.by_mounts;
    gain.information += J.transpose() * J;
    gain.points += 1;
  }
  return gain;
}

}  // namespace

PoseMN between_mounts(CameraMounting mounting, const Pose<frame::Base, frame::Flange>& X_BF) {
  using frame::BoardMount;
  using frame::CameraMount;
  return mounting == CameraMounting::kFixed ? relabel<CameraMount, BoardMount>(X_BF)
                                            : relabel<CameraMount, BoardMount>(X_BF.inverse());
}

void find_weak_directions(Observability& o) {
  const Solver solved(scaled(o, o.information, o.points));
  o.singular_values = singular_values_of(solved);
  o.weak.clear();
  const auto count = std::count_if(o.singular_values.begin(), o.singular_values.end(),
                                   [](double value) { return !(value >= kSingularValueMin); });
  if (count == 0) return;
  Eigen::MatrixXd basis = solved.eigenvectors().leftCols(count);
  make_sparse(basis);
  const MountMatrix H = scaled(o, o.information, o.points);
  for (Index i = 0; i < count; ++i) {
    const MountVector v = basis.col(i);
    o.weak.push_back(described(o, v, std::sqrt(std::max(0.0, v.dot(H * v)))));
  }
}

std::vector<NextPose> next_poses(const Observability& o, const vision::CameraModel& camera,
                                 const PoseMC& X_MC, const PoseNB& X_NB,
                                 std::span<const Vec3> points_B,
                                 std::span<const Pose<frame::Base, frame::Flange>> candidates) {
  std::vector<std::pair<double, NextPose>> scored;
  for (std::size_t i = 0; i < candidates.size(); ++i) {
    const PoseMN X_MN = between_mounts(o.mounting, candidates[i]);
    const Gain gain = gain_of(camera, X_MC, X_MN, X_NB, points_B);
    if (gain.points < 4 || 2 * gain.points < static_cast<double>(points_B.size())) continue;
    const MountMatrix sum = o.information + gain.information;
    const MountVector total = singular_values_of(Solver(scaled(o, sum, o.points)));
    const MountVector mean = singular_values_of(Solver(scaled(o, sum, o.points + gain.points)));
    const auto weak = static_cast<double>((mean.array() < kSingularValueMin).count());
    const double score = o.complete() ? total.array().log().sum() : total[0] - weak;
    scored.emplace_back(score, NextPose{i, o.singular_values[0], mean[0]});
  }
  std::stable_sort(scored.begin(), scored.end(),
                   [](const auto& a, const auto& b) { return a.first > b.first; });
  std::vector<NextPose> out;
  for (const auto& [score, pose] : scored) out.push_back(pose);
  return out;
}

double smallest_with(const Observability& o, const vision::CameraModel& camera, const PoseMC& X_MC,
                     const PoseNB& X_NB, std::span<const Vec3> points_B,
                     std::span<const Pose<frame::Base, frame::Flange>> poses) {
  MountMatrix sum = o.information;
  double points = o.points;
  for (const auto& X_BF : poses) {
    const Gain gain = gain_of(camera, X_MC, between_mounts(o.mounting, X_BF), X_NB, points_B);
    sum += gain.information;
    points += gain.points;
  }
  return singular_values_of(Solver(scaled(o, sum, points)))[0];
}

}  // namespace sinew::calibration
