#pragma once

#include <array>
#include <cstdint>
#include <string>

#include "sinew/core/error.h"

namespace sinew::planning {

/// What random sequences have seen. Shares are of what is allowed: 1 is the limit itself.
struct MotionSums {
  std::uint64_t sequences = 0;
  std::uint64_t commands = 0;
  std::uint64_t samples = 0;
  std::uint64_t plans = 0;
  std::uint64_t blends = 0;  ///< corners that a plan went around
  std::uint64_t jogs = 0;
  std::uint64_t takeovers = 0;  ///< jogs that began in the middle of a planned motion
  std::uint64_t stops = 0;
  std::uint64_t outside = 0;  ///< starts with a joint outside its limits
  std::uint64_t ways_in = 0;  ///< plans from there
  std::uint64_t contact_looks = 0;
  std::array<std::uint64_t, 256> refused{};  ///< by code

  double beyond = 0;  ///< rad or m outside of limits of position
  double velocity = 0;
  double acceleration = 0;
  double jerk = 0;
  double tool_speed = 0;
  double tool_acceleration = 0;
  double stop_time = 0;   ///< of what was predicted
  double jog_inside = 0;  ///< m that a jog came inside the margin

  void count(const Error& error) { ++refused[static_cast<std::uint8_t>(error.code)]; }
  void add(const MotionSums& other);
  /// In one line.
  std::string text() const;
};

}  // namespace sinew::planning
