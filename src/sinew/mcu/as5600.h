#pragma once

#include <stdint.h>

// The angle sensor AS5600, data sheet v1-06: what its readers share. C11, also for the STM8.

// NOLINTNEXTLINE(performance-enum-size)
enum {
  kAs5600Address = 0x36,  // on I2C, 7 bits
  // STATUS is followed by RAW ANGLE, so one reading of three bytes from here belongs together. The
  // pointer is set each time: a chip that lost its supply has it at 0, where settings read as an
  // angle of 0.
  kAs5600First = 0x0B,
  kAs5600Size = 3,
  kAs5600MagnetDetected = 0x20,
  kAs5600MagnetTooWeak = 0x10,
  kAs5600MagnetTooStrong = 0x08,
};

/// 0..4095 of a reading.
static inline uint16_t as5600_position(const uint8_t* reading) {
  return (uint16_t)(((uint16_t)(reading[1] & 0x0F) << 8) | reading[2]);
}
