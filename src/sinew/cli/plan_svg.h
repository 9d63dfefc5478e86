#pragma once

#include <string>

#include "sinew/cli/plan_report.h"

namespace sinew::cli {

/// Position, velocity, acceleration and jerk of each joint in a row of boxes, with what lies
/// outside of its limits shaded, and below them the tool's way from the front, the side and above.
std::string plan_svg(const MotionPlan& plan, const std::string& title);

}  // namespace sinew::cli
