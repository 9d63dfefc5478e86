#pragma once

#include <string>

#include "sinew/model/robot_model.h"

namespace sinew::runtime {

/// The name of a joint's number where it leaves the process: "position_rad", or "position_m" of a
/// leg.
inline std::string with_unit(const char* what, const Joint& joint) {
  return std::string(what) + (joint.kind == JointKind::kPrismatic ? "_m" : "_rad");
}

}  // namespace sinew::runtime
