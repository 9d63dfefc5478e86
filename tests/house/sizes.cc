#include "house/sizes.h"

#include <algorithm>
#include <cstdint>
#include <map>
#include <regex>

namespace sinew::house {
namespace {

enum class Brace : std::uint8_t { kScope, kFunction, kOther };

/// `head` without a leading template<...>.
std::string_view without_template(std::string_view head) {
  head.remove_prefix(std::min(head.find_first_not_of(' '), head.size()));
  if (!head.starts_with("template")) return head;
  int depth = 0;
  for (std::size_t i = head.find('<'); i < head.size(); ++i) {
    depth += head[i] == '<' ? 1 : 0;
    depth -= head[i] == '>' ? 1 : 0;
    if (depth == 0) return without_template(head.substr(i + 1));
  }
  return head;
}

/// Index of an = that assigns, outside of parentheses and brackets; npos where there is none.
std::size_t initialiser_in(std::string_view head) {
  static constexpr std::string_view kComparisons = "=!<>+-*/%&|^";
  int depth = 0;
  for (std::size_t i = 0; i < head.size(); ++i) {
    const char c = head[i];
    if (c == '(' || c == '[') ++depth;
    if (c == ')' || c == ']') --depth;
    if (c != '=' || depth != 0 || i == 0) continue;
    const bool compares = kComparisons.contains(head[i - 1]) || head.substr(i + 1, 1) == "=";
    const bool is_operator = head.substr(0, i).ends_with("operator");
    if (!compares && !is_operator) return i;
  }
  return std::string_view::npos;
}

/// What the brace behind `head` opens.
Brace classify(std::string_view head) {
  static const std::regex kScope(
      R"(^(inline |static |constexpr |typedef |export )*(namespace|class|struct|union|enum)\b)");
  head = without_template(head);
  const std::size_t end = head.find_last_not_of(' ');
  head = head.substr(0, end == std::string_view::npos ? 0 : end + 1);
  if (head == "extern") return Brace::kScope;
  const bool has_parenthesis = head.contains('(');
  const bool is_scope = std::regex_search(head.begin(), head.end(), kScope);
  if (is_scope && (!has_parenthesis || head.contains("alignas("))) return Brace::kScope;
  if (!has_parenthesis && !head.contains('[')) return Brace::kOther;
  const std::size_t initialiser = initialiser_in(head);
  if (initialiser == std::string_view::npos) {
    return has_parenthesis ? Brace::kFunction : Brace::kOther;
  }
  const std::string_view value = head.substr(initialiser + 1);
  const bool is_lambda =
      value.substr(std::min(value.find_first_not_of(' '), value.size())).starts_with('[');
  return is_lambda ? Brace::kFunction : Brace::kOther;
}

/// Walks the code brace by brace; `head_` is what stands since the last statement ended.
class FunctionFinder {
 public:
  std::vector<FunctionSize> run(std::string_view code) {
    for (std::size_t i = 0; i < code.size(); ++i) {
      if (code[i] == '\n') ++line_;
      if (depth_ > 0) {
        inside_body(code, i);
      } else {
        at_scope(code[i]);
      }
    }
    return std::move(found_);
  }

 private:
  void at_scope(char c) {
    if (c == ';' || c == '}') return reset_head();
    if (c == '{') {
      body_ = classify(head_);
      if (body_ == Brace::kScope) return reset_head();
      depth_ = 1;
      return;
    }
    if (head_.empty() && (c == ' ' || c == '\n')) return;
    if (head_.empty()) head_line_ = line_;
    if (c == ':' && (head_ == "public" || head_ == "private" || head_ == "protected")) {
      return reset_head();
    }
    head_ += c == '\n' ? ' ' : c;
  }

  void inside_body(std::string_view code, std::size_t i) {
    if (code[i] == '{') ++depth_;
    if (code[i] != '}' || --depth_ > 0) return;
    const std::size_t next = code.find_first_not_of(" \n", i + 1);
    const bool goes_on = next != std::string_view::npos && (code[next] == ',' || code[next] == '{');
    if (body_ == Brace::kFunction && !goes_on) {
      found_.push_back({head_, head_line_, line_ - head_line_ + 1});
      return reset_head();
    }
    // An initialiser in braces; the function that may follow it is still to come.
    head_ += "{}";
  }

