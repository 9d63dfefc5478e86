#include "sinew/core/number_text.h"

#include <array>
#include <charconv>

namespace sinew {

std::string number_text(double value, int digits) {
  std::array<char, 400> bytes{};  // the largest number has 309 digits before its point
  const auto end = std::to_chars(bytes.data(), bytes.data() + bytes.size(), value,
                                 std::chars_format::fixed, digits);
  std::string text(bytes.data(), end.ptr);
  if (text.find('.') != std::string::npos) {
    text.erase(text.find_last_not_of('0') + 1);
    if (text.back() == '.') text.pop_back();
  }
  return text == "-0" ? "0" : text;
}

std::string number_text(double value) {
  std::array<char, 32> buffer{};
  const auto [end, error] = std::to_chars(buffer.data(), buffer.data() + buffer.size(),
                                          value == 0 ? 0.0 : value, std::chars_format::general, 6);
  return {buffer.data(), end};
}

}  // namespace sinew
