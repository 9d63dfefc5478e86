#pragma once

#include "sinew/planning/paths/moves.h"
#include "sinew/program/language/program_file.h"

namespace sinew::program {

/// A goal with what its row adds to it.
/// @param target  the goal without its offset; where nothing was named, where the tool is
planning::ToolTarget with_offset(const ToolGoal& goal, const planning::ToolTarget& target,
                                 const planning::ToolSpace& space);

/// A taught place as a goal on this robot.
ToolGoal goal_of(const ToolPlace& place);

}  // namespace sinew::program
