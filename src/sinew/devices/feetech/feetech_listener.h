#pragma once

#include <memory>

#include "sinew/devices/feetech/feetech_settings.h"
#include "sinew/driver/wire_reader.h"

namespace sinew::wires {

std::unique_ptr<WireReader> feetech_reader(const FeetechDevice& device);

}  // namespace sinew::wires
