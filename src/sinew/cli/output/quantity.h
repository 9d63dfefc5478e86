#pragma once

#include <expected>
#include <string>
#include <string_view>
#include <vector>

#include "sinew/core/quantity.h"

namespace sinew::cli {

/// Numbers with commas between them, one dimension each; exactly as many as `dimensions`. The unit
/// in the option's name (mm, deg) is meant where a number has no suffix of its own.
/// @param option  as the user typed it, "--joints-deg"
/// @param names   one per number, for the sentence that says what is missing
std::expected<std::vector<double>, std::string> parse_quantities(
    std::string_view option, std::string_view text, const std::vector<Measure>& dimensions,
    const std::vector<std::string>& names);

/// "50%" of --speed, in 0.01 to 1.
std::expected<double, std::string> speed_share(std::string_view text);

}  // namespace sinew::cli
