#pragma once

#include <algorithm>
#include <array>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "sinew/core/spelling.h"
#include "sinew/program/language/program_file.h"
#include "sinew/program/language/row_reader.h"

namespace sinew::program {

/// The first words of all rows.
inline constexpr std::array<std::string_view, 22> kRowNames{
    "joint",    "move",         "line", "arc",  "spline", "home",  "jaws", "gripper",
    "suction",  "nozzle",       "wait", "loop", "if",     "else",  "end",  "call",
    "velocity", "acceleration", "look", "pick", "place",  "repeat"};

/// A text of another form as the rows of a program.
struct Rows {
  std::string text;
  std::vector<int> lines;  ///< of the other text, from 1, one a row
  std::vector<ProgramNote> notes{};

  void add(int line, std::string_view row) {
    text += row;
    text += '\n';
    lines.push_back(line);
  }
};

/// What is wrong with a row that begins so; nothing where it is one.
inline std::optional<std::string> unknown_row(std::string_view name) {
  if (std::ranges::find(kRowNames, name) != kRowNames.end()) return std::nullopt;
  const std::string_view meant = nearest_spelling(name, kRowNames);
  std::string all;
  for (const std::string_view known : kRowNames) {
    all += (all.empty() ? "" : " ") + std::string(known);
  }
  return "unknown step " + in_quotes(name) +
         (meant.empty() ? "; steps are " + all : "; did you mean " + std::string(meant) + "?");
}

/// Each row of a text without its line feed, CR LF or byte order mark, while `take` says true.
template <class Take>
void for_each_line(std::string_view text, Take&& take) {
  constexpr std::string_view kByteOrderMark = "\xEF\xBB\xBF";
  if (text.starts_with(kByteOrderMark)) text.remove_prefix(kByteOrderMark.size());
  bool goes_on = true;
  for (int number = 1; !text.empty() && goes_on; ++number) {
    const std::size_t end = std::min(text.find('\n'), text.size());
    std::string_view line = text.substr(0, end);
    if (line.ends_with('\r')) line.remove_suffix(1);
    goes_on = take(number, line);
    text.remove_prefix(std::min(end + 1, text.size()));
  }
}

}  // namespace sinew::program
