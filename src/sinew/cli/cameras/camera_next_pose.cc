#include "sinew/cli/cameras/camera_next_pose.h"

#include <algorithm>
#include <memory>
#include <vector>

#include "sinew/cli/cameras/camera_robot.h"
#include "sinew/core/split_mix.h"
#include "sinew/planning/collision/collision.h"

namespace sinew::cli {
namespace {

/// Joints near those of the views, then anywhere.
std::vector<JointVector> candidates(const RobotModel& model, std::span<const JointVector> joints) {
  constexpr std::size_t kAround = 3000;
  constexpr std::size_t kAll = 3000;
  constexpr double kShare = 0.35;  // of a joint's range, to either side
  SplitMix64 random(1);
  std::vector<JointVector> out;
  for (std::size_t i = 0; i < kAround + kAll; ++i) {
    JointVector q;
    for (std::size_t j = 0; j < model.joints.size(); ++j) {
      const Joint& joint = model.joints[j];
      const double range = joint.upper - joint.lower;
      const double anywhere = random.uniform(joint.lower, joint.upper);
      const double near = joints[i % joints.size()][j] + random.uniform(-kShare, kShare) * range;
      q.push_back(std::clamp(i < kAround ? near : anywhere, joint.lower, joint.upper));
    }
    out.push_back(q);
  }
  return out;
}

std::vector<Vec3> corners_of_board(const vision::TagBoard& target) {
  std::vector<Vec3> points;
  for (int id = target.first; id < target.first + target.columns * target.rows; ++id) {
    for (std::size_t k = 0; k < 4; ++k) points.push_back(target.corner(id, k));
  }
  return points;
}

}  // namespace

std::optional<NextView> next_view(const RobotModel& model, const vision::CameraModel& camera,
                                  const calibration::HandEye& found,
                                  std::span<const JointVector> joints,
                                  const vision::TagBoard& target) {
  const auto body = std::make_unique<planning::CollisionModel>(model);
  std::vector<JointVector> poses;
  std::vector<Pose<frame::Base, frame::Flange>> flanges;
  for (const JointVector& q : candidates(model, joints)) {
    const auto flange = flange_at(model, q);
    if (!flange) continue;
    poses.push_back(q);
    flanges.push_back(flange->X_BF);
  }
  const std::vector<Vec3> points = corners_of_board(target);
  const auto best =
      calibration::next_poses(found.observability, camera, found.X_MC, found.X_NB, points, flanges);
  constexpr std::size_t kMost = 300;
  std::optional<NextView> found_view;
  std::vector<Pose<frame::Base, frame::Flange>> clear;
  const std::size_t step = 1 + best.size() / kMost;
  for (std::size_t i = 0; i < best.size(); ++i) {
    if (found_view && i % step != 0) continue;
    const JointVector& q = poses[best[i].index];
    if (!body->clear({q.data(), q.size()}, body->margin())) continue;
    if (!found_view) found_view = NextView{q, false};
    clear.push_back(flanges[best[i].index]);
  }
  if (!found_view) return std::nullopt;
  found_view->suffices = smallest_with(found.observability, camera, found.X_MC, found.X_NB, points,
                                       clear) >= calibration::kSingularValueMin;
  return found_view;
}

}  // namespace sinew::cli
