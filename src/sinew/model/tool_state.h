#pragma once

#include <algorithm>
#include <optional>

#include "sinew/model/robot_model.h"

namespace sinew {

/// What a gripper with jaws is like at one time, as far as somebody knows.
struct ToolState {
  std::optional<double> jaws = {};  ///< m between them
  std::optional<double> held = {};  ///< m: width of what is between the finger tips
  friend bool operator==(const ToolState&, const ToolState&) = default;
};

/// From the flange to the finger tips, m. @rt
inline double jaw_reach(const JawGripper& gripper, double width) {
  const double open = width / gripper.width_max;
  return gripper.reach_closed + open * (gripper.reach_open - gripper.reach_closed);
}

/// What a finger fills in tool T (without the jaws' reach) while the jaws may be anywhere between
/// two widths (m). @rt
inline CollisionBox finger_box(const JawFinger& finger, const JawGripper& gripper, double least,
                               double most) {
  const auto [near, far] = std::minmax({jaw_reach(gripper, least), jaw_reach(gripper, most)});
  const double inner = least / 2, outer = most / 2 + 2 * finger.half.y;
  const double begin = near - 2 * finger.half.z;
  CollisionBox box;
  box.X_LX.p = {0, finger.side * (inner + outer) / 2, (begin + far) / 2};
  box.half = {finger.half.x, (outer - inner) / 2, (far - begin) / 2};
  return box;
}

/// What is held, in the same frame. It may lie on what it is taken from, so it is smaller by
/// `margin` (m) all around; nothing is a point behind the tips. @rt
inline Capsule held_ball(double held, const JawGripper& gripper, double width, double margin) {
  constexpr double kPoint = 1e-4;  // m
  const double radius = std::max(kPoint, held / 2 - margin - kPoint);
  const Vec3 p_TC{0, 0, jaw_reach(gripper, width) - (held > 0 ? 0 : radius)};
  return {p_TC, p_TC, radius};
}

}  // namespace sinew
