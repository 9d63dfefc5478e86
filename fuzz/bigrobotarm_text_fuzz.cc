#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <string_view>
#include <vector>

#include "sinew/core/assert.h"
#include "sinew/devices/bigrobotarm/bigrobotarm_wire_text.h"

// The text wire from both sides. For any characters: a decoder that was cut off and goes on in a
// copy says the same as one that ran through; a host line that was accepted is written in its one
// spelling, which reads back as the same line; a device line has no other spelling at all.

namespace {

using namespace sinew;
using namespace sinew::bigrobotarm;

auto decode_all(text::ReplyDecoder& decoder, std::string_view characters) {
  std::vector<std::expected<Reply, Garbage>> results;
  for (const char character : characters) {
    if (const auto result = decoder.push(character)) results.push_back(*result);
  }
  return results;
}

void same_when_cut(std::string_view characters) {
  text::ReplyDecoder whole;
  const auto expected = decode_all(whole, characters);
  const std::size_t cut =
      characters.empty() ? 0 : static_cast<std::uint8_t>(characters[0]) % (characters.size() + 1);
  text::ReplyDecoder first;
  auto results = decode_all(first, characters.substr(0, cut));
  text::ReplyDecoder second = first;
  for (const auto& result : decode_all(second, characters.substr(cut))) results.push_back(result);
  SINEW_ASSERT(results == expected);
}

void host_lines_have_one_spelling(std::string_view characters) {
  text::LineReader reader;
  for (const char character : characters) {
    if (!reader.push(character)) continue;
    const auto line = text::decode_line(reader.line());
    if (!line) continue;
    const auto spelled = text::encode_line(*line);
    const auto again = text::decode_line(text::view(spelled));
    SINEW_ASSERT(again == line);
    SINEW_ASSERT(text::encode_line(*again) == spelled);
  }
}

void device_lines_are_their_characters(std::string_view characters) {
  while (!characters.empty()) {
    const std::size_t end = std::min(characters.find("\r\n"), characters.size());
    const std::string_view raw = characters.substr(0, end);
    const auto line = text::decode_reply_line(raw);
    if (line) SINEW_ASSERT(text::view(text::encode_reply_line(*line)) == raw);
    characters.remove_prefix(std::min(end + 2, characters.size()));
  }
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::string_view characters(reinterpret_cast<const char*>(data), size);
  same_when_cut(characters);
  host_lines_have_one_spelling(characters);
  device_lines_are_their_characters(characters);
  return 0;
}
