#pragma once

#include <array>

#include "sinew/devices/icp/icp_wire.h"
#include "sinew/driver/device_facts.h"
#include "sinew/model/robot_model.h"

namespace sinew {

/// The hexapod's motor modules.
struct IcpFacts {
  struct Leg {
    LastHeard<icp::Status> status;
    /// The last one that told of trouble: a module forgets its flags as it tells them.
    LastHeard<icp::Status> troubled;
  };
  std::array<Leg, kLegs> legs;
};

}  // namespace sinew
