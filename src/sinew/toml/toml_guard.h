#pragma once

#include <optional>
#include <string_view>

#include "sinew/toml/findings.h"

namespace sinew {

/// Bounds that keep a hostile file from costing memory or stack. The TOML library recurses once per
/// dot of a dotted key, however many there are: a bound on the line bounds the stack.
inline constexpr std::size_t kMaxTomlBytes = std::size_t{1} << 20;
inline constexpr std::size_t kMaxTomlLineBytes = 400;

/// What the TOML library must not be shown.
///
/// @return  a Complaint without file and key: text longer than kMaxTomlBytes, a line longer than
///          kMaxTomlLineBytes, or a character beyond ASCII outside strings and comments, which is
///          no TOML and for which the library's test for white space runs off its end.
std::optional<Complaint> unfit_for_parser(std::string_view text);

}  // namespace sinew
