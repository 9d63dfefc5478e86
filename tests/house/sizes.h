#pragma once

#include <cstddef>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "house/source_tree.h"

namespace sinew::house {

inline constexpr std::size_t kLinesPerFileMax = 800;
inline constexpr std::size_t kLinesPerFunctionMax = 69;
inline constexpr std::size_t kLinesPerModuleMax = 6000;
inline constexpr std::size_t kColumnsMax = 100;

/// A function body at namespace or class level: its head as written, the line where that begins
/// (from 1), and the lines up to and with its closing brace.
struct FunctionSize {
  std::string head;
  std::size_t first_line = 0;
  std::size_t lines = 0;
};

/// Finds functions by their braces; exact on code that clang-format has laid out and that has no
/// braces cut in two by #if.
std::vector<FunctionSize> functions_of(std::string_view text);

/// Complaints about files, functions and lines that are too long.
std::vector<std::string> check_sizes(std::span<const SourceFile> files);

/// Complaints about folders of src/sinew with too many lines; unit tests and their headers do not
/// count.
std::vector<std::string> check_modules(std::span<const SourceFile> files);

/// Median number of lines; 0 for no files.
std::size_t median_lines(std::span<const SourceFile> files);

}  // namespace sinew::house
