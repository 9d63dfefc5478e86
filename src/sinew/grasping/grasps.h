#pragma once

#include <cstddef>
#include <expected>
#include <span>
#include <vector>

#include "sinew/core/error.h"
#include "sinew/grasping/cube.h"
#include "sinew/model/robot_model.h"

/// Where a tool takes a cube among others: the cubes' side of it, without the arm's. What the arm
/// can reach, and hits nothing on, is planned by whoever carries it out.
namespace sinew::grasping {

/// m, that jaws are sent to less than the cube between them.
inline constexpr double kSqueeze = 3e-3;

/// m, that tools stay clear of other cubes: the places of what is seen are off by so much.
inline constexpr double kApart = 3e-3;

/// Jaws around a cube, of an arm whose tool stays in the vertical plane through its first axis.
struct JawGrasp {
  /// rad, of the approach axis from straight up: pi is straight down, with more it leans back to
  /// the base.
  double pitch = 0;
  double roll = 0;   ///< rad; R_BT = Rz(yaw) Ry(pitch) Rz(roll), yaw the direction of the plane
  double open = 0;   ///< m between the jaws on the way down
  double close = 0;  ///< m that they are sent to: less than the cube, so that they press
  Vec3 p_BT;         ///< m, of the tips of the jaws opened so far
  double room = 0;   ///< m, beside the fingers of the open jaws, at least
};

/// All grasps of a cube by the jaws of `robot`, those with the least tilt first, of tight ones 4
/// deg for each mm that they lack; behind them those that hold it higher or lower than is good.
/// Closing tips go on along the approach axis. The swept fingers and the hand stay 3 mm clear of
/// all others.
/// @param robot  with jaws; asserted
/// @param others  what is no cube, and is in the way like one
/// @error kCubeCovered, kCubeCrowded, kCubeTooWide
Expected<std::vector<JawGrasp>> jaw_grasps(const RobotModel& robot, std::span<const Cube> cubes,
                                           std::size_t which, std::span<const Body> others = {});

/// Where the lip of a suction cup goes: the middle of the top face, m in B.
/// @error kCubeCovered, kCubeCrowded
Expected<Vec3> cup_grasp(std::span<const Cube> cubes, std::size_t which,
                         std::span<const Body> others = {});

/// The cubes in the order in which they are taken: those that none stands on, the nearest to the
/// base first; then the others.
std::vector<std::size_t> order_of(std::span<const Cube> cubes);

}  // namespace sinew::grasping
