#pragma once

#include "firmware/stm32/steps.h"
#include "sinew/devices/axis/axis_device_setup.h"

namespace sinew::stm32 {

/// The flash behind the program: the last two pages of the F103, sectors 4 and 5 of the F401. While
/// a place is erased the processor stands still (40 ms, and up to 2 s on the F401), so nothing may
/// move; the watchdog waits for it.
class SetupFlash : public SetupMemory {
 public:
  /// @param steps  end before the processor stands still: timers would repeat what they made last
  explicit SetupFlash(Steps& steps) : steps_(steps) {}
  std::span<const std::uint8_t> place(int which) const override;
  bool erase(int which) override;
  bool append(int which, std::span<const std::uint8_t> bytes) override;

 private:
  Steps& steps_;
};

/// A hang of the loop ends in a reset after 0.1 s; for a while it may take longer.
void start_watchdog();
void feed_watchdog();

}  // namespace sinew::stm32
