#include "firmware/stm8s103/i2c_master.h"

#include "firmware/stm8s103/registers.h"

enum {
  kClockPin = 1 << 4,
  kDataPin = 1 << 5,
  // CR1
  kOn = 1 << 0,
  // CR2
  kStart = 1 << 0,
  kStop = 1 << 1,
  kAcknowledge = 1 << 2,
  kReset = 1 << 7,
  // SR1
  kStarted = 1 << 0,
  kAddressSent = 1 << 1,
  kByteDone = 1 << 2,
  kReceived = 1 << 6,
  // SR2: bus error, arbitration lost, no acknowledge
  kFailed = 0x07,
  // Polls of one whole transaction, some 1.5 us each; 100 are enough for a chip that answers.
  kPatience = 240,
};

static uint8_t patience;

/// 5 us and the call: half a clock of less than 100 kHz.
static void half_clock(void) {
  uint8_t i;
  for (i = 0; i < 16; ++i) __asm__("nop");
}

/// Nine clocks release a chip that holds the data line in the middle of a byte, the stop ends its
/// transaction. UM10204 3.1.16. With the peripheral off the pins are ports; both are true open
/// drains (data sheet, "pin descriptions").
static void free_bus(void) {
  uint8_t i;
  I2C_CR1 = 0;
  PB_ODR |= kDataPin;
  for (i = 0; i < 9; ++i) {
    PB_ODR &= (uint8_t)~kClockPin;
    half_clock();
    PB_ODR |= kClockPin;
    half_clock();
  }
  PB_ODR &= (uint8_t)~kClockPin;
  half_clock();
  PB_ODR &= (uint8_t)~kDataPin;
  half_clock();
  PB_ODR |= kClockPin;
  half_clock();
  PB_ODR |= kDataPin;
  half_clock();
}

void i2c_start(void) {
  PB_ODR |= kClockPin | kDataPin;
  PB_DDR |= kClockPin | kDataPin;
  free_bus();
  I2C_CR2 = kReset;
  I2C_CR2 = 0;
  I2C_FREQR = 16;
  // Fast mode, low twice as long as high: 16 MHz / (3 x 14) = 381 kHz.
  I2C_CCRL = 14;
  I2C_CCRH = 0x80;
  I2C_TRISER = 5;   // 300 ns of 62.5 ns, and 1
  I2C_OARH = 0x40;  // RM0016 21.7.5: always to be written as 1
  I2C_CR1 = kOn;
}

static bool wait(uint8_t flag) {
  for (; patience != 0; --patience) {
    if (I2C_SR2 & kFailed) return false;
    if (I2C_SR1 & flag) return true;
  }
  return false;
}

/// RM0016 21.4.2: a start, the address, and SR3 read behind SR1 to go on.
static bool address_chip(uint8_t byte) {
  I2C_CR2 = kAcknowledge | kStart;
  if (!wait(kStarted)) return false;
  I2C_DR = byte;
  if (!wait(kAddressSent)) return false;
  (void)I2C_SR3;
  return true;
}

/// Method 2 of RM0016 21.4.2 for the last three bytes: each step waits until the peripheral holds
/// the clock low (BTF), so an interrupt at any moment does no harm.
static bool read_three(uint8_t address, uint8_t first, uint8_t* out) {
  bool done;
  // The stop of the transaction before may still be under way.
  for (; I2C_CR2 & kStop; --patience) {
    if (patience == 0) return false;
  }
  if (!address_chip((uint8_t)(address << 1))) return false;
  I2C_DR = first;
  if (!wait(kByteDone)) return false;
  if (!address_chip((uint8_t)(address << 1 | 1))) return false;
  if (!wait(kByteDone)) return false;
  I2C_CR2 = 0;  // the third byte is not acknowledged
  out[0] = I2C_DR;
  if (!wait(kByteDone)) return false;
  // Errata of the I2C cell, "corrupted last received data in master receiver mode": the second byte
  // must be read before the stop is on the bus, or the third is shifted by a bit.
  __critical {
    I2C_CR2 = kStop;
    out[1] = I2C_DR;
  }
  done = wait(kReceived);
  out[2] = I2C_DR;
  return done;
}

bool i2c_read(uint8_t address, uint8_t first, uint8_t* out) {
  patience = kPatience;
  if (read_three(address, first, out)) return true;
  i2c_start();
  return false;
}
