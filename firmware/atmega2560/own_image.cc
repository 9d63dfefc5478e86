#include "firmware/atmega2560/own_image.h"

#include <avr/pgmspace.h>

#include "sinew/mcu/arm_link.h"
#include "sinew/mcu/bytes.h"

// The label of an image (wire/board_image.h): mark, board, version, first byte, end. In assembler,
// since an address of an image here has more bits than a pointer; in the section that the linker
// lays first, since a label is looked for in the first kilobyte.
asm(".pushsection .progmem.gcc.sinew_label,\"a\",@progbits\n"
    ".balign 4\n"
    "sinew_label:\n"
    ".ascii \"SINEW-FW\"\n"
    "0: .ascii \"" SINEW_BOARD
    "\"\n"
    ".skip 24 - (. - 0b)\n"
    "0: .ascii \"" SINEW_VERSION
    "\"\n"
    ".skip 16 - (. - 0b)\n"
    ".long 0\n"
    ".long __data_load_end\n"
    ".popsection\n");

extern "C" const uint8_t sinew_label[];

namespace sinew {
namespace atmega {
namespace {

constexpr uint8_t kMarkSize = 8;
constexpr uint8_t kNamesSize = 40;

}  // namespace

void read_own_identity(uint8_t* out) {
  for (uint8_t i = 0; i < kNamesSize; ++i) out[i] = pgm_read_byte(sinew_label + kMarkSize + i);
  const uint32_t size = pgm_read_dword(sinew_label + kMarkSize + kNamesSize + 4);
  mcu::put_u32(out + kNamesSize, size);
  mcu::Crc32c checksum;
  for (uint32_t i = 0; i < size; ++i) checksum.add(pgm_read_byte_far(i));
  mcu::put_u32(out + kNamesSize + 4, checksum.value());
}

}  // namespace atmega
}  // namespace sinew
