#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "decoders.h"
#include "sinew/core/assert.h"
#include "sinew/devices/bigrobotarm/bigrobotarm_wire_byte.h"

// The binary wire from both sides. For any bytes: a decoder that was cut off and goes on in a copy
// says the same as one that ran through; what was accepted is written in its one spelling, which
// reads back as the same message; and a reply's spelling is the very bytes it came from.

namespace {

using namespace sinew;
using fuzz::decode_all;
using fuzz::same_when_cut;
using namespace sinew::bigrobotarm;

void requests_have_one_spelling(std::span<const std::uint8_t> bytes) {
  byte::RequestDecoder decoder;
  for (const auto& result : decode_all(decoder, bytes)) {
    if (!result) continue;
    const auto spelled = byte::encode_request(*result);
    byte::RequestDecoder again;
    const auto decoded = decode_all(again, spelled);
    SINEW_ASSERT(decoded.size() == 1 && decoded[0] == result);
    SINEW_ASSERT(byte::encode_request(*decoded[0]) == spelled);
  }
}

/// No request that the firmware understood can hold a 0D, so its one spelling is understood again.
void cut_requests_have_one_spelling(std::span<const std::uint8_t> bytes) {
  byte::CutRequestDecoder decoder;
  for (const auto& result : decode_all(decoder, bytes)) {
    if (!result) continue;
    SINEW_ASSERT(byte::sendable(*result));
    byte::CutRequestDecoder again;
    SINEW_ASSERT(decode_all(again, byte::encode_request(*result)).empty());
    const auto decoded = again.push(byte::kTerminator);
    SINEW_ASSERT(decoded && *decoded == result);
  }
}

void replies_are_their_bytes(std::span<const std::uint8_t> bytes) {
  byte::ReplyDecoder decoder;
  std::size_t end = 0;
  for (const std::uint8_t byte : bytes) {
    ++end;
    const auto result = decoder.push(byte);
    if (!result || !*result) continue;
    const auto spelled = byte::encode_reply(**result);
    SINEW_ASSERT(spelled.size() <= end);
    const auto came_from = bytes.subspan(end - spelled.size(), spelled.size());
    SINEW_ASSERT(std::equal(spelled.begin(), spelled.end(), came_from.begin()));
  }
}

std::int32_t word_at(std::span<const std::uint8_t> bytes, std::size_t place) {
  std::uint32_t bits = 0;
  for (std::size_t k = 0; k < 4; ++k) {
    bits = bits << 8 | (bytes.empty() ? 0 : bytes[(place * 4 + k) % bytes.size()]);
  }
  return static_cast<std::int32_t>(bits);
}

Words words_at(std::span<const std::uint8_t> bytes, std::size_t place) {
  Words words{};
  for (std::size_t i = 0; i < kJoints; ++i) words[i] = word_at(bytes, place + i);
  return words;
}

/// Every kind of message, with the input's bytes as its numbers.
void every_message_comes_back(std::span<const std::uint8_t> bytes) {
  const Words words = words_at(bytes, 0);
  const auto low = static_cast<std::uint8_t>(words[0] & 0xFF);
  const bool flag = (low & 1) != 0;
  for (const Request& request :
       {Request{Goto{words}}, Request{Home{}}, Request{Reset{}}, Request{SetSpeeds{words}},
        Request{SetAccelerations{words}}, Request{SetGripper{flag, low}}, Request{SetSync{flag}},
        Request{ReadStatus{}}}) {
    byte::RequestDecoder decoder;
    const auto decoded = decode_all(decoder, byte::encode_request(request));
    SINEW_ASSERT(decoded.size() == 1 && decoded[0] == request);
    SINEW_ASSERT(!decoder.push(byte::kTerminator));
  }
  byte::ReplyDecoder decoder;
  const Gripper gripper{flag, low};
  for (const Reply& reply :
       {Reply{MotionStarted{RequestId::kGoto}}, Reply{GotoDone{words}},
        Reply{MotionStarted{RequestId::kHome}}, Reply{HomeDone{words}}, Reply{ResetDone{words}},
        Reply{Speeds{words}}, Reply{Accelerations{words}}, Reply{gripper}, Reply{Sync{flag}},
        Reply{Status{words, words_at(bytes, 5), words_at(bytes, 10), gripper, flag}},
        Reply{Invalid{}}}) {
    const auto decoded = decode_all(decoder, byte::encode_reply(reply));
    SINEW_ASSERT(decoded.size() == 1 && decoded[0] == reply);
  }
  SINEW_ASSERT(decoder.at_boundary());
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::span bytes(data, size);
  same_when_cut(byte::RequestDecoder{}, bytes);
  same_when_cut(byte::CutRequestDecoder{}, bytes);
  same_when_cut(byte::ReplyDecoder{}, bytes);
  requests_have_one_spelling(bytes);
  cut_requests_have_one_spelling(bytes);
  replies_are_their_bytes(bytes);
  every_message_comes_back(bytes);
  return 0;
}
