#pragma once

#include <string_view>

#include "sinew/planning/jog/jog.h"

namespace sinew::planning {

/// "joint_limit", for machines.
std::string_view name(JogReason reason);

}  // namespace sinew::planning
