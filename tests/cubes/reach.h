#pragma once

#include <optional>
#include <span>
#include <string>
#include <vector>

#include "sinew/grasping/cube.h"
#include "sinew/model/robot_model.h"
#include "sinew/planning/collision/shape_distance.h"

/// Whether an arm can take a cube, by trying all grasps: a second opinion of what the product
/// refuses, with the arm's kinematics and collision shapes, and none of the product's planning.
namespace sinew::cubes {

/// Whether any grasp takes cubes[which]: of jaws both pairs of faces, tilts to 50 deg both ways,
/// heights and openings by the millimetre; of a cup all of a top's middle. The arm goes 20 mm
/// straight down to it inside its limits, clear of its table and itself, and hand and fingers keep
/// clear of all other cubes and of `fixed`.
/// @param fixed  what else is there, in base B
/// @param slack  m: what the product may be wrong by about places. All clearances grow by it, and
///               the cube can be taken in the corners of a square of that half edge, too
bool can_take(const RobotModel& robot, std::span<const grasping::Cube> cubes,
              std::span<const planning::PlacedBox> fixed, std::size_t which, double slack);

/// Those that can be taken one after the other, each out of the way of the next.
std::vector<bool> can_be_taken(const RobotModel& robot, std::span<const grasping::Cube> cubes,
                               std::span<const planning::PlacedBox> fixed, double slack);

}  // namespace sinew::cubes
