#pragma once

#include <functional>
#include <memory>
#include <span>

#include "sinew/io/clock.h"
#include "sinew/io/port.h"
#include "sinew/io/spi_bus.h"
#include "sinew/model/device.h"
#include "sinew/runtime/links/byte_log.h"
#include "sinew/sim/simwire_server.h"

namespace sinew::runtime {

/// Boards behind simwire, as a host sees them; the stamps are the clock's microseconds.
/// @error  nobody answers HELLO within two seconds, another version, a line that is no reply
io::IoResult<std::unique_ptr<io::SpiBus>> connect_simwire(io::Port port,
                                                          std::span<const AxisBoard> boards,
                                                          const io::Clock& clock);

/// A machine in this very process, on the clock's time.
std::unique_ptr<io::SpiBus> bus_of(sim::SpiMachine& machine, const io::Clock& clock);

/// Answers one host's requests until it says BYE or goes away, or `stop()` says so, which is asked
/// at least every 50 ms.
/// @error  a reply could not be written
io::IoResult<void> serve_simwire(sim::SimwireServer& server, io::Port& port, ByteLog& log,
                                 const std::function<bool()>& stop);

}  // namespace sinew::runtime
