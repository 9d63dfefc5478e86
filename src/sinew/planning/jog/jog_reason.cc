#include "sinew/planning/jog/jog_reason.h"

namespace sinew::planning {

std::string_view name(JogReason reason) {
  switch (reason) {
    case JogReason::kNone:
      return "none";
    case JogReason::kNoCommand:
      return "no_command";
    case JogReason::kStopped:
      return "stopped";
    case JogReason::kExpired:
      return "expired";
    case JogReason::kContact:
      return "contact";
    case JogReason::kOverlap:
      return "overlap";
    case JogReason::kPoseLimit:
      return "pose_limit";
    case JogReason::kJointLimit:
      return "joint_limit";
    case JogReason::kSingular:
      return "singular";
    case JogReason::kJointSpeed:
      return "joint_speed";
    case JogReason::kWire:
      return "wire";
  }
  return "none";
}

}  // namespace sinew::planning
