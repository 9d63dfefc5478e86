#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

namespace sinew::stm32 {

/// USART2 behind an RS-485 transceiver: 115200 baud, 8 data bits, no parity. Bytes come and go by
/// interrupts; the transceiver drives the line only while bytes leave, and nothing is received
/// then.
class SerialLine {
 public:
  static constexpr std::size_t kSendMax = 8;

  void start();
  /// Replaces what has not left yet. @pre bytes.size() <= kSendMax
  void send(std::span<const std::uint8_t> bytes);
  /// Moves out what arrived, oldest first; how many bytes. What finds no room is dropped.
  std::size_t take(std::span<std::uint8_t> out);

  void on_interrupt();

 private:
  static constexpr std::uint8_t kRing = 16;

  std::array<std::uint8_t, kSendMax> out_{};
  std::uint8_t out_size_ = 0;
  std::uint8_t sent_ = 0;
  bool sending_ = false;
  std::array<std::uint8_t, kRing> in_{};
  std::uint8_t head_ = 0;  ///< counts what arrived
  std::uint8_t tail_ = 0;  ///< counts what was taken
};

}  // namespace sinew::stm32
