#include "firmware/atmega2560/serial_port.h"

#include <avr/io.h>

#include "sinew/mcu/interrupts.h"

namespace sinew {
namespace atmega {

using mcu::InterruptsOff;

void SerialPort::start() {
  UCSR0A = _BV(U2X0);
  UBRR0 = F_CPU / (8 * 250000UL) - 1;
  UCSR0C = _BV(UCSZ01) | _BV(UCSZ00);
  UCSR0B = _BV(RXCIE0) | _BV(RXEN0) | _BV(TXEN0);
}

bool SerialPort::has_input() const {
  return in_first_ != in_end_;
}

uint8_t SerialPort::take() {
  const uint8_t byte = in_[in_first_];
  in_first_ = static_cast<uint8_t>(in_first_ + 1);
  return byte;
}

bool SerialPort::has_room() const {
  return static_cast<uint8_t>(out_end_ + 1) != out_first_;
}

void SerialPort::put(uint8_t byte) {
  out_[out_end_] = byte;
  const InterruptsOff off;
  out_end_ = static_cast<uint8_t>(out_end_ + 1);
  UCSR0B |= _BV(UDRIE0);
}

uint32_t SerialPort::bytes_lost() const {
  const InterruptsOff off;
  return lost_;
}

void SerialPort::on_received() {
  if ((UCSR0A & _BV(DOR0)) != 0) lost_ = lost_ + 1;
  const uint8_t byte = UDR0;
  const uint8_t end = static_cast<uint8_t>(in_end_ + 1);
  if (end == in_first_) {
    lost_ = lost_ + 1;
    return;
  }
  in_[in_end_] = byte;
  in_end_ = end;
}

void SerialPort::on_ready() {
  if (out_first_ == out_end_) {
    UCSR0B &= static_cast<uint8_t>(~_BV(UDRIE0));
    return;
  }
  UDR0 = out_[out_first_];
  out_first_ = static_cast<uint8_t>(out_first_ + 1);
}

}  // namespace atmega
}  // namespace sinew
