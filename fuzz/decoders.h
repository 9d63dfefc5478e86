#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "sinew/core/assert.h"

/// What holds for every decoder that takes its bytes one by one.
namespace sinew::fuzz {

template <class Decoder>
auto decode_all(Decoder& decoder, std::span<const std::uint8_t> bytes) {
  std::vector<typename decltype(decoder.push(0))::value_type> results;
  for (const std::uint8_t byte : bytes) {
    if (const auto result = decoder.push(byte)) results.push_back(*result);
  }
  return results;
}

/// A decoder that was cut off somewhere and goes on in a copy says the same as one that ran
/// through.
template <class Decoder>
void same_when_cut(const Decoder& fresh, std::span<const std::uint8_t> bytes) {
  Decoder whole = fresh;
  const auto expected = decode_all(whole, bytes);
  const std::size_t cut = bytes.empty() ? 0 : bytes[0] % (bytes.size() + 1);
  Decoder first = fresh;
  auto results = decode_all(first, bytes.first(cut));
  Decoder second = first;
  for (const auto& result : decode_all(second, bytes.subspan(cut))) results.push_back(result);
  SINEW_ASSERT(results == expected);
}

}  // namespace sinew::fuzz
