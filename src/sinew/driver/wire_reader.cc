#include "sinew/driver/wire_reader.h"

#include <fmt/format.h>

#include <algorithm>

#include "sinew/driver/stream_reader.h"

namespace sinew {

std::string text_of(const WireMessage& message) {
  std::string text(message.name);
  std::ranges::replace(text, '_', ' ');
  const char* before = ": ";
  for (const WireField& field : message.fields) {
    text += before + std::string(field.name) + " ";
    std::visit(wires::Cases{[&](std::int64_t value) { text += std::to_string(value); },
                            [&](double value) { text += fmt::format("{:.6g}", value); },
                            [&](const std::string& value) { text += value; }},
               field.value);
    before = ", ";
  }
  return text;
}

std::string hex_of(const std::vector<std::uint8_t>& bytes) {
  std::string text;
  for (const std::uint8_t byte : bytes) {
    text += fmt::format("{}{:02X}", text.empty() ? "" : " ", byte);
  }
  return text;
}

}  // namespace sinew
