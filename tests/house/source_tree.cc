#include "house/source_tree.h"

#include <algorithm>
#include <cctype>
#include <fstream>
#include <iterator>

namespace sinew::house {
namespace {

bool is_word(char c) {
  return std::isalnum(static_cast<unsigned char>(c)) != 0 || c == '_';
}

/// True for the ' of 100'000: it stands inside a token that begins with a digit.
bool is_digit_separator(std::string_view text, std::size_t quote) {
  std::size_t start = quote;
  while (start > 0 && (is_word(text[start - 1]) || text[start - 1] == '\'')) --start;
  return start < quote && std::isdigit(static_cast<unsigned char>(text[start])) != 0;
}

/// Index behind the literal that opens at `open`.
std::size_t literal_end(std::string_view text, std::size_t open) {
  const char quote = text[open];
  if (quote == '"' && open > 0 && text[open - 1] == 'R') {
    const std::size_t parenthesis = text.find('(', open);
    if (parenthesis == std::string_view::npos) return text.size();
    const std::string close =
        ")" + std::string(text.substr(open + 1, parenthesis - open - 1)) + "\"";
    const std::size_t end = text.find(close, parenthesis);
    return end == std::string_view::npos ? text.size() : end + close.size();
  }
  for (std::size_t i = open + 1; i < text.size(); ++i) {
    if (text[i] == '\\') {
      ++i;
    } else if (text[i] == quote || text[i] == '\n') {
      return i + 1;
    }
  }
  return text.size();
}

std::size_t comment_end(std::string_view text, std::size_t open) {
  const bool line_comment = text[open + 1] == '/';
  const std::size_t end = text.find(line_comment ? "\n" : "*/", open + 2);
  if (end == std::string_view::npos) return text.size();
  return line_comment ? end : end + 2;
}

std::string blanked(std::string_view text, bool blank_literals) {
  std::string out(text);
  const auto blank = [&out](std::size_t from, std::size_t to) {
    for (std::size_t i = from; i < to; ++i) {
      if (out[i] != '\n') out[i] = ' ';
    }
  };
  std::size_t i = 0;
  while (i < text.size()) {
    const std::string_view two = text.substr(i, 2);
    if (two == "//" || two == "/*") {
      const std::size_t end = comment_end(text, i);
      blank(i, end);
      i = end;
    } else if (text[i] == '"' || (text[i] == '\'' && !is_digit_separator(text, i))) {
      const std::size_t end = literal_end(text, i);
      if (blank_literals) blank(i, end);
      i = end;
    } else {
      ++i;
    }
  }
  return out;
}

std::string read_file(const std::filesystem::path& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()};
}

}  // namespace

std::vector<SourceFile> read_tree(const std::filesystem::path& root,
                                  std::span<const std::string_view> folders) {
  std::vector<SourceFile> files;
  for (const std::string_view folder : folders) {
    if (!std::filesystem::exists(root / folder)) continue;
    for (const auto& entry : std::filesystem::recursive_directory_iterator(root / folder)) {
      const auto extension = entry.path().extension();
      if (!entry.is_regular_file()) continue;
      if (extension != ".h" && extension != ".cc" && extension != ".c") continue;
      files.push_back({std::filesystem::relative(entry.path(), root).generic_string(),
                       read_file(entry.path())});
    }
  }
  std::ranges::sort(files, {}, &SourceFile::path);
  return files;
}

std::string without_comments(std::string_view text) {
  return blanked(text, false);
}

std::string code_only(std::string_view text) {
  return blanked(text, true);
}

std::vector<std::string_view> lines_of(std::string_view text) {
  std::vector<std::string_view> lines;
  while (!text.empty()) {
    const std::size_t end = std::min(text.find('\n'), text.size());
    lines.push_back(text.substr(0, end));
    text.remove_prefix(std::min(end + 1, text.size()));
  }
  return lines;
}

std::vector<Include> includes_of(std::string_view text) {
  const std::string code = without_comments(text);
  std::vector<Include> includes;
  std::size_t number = 0;
  for (std::string_view line : lines_of(code)) {
    ++number;
    const auto skip_blanks = [&line] {
      line.remove_prefix(std::min(line.find_first_not_of(" \t"), line.size()));
    };
    skip_blanks();
    if (!line.starts_with('#')) continue;
    line.remove_prefix(1);
    skip_blanks();
    if (!line.starts_with("include")) continue;
    line.remove_prefix(std::string_view("include").size());
    skip_blanks();
    if (!line.starts_with('"') && !line.starts_with('<')) continue;
    const bool quoted = line.starts_with('"');
    const std::size_t end = line.find(quoted ? '"' : '>', 1);
    if (end == std::string_view::npos) continue;
    includes.push_back({number, std::string(line.substr(1, end - 1)), quoted});
  }
  return includes;
}

}  // namespace sinew::house
