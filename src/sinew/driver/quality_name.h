#pragma once

#include <array>
#include <cstddef>
#include <string_view>

#include "sinew/driver/driver.h"

namespace sinew {

/// Stable, for machines and people alike. @rt
constexpr std::string_view quality_name(PositionQuality quality) {
  constexpr std::array<std::string_view, 4> kNames{"lost", "uncertain", "commanded", "measured"};
  return kNames[static_cast<std::size_t>(quality)];
}

}  // namespace sinew
