#pragma once

#include <array>
#include <cstdint>
#include <cstdlib>
#include <string_view>
#include <vector>

#include "sinew/config/builtin_robots.h"
#include "sinew/config/robot_file.h"
#include "sinew/core/split_mix.h"
#include "sinew/kinematics/serial_arm.h"

namespace sinew::bench {

/// So many different inputs in turn that no branch predictor learns them by heart.
inline constexpr std::size_t kInputs = 4096;

/// The same numbers in every run.
struct Numbers : SplitMix64 {
  Numbers() : SplitMix64(42) {}
};

inline RobotModel robot(std::string_view id) {
  for (const auto& file : builtin_robots()) {
    if (file.id == id) return *read_robot(file.text, file.file_name);
  }
  std::abort();
}

inline JointVector random_joints(Numbers& numbers, const RobotModel& model) {
  JointVector q;
  for (const Joint& joint : model.joints) q.push_back(numbers.uniform(joint.lower, joint.upper));
  return q;
}

/// A serial robot with random joints, their poses, and starts near to and far from them.
struct SerialInputs {
  explicit SerialInputs(std::string_view id)
      : model(robot(id)),
        geometry(std::get<SerialGeometry>(model.geometry)),
        arm(geometry, model.joints, kinematics::tool_pose(geometry)) {
    Numbers numbers;
    for (std::size_t i = 0; i < kInputs; ++i) {
      q.push_back(random_joints(numbers, model));
      far.push_back(random_joints(numbers, model));
      near.push_back(q.back());
      for (std::size_t j = 0; j < near.back().size(); ++j) {
        const Joint& joint = model.joints[j];
        const double moved = q.back()[j] + numbers.uniform(-0.1, 0.1);
        near.back()[j] = std::min(std::max(moved, joint.lower), joint.upper);
      }
      X_BF.push_back(arm.chain().forward(q.back()));
      X_BT.push_back(arm.forward(q.back()));
    }
  }

  RobotModel model;
  SerialGeometry geometry;
  kinematics::SerialArm arm;
  std::vector<JointVector> q, near, far;
  std::vector<kinematics::PoseBF> X_BF;
  std::vector<kinematics::PoseBT> X_BT;
};

}  // namespace sinew::bench
