#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "sinew/calibration/mount_chain.h"
#include "sinew/calibration/projection.h"

namespace sinew::calibration {

/// Where the camera is; the board is on the other side of the arm.
enum class CameraMounting : std::uint8_t {
  kOnFlange,  ///< the camera moves, the board stays: M is the flange, N the base
  kFixed,     ///< the camera stays, the flange carries the board: M is the base, N the flange
};

/// Smallest singular value of a direction that counts as known: a motion of 1 rad, or of the whole
/// distance from camera to board, must move the points by 0.003 rad of the field of view. Then 100
/// points with 0.3 px leave 0.6 deg or 1 % of the distance open.
inline constexpr double kSingularValueMin = 0.003;
/// Prior knowledge that counts as much. rad, and m over the distance
inline constexpr double kPriorSigmaMax = 0.01;

/// A combination of parameters that the views do not determine.
struct WeakDirection {
  MountVector direction;  ///< length 1; rad, and m over the distance from camera to board
  double singular_value = 0;
  std::string what;    ///< "the camera's position along the flange's z axis"
  std::string remedy;  ///< an instruction, as a sentence
};

/// How well views determine where camera and board are mounted.
struct Observability {
  CameraMounting mounting{};
  MountMatrix information = MountMatrix::Zero();  ///< H of the pixels, px^2 per unit^2
  MountMatrix prior = MountMatrix::Zero();        ///< inverse covariance of what is known besides
  double distance = 1;  ///< m, mean from camera to board: the unit of length
  double focal = 1;     ///< px
  double points = 0;
  /// rad per unit, rms over the points; the smallest first.
  MountVector singular_values = MountVector::Zero();
  std::vector<WeakDirection> weak;

  bool complete() const { return weak.empty(); }
};

/// Fills in what follows from the other members: singular values and weak directions.
void find_weak_directions(Observability& observability);

/// What a flange pose would add.
struct NextPose {
  std::size_t index = 0;       ///< of the candidate
  double smallest_before = 0;  ///< singular value
  double smallest_after = 0;
};

/// Candidates by what they add, the best first. While a direction is weak, by the number of weak
/// directions that are left, then by the smallest singular value; after that, by the product of all
/// of them (D-optimality). Left out are candidates that do not show half of the board within 70 deg
/// of its normal. Visibility follows from X_MC and X_NB as far as they are known: along weak
/// directions it may be wrong, then take the next candidate.
std::vector<NextPose> next_poses(const Observability& observability,
                                 const vision::CameraModel& camera, const PoseMC& X_MC,
                                 const PoseNB& X_NB, std::span<const Vec3> points_B,
                                 std::span<const Pose<frame::Base, frame::Flange>> candidates);

/// Smallest singular value with views of all these poses, as far as they show points.
double smallest_with(const Observability& observability, const vision::CameraModel& camera,
                     const PoseMC& X_MC, const PoseNB& X_NB, std::span<const Vec3> points_B,
                     std::span<const Pose<frame::Base, frame::Flange>> poses);

/// X_MN of a flange pose.
PoseMN between_mounts(CameraMounting mounting, const Pose<frame::Base, frame::Flange>& X_BF);

}  // namespace sinew::calibration
