#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <string_view>

#include "sinew/core/assert.h"
#include "sinew/wire/simwire.h"

// Both sides of the line protocol. For any bytes: a reader that goes on in a copy says the same as
// one that ran through; a line that is accepted is the one spelling of its message.

namespace {

using namespace sinew;
using namespace sinew::simwire;

void lines_have_one_spelling(std::string_view line) {
  if (const auto request = decode_request(line)) {
    SINEW_ASSERT(view(encode_request(*request)) == line);
    SINEW_ASSERT(decode_request(view(encode_request(*request))) == request);
  }
  if (const auto reply = decode_reply(line)) {
    SINEW_ASSERT(view(encode_reply(*reply)) == line);
  }
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::string_view text(reinterpret_cast<const char*>(data), size);
  auto reader = std::make_unique<LineReader>();
  auto copy = std::make_unique<LineReader>();
  for (const char c : text) {
    *copy = *reader;
    const auto result = reader->push(c);
    SINEW_ASSERT(copy->push(c) == result && copy->line() == reader->line());
    if (result == LineReader::Result::kLine) lines_have_one_spelling(reader->line());
  }
  lines_have_one_spelling(text.substr(0, text.find('\n')));
  return 0;
}
