#pragma once

#include <avr/io.h>

// Pins of an MKS Gen L, which are those of a RAMPS board on an Arduino Mega. In the order of the
// axes: base, shoulder, elbow, wrist rotate, wrist.

namespace sinew {
namespace atmega {

inline void start_pins() {
  // Step: A0 (PF0), A6 (PF6), 46 (PL3), 26 (PA4), 36 (PC1).
  // Direction: A1 (PF1), A7 (PF7), 48 (PL1), 28 (PA6), 34 (PC3).
  // Enable: 38 (PD7), A2 (PF2), A8 (PK0), 24 (PA2), 30 (PC7); low is on.
  PORTF = 0;
  PORTL = 0;
  PORTA = 0;
  PORTC = 0;
  DDRF = _BV(0) | _BV(1) | _BV(2) | _BV(6) | _BV(7);
  DDRL = _BV(1) | _BV(3);
  DDRA = _BV(2) | _BV(4) | _BV(6);
  DDRC = _BV(1) | _BV(3) | _BV(7);
  DDRD = _BV(7);
  DDRK = _BV(0);
  // Servo: 3 (PE5). Stop line: 2 (PE4), a switch to ground. LED: 13 (PB7).
  DDRE = _BV(5);
  PORTE = _BV(4);
  DDRB = _BV(7);
}

/// Step outputs up, where an axis has its bit.
inline void raise_steps(uint8_t axes) {
  if ((axes & 1) != 0) PORTF |= _BV(0);
  if ((axes & 2) != 0) PORTF |= _BV(6);
  if ((axes & 4) != 0) PORTL |= _BV(3);
  if ((axes & 8) != 0) PORTA |= _BV(4);
  if ((axes & 16) != 0) PORTC |= _BV(1);
}

inline void lower_steps() {
  PORTF &= static_cast<uint8_t>(~(_BV(0) | _BV(6)));
  PORTL &= static_cast<uint8_t>(~_BV(3));
  PORTA &= static_cast<uint8_t>(~_BV(4));
  PORTC &= static_cast<uint8_t>(~_BV(1));
}

inline void set_directions(uint8_t backwards) {
  if ((backwards & 1) != 0)
    PORTF |= _BV(1);
  else
    PORTF &= static_cast<uint8_t>(~_BV(1));
  // The shoulder's motor is mounted the other way round.
  if ((backwards & 2) == 0)
    PORTF |= _BV(7);
  else
    PORTF &= static_cast<uint8_t>(~_BV(7));
  if ((backwards & 4) != 0)
    PORTL |= _BV(1);
  else
    PORTL &= static_cast<uint8_t>(~_BV(1));
  if ((backwards & 8) != 0)
    PORTA |= _BV(6);
  else
    PORTA &= static_cast<uint8_t>(~_BV(6));
  if ((backwards & 16) != 0)
    PORTC |= _BV(3);
  else
    PORTC &= static_cast<uint8_t>(~_BV(3));
}

inline bool stop_line_low() {
  return (PINE & _BV(4)) == 0;
}

inline void set_led(bool on) {
  if (on)
    PORTB |= _BV(7);
  else
    PORTB &= static_cast<uint8_t>(~_BV(7));
}

}  // namespace atmega
}  // namespace sinew
