#pragma once

#include <memory>

#include "sinew/driver/wire_reader.h"

namespace sinew::wires {

/// DeviceKind::listener.
std::unique_ptr<WireReader> arm_link_reader();

}  // namespace sinew::wires
