#pragma once

#include <span>
#include <string>

#include "sinew/model/robot_model.h"

namespace sinew::program {

/// Where a machine was, on its way through somebody's hands.
struct WaySample {
  double t = 0;   ///< s, rising
  JointVector q;  ///< rad, m of legs; as measured, or as it was sent
};

struct WayOptions {
  double tolerance = 0.01;        ///< rad: no joint comes farther from the way that was recorded
  double leg_tolerance = 0.2e-3;  ///< m
  double rest_min = 0.5;          ///< s: a shorter stand is none
};

/// Joints that move by less than this (rad, m) within WayOptions::rest_min stand: what sensors say
/// of an arm at rest.
inline constexpr double kWayStill = 2e-3;
inline constexpr double kWayStillLeg = 0.03e-3;

/// A recorded way as a program's rows.
struct WayRows {
  std::string text;         ///< rows that name all joints; empty where nothing moved
  std::size_t outside = 0;  ///< places that were outside the limits, and were moved to them
  double outside_max = 0;   ///< rad, m of legs: by how much, at the most
};

/// A recorded way as rows: corners where the way bends by more than the tolerance, `blend` between
/// them, a speed that takes about as long, and a `wait` where it stood. Places outside the limits,
/// by what a sensor may show, are moved to them.
/// @param way  one place a joint; in the order of time. Stands at both ends are left out
WayRows rows_of_way(std::span<const WaySample> way, const RobotModel& robot,
                    const WayOptions& options = {});

}  // namespace sinew::program
