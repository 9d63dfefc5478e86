#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "decoders.h"
#include "sinew/core/assert.h"
#include "sinew/devices/icp/icp_wire.h"

// The hexapod's serial wire from both sides. For any bytes: a decoder that was cut off and goes on
// in a copy says the same as one that ran through; what was accepted is written in its one
// spelling, which reads back as the same; a reply's spelling is the very bytes it came from; and in
// any string of bytes there are no more steps than FFs before them.

namespace {

using namespace sinew;
using fuzz::decode_all;
using fuzz::same_when_cut;
using namespace sinew::icp;

void requests_have_one_spelling(const Dialect& dialect, std::span<const std::uint8_t> bytes) {
  RequestDecoder decoder(dialect);
  std::size_t inits = 0;
  std::size_t steps = 0;
  for (const std::uint8_t byte : bytes) {
    const RequestDecoder before = decoder;
    const auto result = decoder.push(byte);
    if (!result || !*result) continue;
    inits += std::holds_alternative<Init>(**result) ? 1 : 0;
    steps += std::holds_alternative<Step>(**result) ? 1 : 0;
    const auto* select = std::get_if<Select>(&**result);
    // A strict firmware knows a motor by its positioning bytes only.
    const bool strict = select != nullptr && dialect.checks_selector;
    const Request spelled = strict ? Request{Step{select->motor, false}} : **result;
    RequestDecoder again = before;
    const auto reread = again.push(encode_request(spelled));
    SINEW_ASSERT(reread && *reread == *result);
    SINEW_ASSERT(again.state() == decoder.state());
  }
  SINEW_ASSERT(steps <= inits);
}

void replies_are_their_bytes(ReplyDecoder::Due due, std::span<const std::uint8_t> bytes) {
  ReplyDecoder decoder;
  decoder.expect(due);
  std::size_t begin = 0;
  for (std::size_t i = 0; i < bytes.size(); ++i) {
    const auto result = decoder.push(bytes[i]);
    SINEW_ASSERT(i - begin <= kStatusSize);
    if (!result) continue;
    if (*result) {
      const ReplyBytes spelled = encode_reply(**result);
      SINEW_ASSERT(spelled.size() == i + 1 - begin);
      SINEW_ASSERT(std::equal(spelled.begin(), spelled.end(), bytes.subspan(begin).begin()));
    }
    decoder.expect(due);
    begin = i + 1;
  }
}

/// Every kind of message, with the input's bytes as its numbers.
void every_message_comes_back(std::span<const std::uint8_t> bytes) {
  const auto at = [&](std::size_t i) { return bytes.empty() ? 0U : bytes[i % bytes.size()]; };
  const auto motor = static_cast<std::uint8_t>(1 + at(0) % kMotors);
  const Step step{motor, (at(1) & 1U) != 0};
  SINEW_ASSERT(decode_step(encode_step(step)) == step);
  StatusBytes block{};
  for (std::size_t i = 0; i < block.size(); ++i) block[i] = static_cast<std::uint8_t>(at(i));
  block[0] |= 0xE0;
  block[5] |= 2;
  block[11] |= 0xF8;
  const auto status = decode_status(block);
  SINEW_ASSERT(status && encode_status(*status) == block);
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::span bytes(data, size);
  for (const bool wake : {false, true}) {
    for (const bool strict : {false, true}) {
      const Dialect dialect{.knows_wake = wake, .checks_selector = strict};
      same_when_cut(RequestDecoder(dialect), bytes);
      requests_have_one_spelling(dialect, bytes);
    }
  }
  for (const auto due : {ReplyDecoder::Due::kByte, ReplyDecoder::Due::kBlock}) {
    ReplyDecoder decoder;
    decoder.expect(due);
    same_when_cut(decoder, bytes);
    replies_are_their_bytes(due, bytes);
  }
  every_message_comes_back(bytes);
  return 0;
}
