#pragma once

#include <cstdint>
#include <fstream>
#include <sstream>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

/// Reads tests/golden/*.txt: one vector a line, `who | bytes | meaning | remark`, # for comments.
namespace sinew::test {

struct Golden {
  std::string who;  ///< "host", "device", ... : who sends it
  std::string bytes;
  std::string meaning;  ///< a few words of plain text, read by the wire's own test
  std::string where;    ///< file:line

  bool from_host() const { return who == "host"; }
};

inline std::string trimmed(std::string_view text) {
  const auto begin = text.find_first_not_of(' ');
  if (begin == std::string_view::npos) return {};
  return std::string(text.substr(begin, text.find_last_not_of(' ') - begin + 1));
}

inline std::vector<std::string> split(std::string_view text, char separator) {
  std::vector<std::string> parts;
  std::stringstream stream{std::string(text)};
  for (std::string part; std::getline(stream, part, separator);) parts.push_back(trimmed(part));
  return parts;
}

/// "goto 1 2 3" -> {"goto", "1", "2", "3"}.
inline std::vector<std::string> words_in(std::string_view text) {
  std::stringstream stream{std::string(text)};
  std::vector<std::string> words;
  for (std::string word; stream >> word;) words.push_back(word);
  return words;
}

inline std::vector<Golden> read_goldens(const std::string& name) {
  std::ifstream file(std::string(SINEW_GOLDEN_DIR) + "/" + name);
  if (!file) throw std::runtime_error("no golden file " + name);
  std::vector<Golden> goldens;
  std::string line;
  for (int number = 1; std::getline(file, line); ++number) {
    if (line.empty() || line[0] == '#') continue;
    const auto parts = split(line, '|');
    const std::string where = name + ":" + std::to_string(number);
    if (parts.size() < 3) throw std::runtime_error(where + ": needs three columns");
    goldens.push_back({parts[0], parts[1], parts[2], where});
  }
  return goldens;
}

/// "55 9A 00AA" -> four bytes.
inline std::vector<std::uint8_t> from_hex(const std::string& text) {
  std::vector<std::uint8_t> bytes;
  std::string digits;
  for (const char character : text) {
    if (character == ' ') continue;
    digits += character;
    if (digits.size() < 2) continue;
    bytes.push_back(static_cast<std::uint8_t>(std::stoul(digits, nullptr, 16)));
    digits.clear();
  }
  if (!digits.empty()) throw std::runtime_error("odd number of digits: " + text);
  return bytes;
}

}  // namespace sinew::test
