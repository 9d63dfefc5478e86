#pragma once

#include <stdint.h>

#ifdef __AVR__
#include <avr/interrupt.h>
#include <avr/io.h>
#endif

namespace sinew {
namespace mcu {

/// While this lives no interrupt comes between two lines of the program. Nothing on a host, where
/// one thread calls all.
class InterruptsOff {
 public:
#ifdef __AVR__
  InterruptsOff() : status_(SREG) { cli(); }
  ~InterruptsOff() {
    // What was written meanwhile is in memory before an interrupt may come.
    asm volatile("" ::: "memory");
    SREG = status_;
  }
#else
  InterruptsOff() : status_(0) {}
  ~InterruptsOff() { static_cast<void>(status_); }
#endif
  InterruptsOff(const InterruptsOff&) = delete;
  InterruptsOff& operator=(const InterruptsOff&) = delete;

 private:
  uint8_t status_;
};

}  // namespace mcu
}  // namespace sinew
