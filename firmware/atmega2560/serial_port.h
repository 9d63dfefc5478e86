#pragma once

#include <stdint.h>

namespace sinew {
namespace atmega {

/// UART 0, 250,000 baud, 8N1: the board's USB. Bytes come and go by interrupts, through rings.
class SerialPort {
 public:
  void start();
  bool has_input() const;
  /// @pre has_input()
  uint8_t take();
  bool has_room() const;
  /// @pre has_room()
  void put(uint8_t byte);
  /// Bytes that came while the ring was full, or faster than they were taken from the chip.
  uint32_t bytes_lost() const;

  // Of the interrupts.
  void on_received();
  void on_ready();

 private:
  volatile uint8_t in_[256];
  volatile uint8_t in_first_ = 0;
  volatile uint8_t in_end_ = 0;
  volatile uint8_t out_[256];
  volatile uint8_t out_first_ = 0;
  volatile uint8_t out_end_ = 0;
  volatile uint32_t lost_ = 0;
};

}  // namespace atmega
}  // namespace sinew
