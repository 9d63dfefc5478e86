#pragma once

#include <array>

#include "sinew/model/collision_links.h"
#include "sinew/model/robot_model.h"

namespace sinew::planning {

/// By how much (m) the distance of two shapes can change at most while each joint moves by one rad
/// or m, wherever the other joints are. Of a hexapod only the first number counts: per m of the
/// Euclidean norm of all legs' moves.
using JointReach = std::array<double, kMaxJoints>;

/// The two shapes as seen by what moves them. Only the relative motion of two links counts: joints
/// that carry both, or neither, have no reach. A turn changes a distance by no more than it moves
/// the nearer end of the shortest line between them, so the smaller of both lever arms is enough.
///
/// Source: docs/collision.md.
/// @param second  nothing for the table
/// @return        of a hexapod valid while its condition number keeps condition_max.
JointReach joint_reach(const RobotModel& model, const CollisionShape& first,
                       const CollisionShape* second);

/// By how much (m) any point of a shape moves at most in base B while each joint moves by one rad
/// or m; counted as JointReach is.
JointReach own_reach(const RobotModel& model, const CollisionShape& shape);

/// A ball in base B that a shape never leaves, wherever the joints are: a capsule of length zero.
/// Of a hexapod for legs no longer than their limits.
Capsule reach_ball(const RobotModel& model, const CollisionShape& shape);

}  // namespace sinew::planning
