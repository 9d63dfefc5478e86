#pragma once

#include <algorithm>
#include <cmath>

#include "sinew/model/collision_links.h"
#include "sinew/model/robot_model.h"

/// What a tool is like by the collision shapes of its robot's file.
namespace sinew {

/// m, half of a finger's edges: y across the jaws, z along it. Where the file has none, those of a
/// small gripper.
inline Vec3 finger_half(const RobotModel& model) {
  for (const CollisionShape& shape : model.collision.shapes) {
    if (const auto* finger = std::get_if<JawFinger>(&shape.form)) return finger->half;
  }
  return {7e-3, 6e-3, 30e-3};
}

/// m, from the tool point down to the mouth of a suction cup: the lowest end of what the tool
/// fills, the tool upright.
inline double cup_reach(const RobotModel& model) {
  double lowest = 0;
  for (const CollisionShape& shape : model.collision.shapes) {
    if (shape.link != link_count(model) - 1) continue;
    if (const auto* capsule = std::get_if<Capsule>(&shape.form)) {
      lowest =
          std::min({lowest, capsule->p_LA.z - capsule->radius, capsule->p_LB.z - capsule->radius});
    } else if (const auto* box = std::get_if<CollisionBox>(&shape.form)) {
      const Rotation& R = box->X_LX.R;
      lowest = std::min(lowest, box->X_LX.p.z - std::abs(R.x.z) * box->half.x -
                                    std::abs(R.y.z) * box->half.y - std::abs(R.z.z) * box->half.z);
    }
  }
  return -lowest;
}

}  // namespace sinew
