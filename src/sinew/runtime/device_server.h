#pragma once

#include <functional>

#include "sinew/device/bigrobotarm.h"
#include "sinew/io/clock.h"
#include "sinew/io/port.h"
#include "sinew/runtime/byte_log.h"

namespace sinew::runtime {

/// Runs a device behind a port in real (or scaled) time until `stop()` says so, which is asked at
/// least every 50 ms. Hosts may come, go, and read nothing: replies without room are lost, as on a
/// serial line. Ends early, with the reason, when the port fails.
io::IoResult<void> serve_device(BigRobotArmFirmware& firmware, io::Port& port,
                                const io::Clock& clock, ByteLog& log,
                                const std::function<bool()>& stop);

}  // namespace sinew::runtime
