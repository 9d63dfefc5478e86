#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <variant>
#include <vector>

#include "sinew/core/pose.h"

namespace sinew {

/// All points within `radius` of the straight line between two points; a ball where they are one.
struct Capsule {
  Vec3 p_LA;          ///< m, in the link's frame L
  Vec3 p_LB;          ///< m
  double radius = 0;  ///< m, > 0
};

/// A box, sharp edges included.
struct CollisionBox {
  Pose<frame::Link, frame::Box> X_LX;  ///< its middle, along its edges
  Vec3 half;                           ///< half of each edge, m, > 0
};

/// The capsule from a leg's base anchor to its platform anchor, as long as the leg is now.
struct LegCapsule {
  double radius = 0;  ///< m, > 0
};

/// One finger of a gripper with jaws, in tool T: its end is at the finger tips, its inner face at
/// half the width between the jaws. Its place follows that width: model/tool_state.h.
struct JawFinger {
  Vec3 half;        ///< half of each edge, m, > 0; y across the jaws, z along the approach axis
  double side = 1;  ///< 1: the one towards +y, -1: the other one
};

/// What the jaws hold: a ball around the finger tips' middle, as large as somebody says. It may be
/// turned in any way against the tool.
struct HeldBall {};

/// A piece of a robot's body. Links are counted as model/collision_links.h says.
struct CollisionShape {
  std::uint8_t link = 0;
  /// LegCapsule on legs, and only there; JawFinger and HeldBall on a gripper's tool only.
  std::variant<Capsule, CollisionBox, LegCapsule, JawFinger, HeldBall> form;
};

/// Stands for the table where a link is named.
inline constexpr std::uint8_t kTableLink = 255;
/// Stands for something beside the robot that is no robot.
inline constexpr std::uint8_t kObstacleLink = 254;

/// Two links whose shapes are not held against each other.
struct LinkPair {
  std::uint8_t first = 0;
  std::uint8_t second = 0;
};

/// Whether these pairs name these two links, in either order.
inline bool holds(std::span<const LinkPair> pairs, std::size_t first, std::size_t second) {
  return std::ranges::any_of(pairs, [&](const LinkPair& pair) {
    return (pair.first == first && pair.second == second) ||
           (pair.first == second && pair.second == first);
  });
}

inline constexpr std::size_t kCollisionShapesMax = 24;

/// What a robot must not hit itself and its table with; empty where nobody said.
struct Collision {
  std::vector<CollisionShape> shapes;  ///< at most kCollisionShapesMax
  std::optional<double> table_height;  ///< m, z in base B: everything below is solid
  std::vector<LinkPair> ignored;       ///< beside links that are joined
  double margin = 0;                   ///< m, how near things may come
};

}  // namespace sinew
