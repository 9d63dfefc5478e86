#pragma once

#include <cstdint>
#include <expected>
#include <string>

#include "sinew/program/plans/row_planner.h"

namespace sinew::program {

/// A ride: from pose to random pose, as a bull would throw whoever sits on it. Only poses that the
/// robot reaches on ways inside all its limits, chosen by a seed; it ends where it began.
struct RideOrder {
  double duration = 30;    ///< s, of motion, at most; [kRideMin, kRideMax]
  std::uint64_t seed = 1;  ///< one seed, one ride
  /// Of each joint's range, (0, 1]; 0: as much as makes lively moves in that time on this wire.
  double amplitude = 0;
};

inline constexpr double kRideMin = 1;
inline constexpr double kRideMax = 3600;

struct Ride {
  std::string text;      ///< rows of a program, one a move
  double duration = 0;   ///< s, predicted
  double amplitude = 0;  ///< that was chosen
  int moves = 0;
};

/// The largest amplitude, of each joint's range, of which a move and the way back fit into the
/// ride's time on this robot's wire.
double fitting_ride(const RobotModel& robot, const JointVector& q_start, const RideOrder& order);

/// @param q_start  where the robot stands, and will stand in the end; inside all limits
/// @error kMoveInput (a duration or amplitude that is none), kRideTime (moves of this amplitude
///        take longer than the ride), or why not even a small move from there works
std::expected<Ride, Refusal> make_ride(const RobotModel& robot, const JointVector& q_start,
                                       const RideOrder& order);

}  // namespace sinew::program
