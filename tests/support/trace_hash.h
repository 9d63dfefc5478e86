#pragma once

#include <cstdint>

namespace sinew::test {

/// FNV-1a of what happens in a run, of whole numbers only: doubles would tell compilers apart.
class TraceHash {
 public:
  void add_byte(std::uint8_t byte) { hash_ = (hash_ ^ byte) * 0x100000001B3ULL; }
  void add(std::uint64_t value) {
    for (int k = 0; k < 8; ++k) add_byte(static_cast<std::uint8_t>(value >> 8 * k));
  }
  std::uint64_t value() const { return hash_; }

 private:
  std::uint64_t hash_ = 0xCBF29CE484222325ULL;
};

}  // namespace sinew::test
