#pragma once

#include <cstddef>

namespace sinew {

inline constexpr std::size_t kMaxJoints = 8;

}  // namespace sinew
