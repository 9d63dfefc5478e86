#pragma once

#include <functional>
#include <vector>

#include "sinew/kinematics/hexapod.h"
#include "sinew/model/robot_model.h"

namespace sinew::planning {

/// Finds the pose of a robot at which something is largest: the same poses each time, spread over
/// the workspace, then a climb from the best of them. The answer is a lower bound of the true
/// maximum: for the torques of arms tests find it to 0.3 %; a hexapod, whose poses end at many
/// edges, may have up to a tenth more.
class PoseSearch {
 public:
  /// Poses that are looked at before the climb.
  static constexpr std::size_t kPoses = 4000;

  explicit PoseSearch(const RobotModel& model);

  /// What is looked for; minus infinity for a pose that does not count. `number` is that of the
  /// pose while poses are looked at, and kClimbing later.
  using Score = std::function<double(const JointVector& q, std::size_t number)>;
  static constexpr std::size_t kClimbing = static_cast<std::size_t>(-1);

  struct Found {
    JointVector q;
    double score = 0;  ///< minus infinity where no pose counts
  };
  /// Joints that do not matter are at their home.
  Found best(const Score& score) const;

 private:
  /// What is varied: joints, or six numbers of a platform's pose (m, and a rotation vector), each
  /// from 0 to 1 of its range.
  using Share = std::array<double, kMaxJoints>;
  std::optional<JointVector> configuration(const Share& share) const;
  Share share_of_home() const;
  Found climb(Share share, Found found, const Score& score, std::uint64_t seed) const;

  RobotModel model_;
  std::optional<kinematics::Hexapod> hexapod_;
  std::size_t size_;
  Share lower_{}, upper_{};
  std::vector<Share> shares_;
  std::vector<JointVector> poses_;
};

}  // namespace sinew::planning
