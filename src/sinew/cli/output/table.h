#pragma once

#include <string>
#include <vector>

namespace sinew::cli {

/// Text in columns: the first left, the others to the right, two spaces between.
class Table {
 public:
  explicit Table(std::vector<std::string> head) : rows_{std::move(head)} {}
  void add(std::vector<std::string> row) { rows_.push_back(std::move(row)); }
  /// Columns of words rather than numbers.
  Table& left(std::size_t column) {
    left_.push_back(column);
    return *this;
  }
  std::string text() const;

 private:
  std::vector<std::vector<std::string>> rows_;
  std::vector<std::size_t> left_{0};
};

/// A number for people: up to `digits` decimals, no trailing zeros, no "-0".
std::string number(double value, int digits = 3);

/// Words with a separator between them.
template <class Words>
std::string joined(const Words& words, const char* separator) {
  std::string text;
  for (const auto& word : words) {
    if (!text.empty()) text += separator;
    text += word;
  }
  return text;
}

}  // namespace sinew::cli
