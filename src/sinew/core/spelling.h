#pragma once

#include <span>
#include <string>
#include <string_view>

namespace sinew {

/// Smallest number of characters to insert, drop, replace or swap with their neighbour that turns
/// `a` into `b` (optimal string alignment).
std::size_t edit_distance(std::string_view a, std::string_view b);

/// The candidate that `word` was probably meant to be; empty where none is near enough.
std::string_view nearest_spelling(std::string_view word,
                                  std::span<const std::string_view> candidates);

/// `word` made safe to print: other than plain ASCII becomes \xNN, at most 60 characters stay.
std::string printable(std::string_view word);

}  // namespace sinew
