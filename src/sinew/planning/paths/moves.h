#pragma once

#include <limits>
#include <variant>
#include <vector>

#include "sinew/planning/paths/tool_space.h"

namespace sinew::planning {

/// How much of X_BT a target means.
enum class Asked : std::uint8_t {
  kPose,      ///< all of it
  kApproach,  ///< position and z axis; the tool turns to it the shortest way
  kPoint,     ///< position; the tool stays as it is (a palletizer's turns with its base)
};

/// Where the tool shall go.
struct ToolTarget {
  PoseBT X_BT;  ///< a hexapod's X_BP
  Asked asked = Asked::kPose;
};

/// The joints go straight to q (rad, or m for legs), the tool wherever that takes it.
struct MoveJ {
  JointArray q{};
};

/// The tool goes there, the joints straight: the nearest of all branches inside the limits.
struct MoveTo {
  ToolTarget to;
};

/// The tool goes along a straight line; its orientation turns evenly, the shortest way. On a
/// five-joint arm pitch and roll change evenly, or the approach axis turns.
struct MoveL {
  ToolTarget to;
};

/// The tool goes along the circle through where it is, `via` and `to`; its orientation turns
/// evenly.
struct MoveC {
  Vec3 p_via_BT;  ///< m
  ToolTarget to;
};

/// The tool goes through all points, with continuous velocity and acceleration along the way.
struct MoveSpline {
  static constexpr std::size_t kPointsMax = 256;
  std::vector<ToolTarget> through;  ///< in order, the last one is where it ends
};

/// One row of a program. Where another one follows, a blend lets the path leave this move near its
/// end and join the next one as far behind it; without one the robot comes to a stop there.
struct Move {
  std::variant<MoveJ, MoveTo, MoveL, MoveC, MoveSpline> way;
  double tool_speed = std::numeric_limits<double>::infinity();         ///< m/s, >= 1e-6
  double tool_acceleration = std::numeric_limits<double>::infinity();  ///< m/s^2, >= 1e-6
  double joint_share = 1;  ///< of the joints' velocity limits, [1e-3, 1]
  /// The tool comes no farther from the corner than this while it rounds it, m; 0: a stop.
  double blend_radius = 0;
  /// The same said of the joints (rad, or m for legs; 0.1 m of an arm's joint that slides count as
  /// 1 rad); where both are given both hold.
  double blend_joints = 0;
};

}  // namespace sinew::planning
