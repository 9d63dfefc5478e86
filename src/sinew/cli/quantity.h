#pragma once

#include <expected>
#include <string>
#include <string_view>
#include <vector>

namespace sinew::cli {

/// What a list of numbers on the command line measures. The unit in the option's name (mm, deg) is
/// meant where a number has no suffix of its own.
enum class Dimension { kLength, kAngle };

/// One number with an optional unit: "90", "90deg", "1.57rad", "0.1m", "2in", "12.5mm", to m or
/// rad. The error is a sentence that names the text and what would be right.
std::expected<double, std::string> parse_quantity(std::string_view text, Dimension dimension);

/// Numbers with commas between them, one dimension each; exactly as many as `dimensions`.
/// @param option  as the user typed it, "--joints-deg"
/// @param names   one per number, for the sentence that says what is missing
std::expected<std::vector<double>, std::string> parse_quantities(
    std::string_view option, std::string_view text, const std::vector<Dimension>& dimensions,
    const std::vector<std::string>& names);

}  // namespace sinew::cli
