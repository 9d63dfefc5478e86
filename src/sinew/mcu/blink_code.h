#pragma once

#include <stdint.h>

namespace sinew {
namespace mcu {

/// A lamp that says a number: so many flashes of 0.2 s, 0.5 s apart, then 1.5 s dark. @rt
/// @param ms       since any moment
/// @param flashes  1..20
inline bool is_lit(uint32_t ms, uint8_t flashes) {
  const uint16_t apart = 500;
  const uint16_t lit = 200;
  const uint16_t dark = 1500;
  const uint16_t group = static_cast<uint16_t>(flashes * apart);
  const uint16_t at = static_cast<uint16_t>(ms % static_cast<uint16_t>(group + dark));
  return at < group && at % apart < lit;
}

}  // namespace mcu
}  // namespace sinew
