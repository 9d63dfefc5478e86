#include "sinew/mcu/bytes.h"

#ifdef __AVR__
#include <avr/pgmspace.h>
#else
#define PROGMEM
#define pgm_read_dword(address) (*(address))
#endif

namespace sinew {
namespace mcu {
namespace {

constexpr uint32_t kPolynomial = 0x82F63B78;

struct Table {
  uint32_t words[256];
};
constexpr Table make_table() {
  Table table = {};
  for (uint16_t byte = 0; byte < 256; ++byte) {
    uint32_t crc = byte;
    for (uint8_t bit = 0; bit < 8; ++bit) crc = (crc >> 1) ^ ((crc & 1) != 0 ? kPolynomial : 0);
    table.words[byte] = crc;
  }
  return table;
}
// In flash: a chip with 8 kB of RAM has no room for it there.
const Table kTable PROGMEM = make_table();

}  // namespace

void Crc32c::add(uint8_t byte) {
  crc_ = (crc_ >> 8) ^ pgm_read_dword(&kTable.words[static_cast<uint8_t>(crc_ ^ byte)]);
}

uint32_t crc32c(const uint8_t* bytes, uint8_t size) {
  Crc32c crc;
  for (uint8_t i = 0; i < size; ++i) crc.add(bytes[i]);
  return crc.value();
}

}  // namespace mcu
}  // namespace sinew
