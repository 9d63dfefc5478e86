#pragma once

#include <string_view>

#include "sinew/mcu/arm_link.h"

/// What the arm link says, in names for machines.
namespace sinew::arm_link {

constexpr std::string_view name(mcu::arm_link::Kind kind) {
  constexpr std::string_view kNames[mcu::arm_link::kKinds] = {
      "read",    "hello",     "segment",  "stop",      "release",
      "gripper", "positions", "identity", "statistics"};
  return kNames[static_cast<std::size_t>(kind)];
}

constexpr std::string_view name(mcu::arm_link::Fault fault) {
  constexpr std::string_view kNames[mcu::arm_link::kFaults] = {
      "none", "stop_asked", "host_silent", "queue_empty", "stop_line", "refused_frame", "restart"};
  return kNames[static_cast<std::size_t>(fault)];
}

constexpr std::string_view name(mcu::arm_link::Reference reference) {
  constexpr std::string_view kNames[] = {"power_up", "kept", "kept_in_motion", "set"};
  return kNames[static_cast<std::size_t>(reference)];
}

}  // namespace sinew::arm_link
