#pragma once

#include <array>

#include "sinew/core/units.h"
#include "sinew/model/robot_model.h"

namespace sinew::test {

/// MaxArm: the lengths that its firmware was compiled with.
inline PalletizerGeometry maxarm_geometry() {
  return {.base_height = from_mm(84.4),
          .shoulder_offset = from_mm(8.14),
          .upper_arm = from_mm(128.4),
          .forearm = from_mm(138.0),
          .tool_offset = from_mm(16.8),
          .base_front = from_deg(120),
          .radius_min = from_mm(50)};
}

/// Its joints: what pulses 0..1000 can say on all three servos.
inline std::array<Joint, 3> maxarm_joints() {
  std::array<Joint, 3> joints;
  joints[0] = {.name = "base", .lower = 0, .upper = from_deg(240), .home = from_deg(120)};
  joints[1] = {.name = "shoulder", .lower = 0, .upper = from_deg(210), .home = from_deg(90)};
  joints[2] = {.name = "forearm", .lower = 0, .upper = from_deg(120), .home = 0};
  for (Joint& joint : joints) {
    joint.velocity_max = 1;
    joint.acceleration_max = 10;
    joint.jerk_max = 100;
  }
  return joints;
}

}  // namespace sinew::test
