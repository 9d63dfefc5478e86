#pragma once

#include <cstdint>
#include <deque>
#include <functional>

#include "firmware/emulation_avr/avr_board.h"

namespace sinew::arduino {

using emulation::AvrBoard;
using emulation::AvrChip;

/// Cable between an emulated board and an arm: 9600 baud, 8N1.
class ArmCable {
 public:
  virtual ~ArmCable() = default;
  /// Bytes to the board, one behind the other.
  virtual void send(std::uint8_t byte) = 0;

  /// A byte from the board.
  std::function<void(std::uint8_t)> received;
};

/// Two pins of the chip (SoftwareSerial): levels driven and sampled at exact cycles.
class PinCable : public ArmCable {
 public:
  /// @param tx  @param rx  as the board names them
  PinCable(AvrBoard& board, char port, int tx, int rx);
  void send(std::uint8_t byte) override;

  std::uint64_t framing_errors() const { return framing_errors_; }
  /// Largest timing error of an edge from the board, in bits.
  double edge_error_max() const { return edge_error_max_; }

 private:
  void on_edge(bool level);
  std::optional<std::uint64_t> sample();
  std::optional<std::uint64_t> drive();

  AvrBoard& board_;
  char port_;
  int rx_;

  bool level_ = true;
  bool in_byte_ = false;
  std::uint64_t start_ = 0;  ///< of the byte from the board
  int bit_ = 0;
  unsigned bits_ = 0;
  std::uint64_t framing_errors_ = 0;
  double edge_error_max_ = 0;

  std::deque<std::uint8_t> queue_;
  std::uint64_t out_start_ = 0;  ///< of the byte to the board
  int out_bit_ = 0;
  bool driving_ = false;
};

/// A USART of the chip.
class UartCable : public ArmCable {
 public:
  UartCable(AvrBoard& board, char uart);
  void send(std::uint8_t byte) override;

 private:
  std::optional<std::uint64_t> deliver();

  AvrBoard& board_;
  char uart_;
  std::deque<std::uint8_t> queue_;
  bool delivering_ = false;
};

}  // namespace sinew::arduino
