#pragma once

#include <expected>
#include <string>
#include <string_view>
#include <vector>

#include "sinew/core/complaint.h"

namespace sinew::program {

/// A program's text in its one layout: two blanks a level, one between words, arguments in the
/// order of docs/programs.md (numbers and units as they were written), remarks kept, those behind
/// neighbouring rows below each other, no two empty rows together, LF. What parse() reads of it
/// stays the same, only lines move; laid out again it stays as it is. No robot is needed: names of
/// joints and limits are not looked at.
/// @error  a row that begins with no known word, a block without end, an end or else without block
std::expected<std::string, std::vector<Complaint>> format(std::string_view text,
                                                          std::string_view file_name);

}  // namespace sinew::program
