#pragma once

#include <memory>

#include "sinew/runtime/links/driver_line.h"
#include "sinew/sim/machine.h"

namespace sinew::runtime {

/// A driver of bytes and its simulated device, back to back in simulated time: each byte takes as
/// long as on the wire, and both see each instant at which something happens, however late this
/// computer is.
/// @param clock  a simulated one; driver, machine, clock and log outlive the line
std::unique_ptr<DriverLine> simulated_line(ByteDriver& driver, sim::ByteMachine& machine,
                                           std::uint32_t baud, const io::Clock& clock,
                                           ByteLog& log);

}  // namespace sinew::runtime
