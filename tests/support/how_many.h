#pragma once

#include <cstdint>
#include <cstdlib>
#include <optional>

namespace sinew::test {

/// The number that a variable of the environment holds (1e6 is one too), if it is set.
inline std::optional<std::uint64_t> number_of(const char* variable) {
  const char* text = std::getenv(variable);
  if (text == nullptr) return {};
  return static_cast<std::uint64_t>(std::strtod(text, nullptr));
}

/// How much of something a long test does: what the variable says where it is set, else what fits
/// into an ordinary run.
inline std::uint64_t how_many(const char* variable, std::uint64_t usual) {
  return number_of(variable).value_or(usual);
}

/// The same for what takes ten times as long with sanitizers, and does less there.
inline std::uint64_t how_many(const char* variable, [[maybe_unused]] std::uint64_t usual,
                              [[maybe_unused]] std::uint64_t with_sanitizers) {
#ifdef __SANITIZE_ADDRESS__
  return how_many(variable, with_sanitizers);
#else
  return how_many(variable, usual);
#endif
}

}  // namespace sinew::test
