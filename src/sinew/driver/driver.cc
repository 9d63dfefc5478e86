#include "sinew/driver/driver.h"

#include "sinew/core/error_code.h"

namespace sinew {

// What a device that cannot do it answers.

Expected<void> Driver::nudge(std::size_t, double, Duration, Instant) {
  return std::unexpected(Error{ErrorCode::kTaskNotSupported});
}

Expected<void> Driver::probe(std::size_t, double, Duration, Instant) {
  return may_probe();
}

Expected<void> Driver::may_probe() const {
  return std::unexpected(Error{ErrorCode::kNoProbe});
}

Expected<void> Driver::home(Instant, std::uint8_t) {
  return std::unexpected(Error{ErrorCode::kTaskNotSupported});
}

Expected<void> Driver::tool(const ToolAction&, Instant) {
  return std::unexpected(Error{ErrorCode::kToolNotFitted});
}

Expected<void> Driver::zero_counters(Instant) {
  return std::unexpected(Error{ErrorCode::kNoSuchService});
}

Expected<void> Driver::service(DeviceService, Instant) {
  return std::unexpected(Error{ErrorCode::kNoSuchService});
}

}  // namespace sinew
