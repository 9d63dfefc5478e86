#pragma once

#include <cstddef>
#include <limits>
#include <vector>

#include "sinew/planning/paths/joint_path.h"

namespace sinew::planning {

/// How far the tool moves with s, at most within one piece of the path: m per unit of s, and per
/// unit squared. Zero where the tool turns on the spot.
struct ToolRate {
  double speed = 0;      ///< |dp/ds|
  double curvature = 0;  ///< |d2p/ds2|
};

/// A stretch of the path that one row of a program asked for, blends included to their middle.
struct PathSection {
  double begin = 0;      ///< s
  std::size_t move = 0;  ///< which one of those that were asked for, from 0
  /// What was asked for, of the tool; beyond what the robot may do anyway where nobody asked.
  double tool_speed = std::numeric_limits<double>::infinity();         ///< m/s
  double tool_acceleration = std::numeric_limits<double>::infinity();  ///< m/s^2
  double joint_share = 1;  ///< of the joints' velocity limits, (0, 1]
  bool metres = true;      ///< s counts its tool's way, and not its turn or its joints'
};

/// A path that the robot can take, checked over its whole length: q(s), what its tool does on the
/// way, and which move each place belongs to.
struct PlannedPath {
  explicit PlannedPath(std::size_t joint_count, std::size_t capacity = JointPath::kPiecesMax,
                       std::size_t moves = 1024)
      : joints(joint_count, capacity) {
    tool.reserve(capacity);
    sections.reserve(moves);
  }
  void clear() {
    joints.clear();
    tool.clear();
    sections.clear();
  }

  JointPath joints;
  std::vector<ToolRate> tool;  ///< one per piece of `joints`
  /// In the order of s; the first begins at 0.
  std::vector<PathSection> sections;
};

}  // namespace sinew::planning
