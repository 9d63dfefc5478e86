#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <vector>

#include "sinew/calibration/calibration_error.h"
#include "sinew/calibration/intrinsics.h"
#include "sinew/calibration/observability.h"
#include "sinew/kinematics/serial_chain.h"
#include "sinew/vision/tag_board.h"

namespace sinew::calibration {

/// One picture of the board with the arm at rest.
struct HandEyeView {
  Pose<frame::Base, frame::Flange> X_BF;  ///< from the joints, by the caller
  vision::BoardCorners seen;              ///< at least 4 points with z = 0
  /// Of the flange at this pose. With it, and with HandEyeSettings::joint_offset_sigma, small
  /// errors of the joints' zeros are estimated.
  std::optional<kinematics::Jacobian> jacobian;
};

/// A point of the board whose position in its mount is known, for instance touched with the tool.
/// Three of them fix what an arm without a tilting wrist cannot show.
struct KnownPoint {
  Vec3 p_B;               ///< m, on the board
  Vec3 p_N;               ///< m, in the board's mount
  double sigma = 0.5e-3;  ///< m, standard deviation of a coordinate
};

struct HandEyeSettings {
  CameraMounting mounting = CameraMounting::kOnFlange;
  std::vector<KnownPoint> known_points{};
  double joint_offset_sigma = 0;  ///< rad, what a joint's zero may be off by; 0: zeros are exact
  /// What the board's size may be off by, as a share of it; 0: it is exact. A single tag looks
  /// smaller than it is where white spreads over its edges, and then seems farther away; the arm's
  /// motions show its size.
  double size_sigma = 0;
};

/// Where camera and board are mounted. M is the camera's mount and N the board's: flange and base,
/// or base and flange for a fixed camera.
struct HandEye {
  PoseMC X_MC;                        ///< X_FC of a camera on the flange, X_BC of a fixed one
  PoseNB X_NB;                        ///< X of the board in base, or of the board on the flange
  MountMatrix covariance;             ///< of both, as in mount_chain.h; of pixel errors alone
  std::vector<double> joint_offsets;  ///< rad, to add to the joints; empty unless estimated
  double size = 1;                    ///< of the board over the one given; 1 unless estimated
  double pixel_sigma = 0;             ///< px, standard deviation of one coordinate
  double rms = 0;                     ///< px, distance between points and their model
  std::vector<double> view_rms;       ///< px, by view; points that were left out count too
  double error_95 = 0;  ///< m on the board, 95 %, of views that the fit did not use; contains
                        ///< the errors of the arm, but not those along weak directions
  std::vector<WrongPoint> wrong_points;  ///< left out; not part of the figures
  std::vector<PoseMC> X_MC_without;      ///< fitted without one of the views each
  std::vector<PoseNB> X_NB_without;
  Observability observability;
};

/// m, what X_MC * p_C is off by with a probability of 95 %, errors of the arm and of the tool
/// included: by how much it changes without one view (jackknife). For two views or more.
/// Source: B. Efron, The Jackknife, the Bootstrap and Other Resampling Plans, 1982.
double camera_error_95(const HandEye& found, const Vec3& p_C);
/// The same of X_NB * p_B.
double board_error_95(const HandEye& found, const Vec3& p_B);

/// Mounts of camera and board from pictures of a board with the arm in several poses; for arms of
/// any number of joints.
///
/// Minimises the reprojection errors of all points over both poses. Starts from the pose of the
/// board in each view with 24 mounting rotations, each improved in turns with the board's rotation.
/// Closed forms of A X = X B need rotations about several axes; this also gives the best result
/// where some directions cannot be known, and names them (Observability).
/// Source: A. Tabb, K. Ahmad Yousef, Solving the Robot-World Hand-Eye(s) Calibration Problem with
/// Iterative Methods, 2017 (reprojection error over both poses).
///
/// @param views  at least 3; 10 or more for good figures
/// @return  1e-9 m and rad without pixel errors
/// @error  kTooFewViews; kTooFewPoints, kPointsOnLine, kNotConverged with the view; kNotConverged
Calibrated<HandEye> hand_eye(const vision::CameraModel& camera, std::span<const HandEyeView> views,
                             const HandEyeSettings& settings = {});

}  // namespace sinew::calibration
