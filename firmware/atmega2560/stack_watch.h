#pragma once

#include <stdint.h>

namespace sinew {
namespace atmega {

/// Bytes between the program's variables and the deepest the stack has been since the start.
uint16_t unused_stack();

}  // namespace atmega
}  // namespace sinew
