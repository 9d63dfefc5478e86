#include "sinew/calibration/hand_eye_start.h"

#include <Eigen/QR>
#include <algorithm>
#include <cmath>
#include <cstdint>

namespace sinew::calibration {
namespace {

constexpr double kCut = 0.3;

using PosesMN = std::span<const PoseMN>;
using PosesCB = std::span<const Pose<frame::Camera, frame::Board>>;

/// The rotations that carry a cube into itself: cameras are mounted nearly so.
std::vector<Rotation> cube_rotations() {
  std::vector<Rotation> out;
  for (int turn = 0; turn < 4; ++turn) {
    const Rotation R = rotation_z(turn * kPi / 2);
    for (int face = 0; face < 4; ++face) out.push_back(R * rotation_y(face * kPi / 2));
    for (const double angle : {-kPi / 2, kPi / 2}) out.push_back(R * rotation_x(angle));
  }
  return out;
}

/// R_MC R_CB = R_MN R_NB in all views: each side's rotation in turns. Views that disagree are
/// wrong, and then fade out; or they alone show a direction, and then they must not.
enum class Doubt : std::uint8_t { kNone, kFadeOut };
void improve_rotations(PosesMN X_MN, PosesCB X_CB, Doubt doubt, MountStart& start) {
  constexpr int kTurns = 60;
  constexpr double kSettled = 1e-4;  // rad
  constexpr double kFades = 0.1;     // rad
  std::vector<double> weights(X_MN.size(), 1.0);
  for (int turn = 0; turn < kTurns; ++turn) {
    Eigen::Matrix3d of_board = Eigen::Matrix3d::Zero();
    for (std::size_t i = 0; i < X_MN.size(); ++i) {
      of_board += weights[i] * to_eigen(X_MN[i].R.transposed() * (start.X_MC.R * X_CB[i].R));
    }
    start.X_NB.R = nearest_rotation(of_board);
    Eigen::Matrix3d of_camera = Eigen::Matrix3d::Zero();
    for (std::size_t i = 0; i < X_MN.size(); ++i) {
      of_camera += weights[i] * to_eigen(X_MN[i].R * start.X_NB.R * X_CB[i].R.transposed());
    }
    const Rotation before = start.X_MC.R;
    start.X_MC.R = nearest_rotation(of_camera);
    if (angle_between(before, start.X_MC.R) < kSettled) break;
    for (std::size_t i = 0; i < X_MN.size() && doubt == Doubt::kFadeOut; ++i) {
      const double off = angle_between(start.X_MC.R * X_CB[i].R, X_MN[i].R * start.X_NB.R);
      weights[i] = 1 / (1 + off * off / (kFades * kFades));
    }
  }
}

/// Positions for known rotations: R_MN p_NB - p_MC = R_MC p_CB - p_MN, the shortest solution.
void solve_positions(PosesMN X_MN, PosesCB X_CB, MountStart& start) {
  Eigen::MatrixXd A(3 * std::ssize(X_MN), 6);
  Eigen::VectorXd b(3 * std::ssize(X_MN));
  for (std::size_t i = 0; i < X_MN.size(); ++i) {
    const Eigen::Index row = 3 * static_cast<Eigen::Index>(i);
    A.block<3, 3>(row, 0) = -Eigen::Matrix3d::Identity();
    A.block<3, 3>(row, 3) = to_eigen(X_MN[i].R);
    b.segment<3>(row) = to_eigen(start.X_MC.R * X_CB[i].p - X_MN[i].p);
  }
  Eigen::CompleteOrthogonalDecomposition<Eigen::MatrixXd> solver;
  solver.setThreshold(1e-6);
  const Eigen::VectorXd x = solver.compute(A).solve(b);
  start.X_MC.p = to_vec3(x.head<3>());
  start.X_NB.p = to_vec3(x.tail<3>());
}

double misfit_of(PosesMN X_MN, PosesCB X_CB, const MountStart& start) {
  double sum = 0;
  for (std::size_t i = 0; i < X_MN.size(); ++i) {
    const auto seen = start.X_MC * X_CB[i];
    const auto due = X_MN[i] * start.X_NB;
    sum += std::min(angle_between(seen.R, due.R), kCut) +
           std::min(norm(seen.p - due.p) / norm(X_CB[i].p), kCut);
  }
  return sum / static_cast<double>(X_MN.size());
}

}  // namespace

std::vector<MountStart> mount_starts(PosesMN X_MN, PosesCB X_CB) {
  constexpr std::size_t kStartsMax = 4;
  constexpr double kDiffer = from_deg(10);
  std::vector<MountStart> all;
  for (const Rotation& R : cube_rotations()) {
    for (const Doubt doubt : {Doubt::kNone, Doubt::kFadeOut}) {
      MountStart start{{R, {}}, {}, 0};
      improve_rotations(X_MN, X_CB, doubt, start);
      solve_positions(X_MN, X_CB, start);
      start.misfit = misfit_of(X_MN, X_CB, start);
      all.push_back(start);
    }
  }
  std::stable_sort(all.begin(), all.end(),
                   [](const MountStart& a, const MountStart& b) { return a.misfit < b.misfit; });
  std::vector<MountStart> out;
  for (const MountStart& start : all) {
    const bool known = std::any_of(out.begin(), out.end(), [&](const MountStart& other) {
      return angle_between(other.X_MC.R, start.X_MC.R) < kDiffer;
    });
    if (!known && out.size() < kStartsMax) out.push_back(start);
  }
  return out;
}

}  // namespace sinew::calibration
