#pragma once

#include <memory>

#include "sinew/devices/axis_registers/axis_registers_settings.h"
#include "sinew/driver/wire_reader.h"

namespace sinew::wires {

std::unique_ptr<WireReader> axis_registers_reader(const AxisRegistersDevice& device);
std::unique_ptr<WireReader> axis_link_reader();

}  // namespace sinew::wires
