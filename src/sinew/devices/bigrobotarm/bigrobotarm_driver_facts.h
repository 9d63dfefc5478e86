#pragma once

#include "sinew/devices/bigrobotarm/bigrobotarm_settings.h"
#include "sinew/devices/bigrobotarm/bigrobotarm_wire.h"
#include "sinew/driver/device_facts.h"

namespace sinew {

/// The BigRobotArm's board.
struct BigRobotArmFacts {
  BigRobotArmWire wire{};
  BigRobotArmDialect dialect{};
  LastHeard<bigrobotarm::Status> status{};
  bool looks_like_boot = false;    ///< it holds what a board holds that was switched on
  bool wants_declaration = false;  ///< no move before its position is declared
};

}  // namespace sinew
