#pragma once

#include <algorithm>
#include <optional>
#include <string_view>

#include "sinew/model/robot_model.h"

/// The links that collision shapes stand on. A robot of n joints has n + 2 of them:
///
///   0      "stand"        fixed in base B
///   1..n   the joint's    what moves with that joint; of a hexapod the leg
///   n + 1  "tool"         fixed in tool T (jaws fully open: without a gripper's reach);
///          "platform"     of a hexapod: fixed in platform P
///
/// Frames of 1..n: of a chain the one that the joint's DH row ends with; of a palletizer those of
/// kinematics::palletizer_links(); a leg has none, its capsule follows its anchors.
namespace sinew {

inline constexpr std::string_view kStandName = "stand";
inline constexpr std::string_view kToolName = "tool";
inline constexpr std::string_view kPlatformName = "platform";
inline constexpr std::string_view kTableName = "table";
inline constexpr std::string_view kObstacleName = "obstacle";

inline std::size_t link_count(const RobotModel& model) {
  return model.joints.size() + 2;
}

inline bool is_leg(const RobotModel& model, std::size_t link) {
  return std::holds_alternative<HexapodGeometry>(model.geometry) && link >= 1 && link <= kLegs;
}

/// @param link  below link_count(), kTableLink or kObstacleLink
inline std::string_view link_name(const RobotModel& model, std::size_t link) {
  if (link == kTableLink) return kTableName;
  if (link == kObstacleLink) return kObstacleName;
  if (link == 0) return kStandName;
  if (link <= model.joints.size()) return model.joints[link - 1].name;
  return std::holds_alternative<HexapodGeometry>(model.geometry) ? kPlatformName : kToolName;
}

/// The other way round; nothing for a name that this robot does not have.
inline std::optional<std::uint8_t> link_named(const RobotModel& model, std::string_view name) {
  if (name == kTableName) return kTableLink;
  for (std::size_t link = 0; link < link_count(model); ++link) {
    if (link_name(model, link) == name) return static_cast<std::uint8_t>(link);
  }
  return std::nullopt;
}

/// Whether two links are joined, or one: then they touch in every pose, and are never held against
/// each other. The table belongs to the stand; links that a tool or platform is bolted to are one
/// with it.
inline bool links_joined(const RobotModel& model, std::size_t first, std::size_t second) {
  if (std::holds_alternative<HexapodGeometry>(model.geometry)) {
    if (first == kTableLink) first = 0;
    if (second == kTableLink) second = 0;
    return first == second || is_leg(model, first) != is_leg(model, second);
  }
  const bool bolted = std::holds_alternative<SerialGeometry>(model.geometry);
  const auto body = [&](std::size_t link) {
    if (link == kTableLink) return std::size_t{0};
    return bolted ? std::min(link, model.joints.size()) : link;
  };
  const std::size_t a = body(first), b = body(second);
  return a <= b ? b - a <= 1 : a - b <= 1;
}

}  // namespace sinew
