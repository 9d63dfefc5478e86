#pragma once

#include <cstdint>

#include "firmware/stm32/pins.h"

namespace sinew::stm32 {

/// The incremental encoder of the joint, counted by TIM2: four counts a pulse.
class QuadratureCounter {
 public:
  void start() {
    for (const board::Place pin : {board::kEncoderA, board::kEncoderB}) {
      chip::set_pin(pin.port, pin.pin, chip::Pin::kFunctionInput, chip::kTimer2Function);
    }
    tim2().arr = 0xFFFF;
    tim2().ccmr1 =
        0b0011'0001U << 8 | 0b0011'0001U;  // both channels are inputs, eight samples alike
    tim2().smcr = 0b011;                   // both edges of both
    tim2().cr1 = 1;
  }
  /// Since start, signed; called more often than the counter of 16 bits goes half round.
  std::int32_t counts() {
    const auto now = static_cast<std::uint16_t>(tim2().cnt);
    counts_ += static_cast<std::int16_t>(now - last_);
    last_ = now;
    return counts_;
  }

 private:
  std::int32_t counts_ = 0;
  std::uint16_t last_ = 0;
};

}  // namespace sinew::stm32
