#pragma once

#include <memory>

#include "sinew/devices/bigrobotarm/bigrobotarm_settings.h"
#include "sinew/driver/wire_reader.h"

namespace sinew::wires {

/// @param wire  the one that is spoken
std::unique_ptr<WireReader> bigrobotarm_reader(BigRobotArmWire wire);

}  // namespace sinew::wires
