#pragma once

#include <expected>
#include <optional>
#include <vector>

#include "sinew/planning/collision/collision.h"
#include "sinew/program/plans/row_planner.h"

namespace sinew::program {

/// One motion on the way from where homing left the joints to the robot's home.
struct HomeLeg {
  RowMotion motion;
  planning::PlannedMotion planned;
  std::vector<LinkPair> overlaps{};  ///< where it begins
  bool slow = false;                 ///< out of them, where the device hears of a speed
};

/// What `home` ends with: each joint rests beside its end stop then, all of them at once a pose
/// that nobody chose, and the robot goes to its home from there.
struct HomeReturn {
  std::vector<HomeLeg> legs;
  double duration = 0;  ///< s, until the driver has told that it is done
  /// What was nearest where homing left the joints, where that is nearer than the robot's margin.
  std::optional<planning::Clearance> overlap;
  JointVector q_start;  ///< where homing leaves the joints
  /// The robot's home; q_start where a joint is left out and no way is clear of it.
  JointVector q_end;
};

/// The way home. Bodies that are too near to each other at its beginning may be so for a while:
/// the arm really stands there, so its model is what is wrong, and it must leave. Then one joint
/// after the other goes home, slowly, as few of them as will do: each leg leaves no more pairs of
/// bodies too near than it began with (with two bodies go those between the
/// stand and the one, and those that the other carries), those that come
/// clear of each other stay so, and all others keep their margin everywhere. Once all are clear the
/// remaining joints go home together.
///
/// @param q     inside the limits of all joints
/// @param line  of the `home` row
/// @error  of RowPlanner::plan() for all joints at once, where no way leads out
std::expected<HomeReturn, Refusal> home_return(const RobotModel& robot, const JointVector& q,
                                               int line);

}  // namespace sinew::program
