#pragma once

#include <optional>

#include "sinew/devices/maxarm/maxarm_wire.h"
#include "sinew/driver/device_facts.h"

namespace sinew {

/// The MaxArm's board.
struct MaxArmFacts {
  LastHeard<maxarm::Angles> angles;
  LastHeard<maxarm::Position> position;
  LastHeard<maxarm::SetAngle> set;           ///< what the servos were sent to
  std::optional<maxarm::Checksum> checksum;  ///< once two answers agree
};

}  // namespace sinew
