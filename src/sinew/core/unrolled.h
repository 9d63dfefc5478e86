#pragma once

#include <cstddef>
#include <type_traits>
#include <utility>

namespace sinew {

/// Calls body(0) .. body(N - 1) with constants: compilers leave short triangular loops rolled up,
/// and small matrices in memory instead of in registers, which costs half of the time. @rt
template <std::size_t N, class Body>
[[gnu::always_inline]] inline void unrolled(const Body& body) {
  [&]<std::size_t... I>(std::index_sequence<I...>) __attribute__((always_inline)) {
    (body(std::integral_constant<std::size_t, I>{}), ...);
  }(std::make_index_sequence<N>{});
}

}  // namespace sinew
