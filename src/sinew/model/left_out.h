#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>

#include "sinew/model/robot_model.h"

/// Joints that are left out by choice (`without = ["J3"]`): their boards are missing, nothing is
/// ever sent to them, and their positions stay unknown. Plans carry a fixed number for such a
/// joint, which no motion changes; collision checks take it for anywhere within its limits.
namespace sinew {

/// AxisBoard::homing_place of a board that is left out.
inline constexpr std::uint8_t kLeftOut = 255;

/// @rt
inline bool is_left_out(std::span<const AxisBoard> boards, std::size_t joint) {
  return joint < boards.size() && boards[joint].homing_place == kLeftOut;
}
/// @rt
inline bool is_left_out(const RobotModel& model, std::size_t joint) {
  return is_left_out(boards_of(model.device), joint);
}

/// The first joint that is left out; nothing where all take part. @rt
inline std::optional<std::size_t> first_left_out(const RobotModel& model) {
  for (std::size_t i = 0; i < model.joints.size(); ++i) {
    if (is_left_out(model, i)) return i;
  }
  return std::nullopt;
}

/// What plans say of a joint that is left out. @rt
inline double assumed_place(const Joint& joint) {
  return std::clamp(joint.home, joint.lower, joint.upper);
}

}  // namespace sinew
