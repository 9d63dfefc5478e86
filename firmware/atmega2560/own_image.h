#pragma once

#include <stdint.h>

namespace sinew {
namespace atmega {

/// Identity of the image that runs, as wire/board_image.h has it: board, version, size, checksum.
/// Reads the whole image once: some 0.3 s.
void read_own_identity(uint8_t* out);

}  // namespace atmega
}  // namespace sinew