  void reset_head() { head_.clear(); }

  std::vector<FunctionSize> found_;
  std::string head_;
  std::size_t head_line_ = 1;
  std::size_t line_ = 1;
  int depth_ = 0;
  Brace body_ = Brace::kOther;
};

/// Preprocessor lines blanked out, with the lines they continue on.
std::string without_directives(std::string code) {
  bool inside = false;
  bool line_start = true;
  for (std::size_t i = 0; i < code.size(); ++i) {
    if (code[i] == '\n') {
      inside = inside && i > 0 && code[i - 1] == '\\';
      if (inside) code[i - 1] = ' ';
      line_start = true;
      continue;
    }
    if (line_start && code[i] == '#') inside = true;
    if (code[i] != ' ') line_start = false;
    const bool continues = code[i] == '\\' && i + 1 < code.size() && code[i + 1] == '\n';
    if (inside && !continues) code[i] = ' ';
  }
  return code;
}

std::size_t columns(std::string_view line) {
  // Bytes that continue a UTF-8 character take no column of their own.
  return static_cast<std::size_t>(std::ranges::count_if(
      line, [](char c) { return (static_cast<unsigned char>(c) & 0xC0U) != 0x80U; }));
}

}  // namespace

std::vector<FunctionSize> functions_of(std::string_view text) {
  return FunctionFinder().run(without_directives(code_only(text)));
}

std::vector<std::string> check_sizes(std::span<const SourceFile> files) {
  std::vector<std::string> complaints;
  const auto complain = [&](const SourceFile& file, std::size_t line, const std::string& what,
                            std::size_t measured, std::size_t limit) {
    complaints.push_back(file.path + ":" + std::to_string(line) + ": " + what + " has " +
                         std::to_string(measured) + ", limit " + std::to_string(limit));
  };
  for (const SourceFile& file : files) {
    const auto lines = lines_of(file.text);
    if (lines.size() > kLinesPerFileMax) {
      complain(file, 1, "lines: the file", lines.size(), kLinesPerFileMax);
    }
    for (std::size_t i = 0; i < lines.size(); ++i) {
      const std::size_t width = columns(lines[i]);
      if (width > kColumnsMax) complain(file, i + 1, "columns: the line", width, kColumnsMax);
    }
    for (const FunctionSize& function : functions_of(file.text)) {
      if (function.lines <= kLinesPerFunctionMax) continue;
      complain(file, function.first_line, "lines: `" + function.head + "`", function.lines,
               kLinesPerFunctionMax);
    }
  }
  return complaints;
}

std::vector<std::string> check_modules(std::span<const SourceFile> files) {
  std::map<std::string, std::size_t> lines;
  for (const SourceFile& file : files) {
    const std::size_t slash = file.path.rfind('/');
    const bool tests = file.path.substr(slash + 1).contains("_test");
    if (!file.path.starts_with("src/sinew/") || tests) continue;
    lines[file.path.substr(0, slash)] += lines_of(file.text).size();
  }
  std::vector<std::string> complaints;
  for (const auto& [folder, count] : lines) {
    if (count <= kLinesPerModuleMax) continue;
    complaints.push_back(folder + ": the module has " + std::to_string(count) + " lines, limit " +
                         std::to_string(kLinesPerModuleMax));
  }
  return complaints;
}

std::size_t median_lines(std::span<const SourceFile> files) {
  if (files.empty()) return 0;
  std::vector<std::size_t> sizes;
  for (const SourceFile& file : files) sizes.push_back(lines_of(file.text).size());
  const auto middle = sizes.begin() + static_cast<std::ptrdiff_t>(sizes.size() / 2);
  std::ranges::nth_element(sizes, middle);
  return *middle;
}

}  // namespace sinew::house
