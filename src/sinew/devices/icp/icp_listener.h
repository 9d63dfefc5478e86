#pragma once

#include <memory>

#include "sinew/devices/icp/icp_settings.h"
#include "sinew/driver/wire_reader.h"

namespace sinew::wires {

std::unique_ptr<WireReader> icp_reader(const IcpDevice& device);

}  // namespace sinew::wires
