#pragma once

#include <string>
#include <vector>

#include "sinew/model/robot_model.h"
#include "sinew/program/plans/row_planner.h"

namespace sinew::program {

/// What would work instead of a refused move, in words that can be typed: a row of a program, or
/// behind --to. Each one is tried with its numbers as they are printed before it is offered.
/// @param in_program  else on the command line
std::vector<std::string> offers(const WayRefusal& way, const RobotModel& model,
                                bool in_program = true);

}  // namespace sinew::program
