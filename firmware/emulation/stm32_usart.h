#pragma once

#include <deque>
#include <functional>

#include "firmware/emulation/cortex_m.h"

namespace sinew::emulation {

/// USART2 with 8 data bits and no parity, RM0008 27 and RM0368 19: a transmit register of one byte
/// in front of the shift register, a receive register of one byte, and their three interrupts.
class Stm32Usart : public Peripheral {
 public:
  /// @param bus_hz  of its clock, from which the baud rate is divided
  Stm32Usart(CortexM& core, std::uint32_t bus_hz) : core_(core), bus_hz_(bus_hz) {}

  std::uint32_t read(std::uint32_t offset) override;
  void write(std::uint32_t offset, std::uint32_t value) override;
  std::optional<Cycles> next_event() const override;
  void advance(Cycles now) override;
  void reset();

  /// A byte has left, its stop bit included.
  std::function<void(Cycles at, std::uint8_t byte)> on_byte = [](Cycles, std::uint8_t) {};
  /// Another sender's byte, behind all that were given before, at this baud rate.
  void arrive(std::uint8_t byte);
  double baud() const;

 private:
  Cycles byte_time() const;
  void begin_byte();
  void raise_due();

  CortexM& core_;
  std::uint32_t bus_hz_;
  std::uint32_t status_ = 0, brr_ = 0, cr1_ = 0;
  std::uint8_t received_ = 0, waiting_ = 0, shifting_ = 0;
  bool waits_ = false;
  std::optional<Cycles> sent_at_;  ///< of the byte in the shift register
  struct Arrival {
    Cycles at;
    std::uint8_t byte;
  };
  std::deque<Arrival> arrivals_;
};

}  // namespace sinew::emulation
