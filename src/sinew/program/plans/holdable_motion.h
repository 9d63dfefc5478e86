#pragma once

#include <memory>
#include <vector>

#include "sinew/control/motion_source.h"
#include "sinew/program/plans/row_planner.h"

namespace sinew::program {

/// A motion that comes to rest on its path soon after a hold. A streaming device is led along the
/// planned path; any other is given its pieces, and rests behind the one under way.
/// @param limits    of the planner that made it
/// @param q_start   where it begins
/// @param planned   what `motion` was made of
/// @param overlaps  links that may be too near at its begin
/// @error  of PathFollower::start()
Expected<std::unique_ptr<control::MotionSource>> holdable_motion(
    const RobotModel& limits, const JointVector& q_start, const RowMotion& motion,
    const planning::PlannedMotion& planned, double feed = 1, std::vector<LinkPair> overlaps = {});

}  // namespace sinew::program
