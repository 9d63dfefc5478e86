#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "decoders.h"
#include "sinew/core/assert.h"
#include "sinew/devices/maxarm/maxarm_wire.h"

// The MaxArm's wire from both sides. For any bytes: a decoder that was cut off and goes on in a
// copy says the same as one that ran through; what was accepted is spelled as the very bytes it
// came from; no byte of an answer is lost or counted twice; every message comes back.

namespace {

using namespace sinew;
using fuzz::decode_all;
using fuzz::same_when_cut;
using namespace sinew::maxarm;

void ends_with(std::span<const std::uint8_t> bytes, const FrameBytes& frame) {
  SINEW_ASSERT(frame.size() <= bytes.size());
  SINEW_ASSERT(std::ranges::equal(bytes.last(frame.size()), frame));
}

void what_is_accepted_is_its_bytes(std::span<const std::uint8_t> bytes) {
  RequestDecoder requests;
  ReplyDecoder replies;
  std::uint64_t accepted = 0;
  for (std::size_t i = 0; i < bytes.size(); ++i) {
    const auto seen = bytes.first(i + 1);
    if (const auto request = requests.push(bytes[i])) ends_with(seen, encode_request(*request));
    if (const auto frame = replies.push(bytes[i])) {
      ends_with(seen, encode_reply(frame->reply, frame->checksum));
      accepted += kReplyFrame;
      SINEW_ASSERT(replies.at_boundary());
      SINEW_ASSERT(accepted + replies.skipped() == i + 1);
    }
  }
  SINEW_ASSERT(accepted + replies.skipped() <= bytes.size());
  SINEW_ASSERT(accepted + replies.skipped() + kReplyFrame > bytes.size());
}

/// A board that looks at its port at the marks 00 of the input: nothing grows, and sixteen zeros
/// in one look make it hear again.
void zeros_wake(std::span<const std::uint8_t> bytes) {
  RequestDecoder decoder;
  for (const std::uint8_t byte : bytes) {
    if (byte == 0) decoder.begin_poll();
    (void)decoder.push(byte);
  }
  decoder.begin_poll();
  for (int i = 0; i < 16; ++i) (void)decoder.push(0);
  decoder.begin_poll();
  SINEW_ASSERT(decode_all(decoder, encode_request(ReadXyz{})).size() == 1);
}

std::uint16_t word_at(std::span<const std::uint8_t> bytes, std::size_t place) {
  if (bytes.empty()) return 0;
  return static_cast<std::uint16_t>(bytes[2 * place % bytes.size()] |
                                    bytes[(2 * place + 1) % bytes.size()] << 8U);
}

void every_message_comes_back(std::span<const std::uint8_t> bytes) {
  const auto u = [&](std::size_t i) { return word_at(bytes, i); };
  const auto s = [&](std::size_t i) { return static_cast<std::int16_t>(word_at(bytes, i)); };
  for (const Request& request :
       {Request{SetAngle{{u(0), u(1), u(2)}, u(3)}}, Request{SetXyz{{s(0), s(1), s(2)}, u(3)}},
        Request{SetPwmServo{u(0), u(1)}}, Request{SetSuction{static_cast<std::uint8_t>(u(0))}},
        Request{ReadAngle{}}, Request{ReadXyz{}}}) {
    RequestDecoder decoder;
    const auto decoded = decode_all(decoder, encode_request(request));
    SINEW_ASSERT(decoded.size() == 1 && decoded[0] == request);
  }
  for (const auto checksum : {Checksum::kSpec, Checksum::kWithHeader}) {
    for (const Reply& reply :
         {Reply{Angles{{s(0), s(1), s(2)}}}, Reply{Position{{s(0), s(1), s(2)}}}}) {
      ReplyDecoder decoder;
      const auto decoded = decode_all(decoder, encode_reply(reply, checksum));
      SINEW_ASSERT(decoded.size() == 1 && decoded[0] == (ReplyFrame{reply, checksum}));
    }
  }
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::span bytes(data, size);
  same_when_cut(RequestDecoder{}, bytes);
  same_when_cut(ReplyDecoder{}, bytes);
  what_is_accepted_is_its_bytes(bytes);
  zeros_wake(bytes);
  every_message_comes_back(bytes);
  return 0;
}
