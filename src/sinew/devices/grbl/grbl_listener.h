#pragma once

#include <memory>

#include "sinew/driver/wire_reader.h"

namespace sinew::wires {

std::unique_ptr<WireReader> grbl_reader();

}  // namespace sinew::wires
