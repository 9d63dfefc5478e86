#pragma once

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <cstring>

/// What SinewMaxArm uses of the Arduino core, on a host and in virtual time. C++11.

using std::isfinite;

class __FlashStringHelper;
#define F(text) reinterpret_cast<const __FlashStringHelper*>(text)

class Print {
 public:
  virtual ~Print() = default;
  virtual size_t write(uint8_t byte) = 0;
  virtual size_t write(const uint8_t* bytes, size_t count) {
    size_t written = 0;
    while (written < count && write(bytes[written]) == 1) ++written;
    return written;
  }
  size_t print(const char* text) {
    return write(reinterpret_cast<const uint8_t*>(text), std::strlen(text));
  }
  size_t print(const __FlashStringHelper* text) {
    return print(reinterpret_cast<const char*>(text));
  }
  size_t print(char character) { return write(static_cast<uint8_t>(character)); }
  size_t print(int number) {
    char text[16];
    std::snprintf(text, sizeof text, "%d", number);
    return print(text);
  }
  size_t print(double number, int decimals = 2) {
    char text[64];
    std::snprintf(text, sizeof text, "%.*f", decimals, number);
    return print(text);
  }
};

class Printable {
 public:
  virtual ~Printable() = default;
  Printable() = default;
  Printable(const Printable&) = default;
  Printable& operator=(const Printable&) = default;
  virtual size_t printTo(Print& out) const = 0;
};

class Stream : public Print {
 public:
  virtual int available() = 0;
  virtual int read() = 0;
  virtual int peek() = 0;
};

/// 32 bits, as on the chip: it runs over after 49.7 days.
unsigned long millis();
void delay(unsigned long time_ms);
