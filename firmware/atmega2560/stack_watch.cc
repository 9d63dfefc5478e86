#include "firmware/atmega2560/stack_watch.h"

#include <avr/io.h>

extern "C" {
extern uint8_t __heap_start, __stack;  // NOLINT(bugprone-reserved-identifier): the linker's names

/// Fills what the stack may use, before it is used.
__attribute__((naked, used, section(".init4"))) void paint_stack() {
  asm volatile(
      "ldi r30, lo8(__heap_start)\n"
      "ldi r31, hi8(__heap_start)\n"
      "ldi r24, 0xC5\n"
      "ldi r25, hi8(__stack)\n"
      "1: st Z+, r24\n"
      "cpi r30, lo8(__stack)\n"
      "cpc r31, r25\n"
      "brlo 1b\n");
}
}

namespace sinew {
namespace atmega {
namespace {

constexpr uint8_t kBytesAtOnce = 8;

}  // namespace

uint16_t unused_stack() {
  const uint8_t paint = 0xC5;
  static const uint8_t* place = &__heap_start;
  static const uint8_t* used = &__stack;  // the lowest that was found
  for (uint8_t left = kBytesAtOnce; left > 0; --left, ++place) {
    if (place < used && *place == paint) continue;
    used = place;
    place = &__heap_start;
    break;
  }
  return static_cast<uint16_t>(used - &__heap_start);
}

}  // namespace atmega
}  // namespace sinew
