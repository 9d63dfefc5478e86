#pragma once

namespace sinew {

/// Prints the broken condition and aborts. A tripped assertion is a bug in Sinew, never bad input.
[[noreturn]] void assertion_failed(const char* condition, const char* file, int line) noexcept;

}  // namespace sinew

/// Demand that holds in every build: it stays armed in release. @rt
#define SINEW_ASSERT(condition) \
  ((condition) ? static_cast<void>(0) : ::sinew::assertion_failed(#condition, __FILE__, __LINE__))
