#pragma once

#include "firmware/stm32/board.h"
#include "firmware/stm32/chip.h"

namespace sinew::stm32 {

inline bool level(board::Place place) {
  return (chip::gpio(place.port).idr >> place.pin & 1) != 0;
}
inline void set_level(board::Place place, bool high) {
  chip::gpio(place.port).bsrr = high ? 1U << place.pin : 1U << (place.pin + 16);
}
/// Drives the pin, from its first moment on with this level.
inline void set_output(board::Place place, bool high) {
  set_level(place, high);
  chip::set_pin(place.port, place.pin, chip::Pin::kOutput);
}

}  // namespace sinew::stm32
