#pragma once

#include <expected>
#include <vector>

#include "sinew/planning/studies/drive_train.h"
#include "sinew/planning/studies/inverse_dynamics.h"
#include "sinew/program/plans/program_plan.h"

namespace sinew::program {

/// What a program asks of one joint; Nm at the joint (N at a leg), counted as
/// planning::DriveTrain does.
struct JointLoad {
  double peak = 0;       ///< where it is the largest share of what the motors give
  double available = 0;  ///< there
  int line = 0;          ///< of the program, there
  double time = 0;       ///< s since the program's first order, there
  double rms = 0;        ///< over the whole program, waiting counted

  double margin() const { return available / peak; }
};

/// A plan on the drives of its robot, looked at every 5 ms, or as often as half a million looks
/// allow. While it waits, a joint holds its weight; homing is not counted.
///
/// @param plan      made with a known start
/// @param dynamics  of the robot, with its payload
/// @param drives    one per joint
/// @error           those of InverseDynamics::torque(), with the line where they happen
std::expected<std::vector<JointLoad>, Refusal> load_of(
    const Plan& plan, const RobotModel& robot, const planning::InverseDynamics& dynamics,
    std::span<const planning::DriveTrain> drives);

}  // namespace sinew::program
