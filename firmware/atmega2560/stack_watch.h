#pragma once

#include <stdint.h>

namespace sinew {
namespace atmega {

/// Bytes between the program's variables and the deepest the stack has been since the start, as far
/// as has been looked: each call looks at a few more.
uint16_t unused_stack();

}  // namespace atmega
}  // namespace sinew
