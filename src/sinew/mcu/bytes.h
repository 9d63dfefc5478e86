#pragma once

#include <stdint.h>

/// Numbers in bytes, little endian, for chips whose compiler has no C++ library. @rt
namespace sinew {
namespace mcu {

inline void put_u16(uint8_t* out, uint16_t number) {
  out[0] = static_cast<uint8_t>(number);
  out[1] = static_cast<uint8_t>(number >> 8);
}
inline void put_u32(uint8_t* out, uint32_t number) {
  put_u16(out, static_cast<uint16_t>(number));
  put_u16(out + 2, static_cast<uint16_t>(number >> 16));
}
inline uint16_t get_u16(const uint8_t* in) {
  return static_cast<uint16_t>(in[0] | static_cast<uint16_t>(static_cast<uint16_t>(in[1]) << 8));
}
inline uint32_t get_u32(const uint8_t* in) {
  return get_u16(in) | static_cast<uint32_t>(get_u16(in + 2)) << 16;
}

/// Copies bytes; there is no <string.h> to depend on.
inline void copy_bytes(uint8_t* out, const uint8_t* in, uint8_t size) {
  for (uint8_t i = 0; i < size; ++i) out[i] = in[i];
}

/// CRC-32C, byte by byte: the same number as sinew::crc32c() (wire/crc32c.h), whose tables would
/// fill a small chip.
class Crc32c {
 public:
  void add(uint8_t byte);
  uint32_t value() const { return ~crc_; }

 private:
  uint32_t crc_ = 0xFFFFFFFF;
};
uint32_t crc32c(const uint8_t* bytes, uint8_t size);

}  // namespace mcu
}  // namespace sinew
