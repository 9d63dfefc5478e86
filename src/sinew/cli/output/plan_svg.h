#pragma once

#include <string>

#include "sinew/cli/output/plan_report.h"

namespace sinew::cli {

/// Position, velocity, acceleration and jerk of each joint in a row of boxes, with what lies
/// outside of its limits shaded, and below them the tool's path from the front, the side and above;
/// of a platform also base, legs and platform at both ends, obliquely.
std::string plan_svg(const MotionPlan& plan, const std::string& title);

}  // namespace sinew::cli
