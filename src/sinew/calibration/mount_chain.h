#pragma once

#include <Eigen/Core>

#include "sinew/calibration/geometry.h"
#include "sinew/core/pose.h"
#include "sinew/vision/camera_model.h"

namespace sinew::frame {
struct CameraMount;  ///< M: what carries the camera, flange or base
struct BoardMount;   ///< N: what carries the board, base or flange
}  // namespace sinew::frame

namespace sinew::calibration {

using PoseMC = Pose<frame::CameraMount, frame::Camera>;
using PoseNB = Pose<frame::BoardMount, frame::Board>;
using PoseMN = Pose<frame::CameraMount, frame::BoardMount>;

/// Parameters of both unknown poses: rotation (rad) and position (m) of X_MC, then of X_NB, as in
/// moved().
inline constexpr int kMountParameters = 12;
using MountVector = Eigen::Matrix<double, kMountParameters, 1>;
using MountMatrix = Eigen::Matrix<double, kMountParameters, kMountParameters>;

/// A point of the board in the camera's frame, through both mounts.
struct ChainPoint {
  Vec3 p_C;
  Vec3 p_M;
  Vec3 p_N;
  Eigen::Matrix<double, 3, kMountParameters> by_mounts;  ///< of p_C
};

inline ChainPoint chain_point(const PoseMC& X_MC, const PoseMN& X_MN, const PoseNB& X_NB,
                              const Vec3& p_B) {
  const Vec3 arm_N = X_NB.R * p_B;
  const Vec3 p_N = arm_N + X_NB.p;
  const Vec3 p_M = X_MN * p_N;
  const Vec3 arm_M = p_M - X_MC.p;
  const Eigen::Matrix3d R_CM = to_eigen(X_MC.R.transposed());
  const Eigen::Matrix3d R_CN = R_CM * to_eigen(X_MN.R);
  ChainPoint out{transposed_times(X_MC.R, arm_M), p_M, p_N, {}};
  out.by_mounts << R_CM * cross_matrix(arm_M), -R_CM, -R_CN * cross_matrix(arm_N), R_CN;
  return out;
}

}  // namespace sinew::calibration
