#pragma once

#include "sinew/cli/output/outcome.h"
#include "sinew/kinematics/serial_arm.h"

namespace sinew::cli {

/// Adds the DH table at q, each X_{i-1,i}, each X_0i, and the parts that pencil-and-paper
/// derivations use: X_03, its inverse, X_3n, and the tool.
void add_frames(Outcome& outcome, const RobotModel& model, const kinematics::SerialArm& arm,
                const JointVector& q);

}  // namespace sinew::cli
