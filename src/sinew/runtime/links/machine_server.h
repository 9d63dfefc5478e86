#pragma once

#include <functional>
#include <span>

#include "sinew/io/clock.h"
#include "sinew/io/port.h"
#include "sinew/runtime/links/byte_log.h"
#include "sinew/sim/link_fault.h"
#include "sinew/sim/machine.h"

namespace sinew::runtime {

/// The cable between a port and a simulated machine: bytes take their time at the baud rate, and
/// what the fault plan says befalls them. Blows to the machine come at their moments.
struct SimulatedCable {
  std::uint32_t baud = 0;  ///< 8N1: ten bits a byte; 0: no time at all
  sim::FaultPlan faults;
};

struct ServeHooks {
  /// Asked at least every 50 ms.
  std::function<bool()> stop;
  /// Called as often, for whoever wants to look at the machine.
  std::function<void(Instant)> look;
  /// Longest real time between two looks.
  Duration slice = std::chrono::milliseconds(50);
};

/// Runs a machine behind a port in real (or scaled) time until `stop` says so. Hosts may come, go,
/// and read nothing: replies without room are lost, as on a serial line. Ends early, with the
/// reason, when the port fails. @return what befell the bytes, to the device and to the host
io::IoResult<std::array<sim::LinkCounts, 2>> serve_machine(sim::ByteMachine& machine,
                                                           io::Port& port, const io::Clock& clock,
                                                           const SimulatedCable& cable,
                                                           ByteLog& log, const ServeHooks& hooks);

}  // namespace sinew::runtime
