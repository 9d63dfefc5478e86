#pragma once

#include "sinew/cli/plans/plan_verb.h"

namespace sinew::cli {

/// `sinew plan PROGRAM --in-cell CELL.toml`: one picture of the cell's camera, and what the program
/// would do with the cubes in it: which it picks, in which order, how, and where each goes; why
/// others not. Nothing moves, and no robot is opened.
Outcome dry_run(const PlanRequest& request);

}  // namespace sinew::cli
