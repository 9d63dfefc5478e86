#pragma once

#include <string>

#include "sinew/model/robot_model.h"

namespace sinew::runtime {

/// The name of a joint's number where it leaves the process: "position_rad", or "position_m" of a
/// leg.
inline std::string with_unit(const char* what, const Joint& joint) {
  return std::string(what) + (joint.slides() ? "_m" : "_rad");
}

/// The name of a list of such numbers, one a joint: "position_rad", "position_m" or, where each has
/// its own unit, "position_rad_m".
inline std::string with_units(const char* what, const RobotModel& model) {
  for (const Joint& joint : model.joints) {
    if (joint.kind != model.joints[0].kind) return std::string(what) + "_rad_m";
  }
  return with_unit(what, model.joints[0]);
}

}  // namespace sinew::runtime
