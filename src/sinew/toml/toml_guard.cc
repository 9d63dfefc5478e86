#include "sinew/toml/toml_guard.h"

#include <algorithm>
#include <string>

namespace sinew {
namespace {

Complaint complaint_at(std::string_view text, std::size_t at, std::string message) {
  const std::string_view before = text.substr(0, at);
  const std::size_t line_begin = before.find_last_of('\n') + 1;  // npos + 1 is 0
  const auto begins_character = [](char c) {
    return (static_cast<unsigned char>(c) & 0xC0) != 0x80;
  };
  const auto column = std::ranges::count_if(before.substr(line_begin), begins_character);
  return {{},
          static_cast<int>(std::ranges::count(before, '\n')) + 1,
          static_cast<int>(column) + 1,
          {},
          std::move(message)};
}

std::optional<std::size_t> first_long_line(std::string_view text) {
  for (std::size_t begin = 0; begin < text.size();) {
    const std::size_t end = std::min(text.find('\n', begin), text.size());
    if (end - begin > kMaxTomlLineBytes) return begin;
    begin = end + 1;
  }
  return std::nullopt;
}

/// @param at  an opening quote
/// @return    the first byte after the string; a string without an end reaches as far as the parser
///            would read before it complains.
std::size_t end_of_string(std::string_view text, std::size_t at) {
  const char quote = text[at];
  const std::string_view triple = quote == '"' ? R"(""")" : "'''";
  const bool multi_line = text.substr(at, 3) == triple;
  for (at += multi_line ? 3 : 1; at < text.size(); ++at) {
    if (quote == '"' && text[at] == '\\') {
      ++at;
    } else if (!multi_line && (text[at] == quote || text[at] == '\n')) {
      return at + 1;
    } else if (multi_line && text.substr(at, 3) == triple) {
      // Two quotes more may belong to the string; a third is an error.
      for (at += 3; at < text.size() && text[at] == quote;) ++at;
      return at;
    }
  }
  return text.size();
}

std::optional<std::size_t> first_stray_character(std::string_view text) {
  constexpr std::string_view kByteOrderMark = "\xEF\xBB\xBF";
  for (std::size_t at = text.starts_with(kByteOrderMark) ? 3 : 0; at < text.size();) {
    const char c = text[at];
    if (c == '"' || c == '\'') {
      at = end_of_string(text, at);
    } else if (c == '#') {
      at = std::min(text.find('\n', at), text.size());
    } else if ((static_cast<unsigned char>(c) & 0x80) != 0) {
      return at;
    } else {
      ++at;
    }
  }
  return std::nullopt;
}

}  // namespace

std::optional<Complaint> unfit_for_parser(std::string_view text) {
  if (text.size() > kMaxTomlBytes) return complaint_at(text, 0, "the file is longer than 1 MiB");
  if (const auto at = first_long_line(text)) {
    return complaint_at(text, *at, "the line is longer than 400 bytes");
  }
  if (const auto at = first_stray_character(text)) {
    return complaint_at(text, *at, "only strings and comments may hold characters beyond ASCII");
  }
  return std::nullopt;
}

}  // namespace sinew
