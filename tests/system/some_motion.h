#pragma once

#include <memory>

#include "sinew/control/motion_source.h"
#include "sinew/model/robot_model.h"

namespace sinew::test {

/// From one place of the joints to another as this robot's device takes it: a path of segments, or
/// a whole move. Null where the planner refuses it.
std::unique_ptr<control::MotionSource> motion_to(const RobotModel& robot, const JointVector& from,
                                                 const JointVector& to);

/// A slow first move to the robot's home, for servos that nobody knows the place of.
std::unique_ptr<control::MotionSource> first_motion(const RobotModel& robot);

}  // namespace sinew::test
