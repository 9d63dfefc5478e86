#pragma once

#include <memory>

#include "sinew/devices/lsc/lsc_settings.h"
#include "sinew/driver/wire_reader.h"

namespace sinew::wires {

std::unique_ptr<WireReader> lsc_reader(const LscDevice& device);

}  // namespace sinew::wires
