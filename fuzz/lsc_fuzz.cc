#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "sinew/core/assert.h"
#include "sinew/devices/lsc/lsc_wire.h"

// The LSC wire from both sides. For any bytes: a decoder that was cut off and goes on in a copy
// finds the same frames as one that ran through; every byte belongs to a frame, was skipped, or
// is still held; a frame is the very bytes it came from; and what a board or a host makes of it is
// written back as these bytes.

namespace {

using namespace sinew;
using namespace sinew::lsc;

std::vector<Frame> decode_all(FrameDecoder& decoder, std::span<const std::uint8_t> bytes) {
  std::vector<Frame> frames;
  for (const std::uint8_t byte : bytes) {
    if (const auto frame = decoder.push(byte)) frames.push_back(*frame);
  }
  return frames;
}

void same_when_cut(std::span<const std::uint8_t> bytes, LengthRule rule) {
  FrameDecoder whole(rule);
  const auto expected = decode_all(whole, bytes);
  const std::size_t cut = bytes.empty() ? 0 : bytes[0] % (bytes.size() + 1);
  FrameDecoder first(rule);
  auto frames = decode_all(first, bytes.first(cut));
  FrameDecoder second = first;
  for (const Frame& frame : decode_all(second, bytes.subspan(cut))) frames.push_back(frame);
  SINEW_ASSERT(frames == expected && second.skipped() == whole.skipped());
}

void frames_are_their_bytes(std::span<const std::uint8_t> bytes, LengthRule rule) {
  FrameDecoder decoder(rule);
  std::size_t in_frames = 0;
  for (std::size_t end = 1; end <= bytes.size(); ++end) {
    const auto frame = decoder.push(bytes[end - 1]);
    SINEW_ASSERT(in_frames + decoder.skipped() <= end);
    if (!frame) continue;
    const Bytes spelled = encode(*frame);
    SINEW_ASSERT(spelled.size() <= end);
    const auto came_from = bytes.subspan(end - spelled.size(), spelled.size());
    SINEW_ASSERT(std::equal(spelled.begin(), spelled.end(), came_from.begin()));
    in_frames += spelled.size();
    SINEW_ASSERT(decoder.at_boundary() && in_frames + decoder.skipped() == end);
  }
}

void meanings_have_one_spelling(const Frame& frame) {
  const Bytes bytes = encode(frame);
  for (const Dialect dialect : {Dialect::kLsc6, Dialect::kBus, Dialect::kEsp32}) {
    if (const auto request = decode_request(frame, dialect)) {
      SINEW_ASSERT(encode(*request) == bytes);
      FrameDecoder decoder;
      const auto again = decode_all(decoder, encode(*request));
      SINEW_ASSERT(again.size() == 1 && decode_request(again[0], dialect) == request);
    }
  }
  if (const auto reply = decode_reply(frame)) SINEW_ASSERT(encode(*reply) == bytes);
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::span bytes(data, size);
  for (const LengthRule rule : {LengthRule::kBounded, LengthRule::kAnything}) {
    same_when_cut(bytes, rule);
    frames_are_their_bytes(bytes, rule);
    FrameDecoder decoder(rule);
    for (const Frame& frame : decode_all(decoder, bytes)) meanings_have_one_spelling(frame);
  }
  // Any bytes as the parameters of any command, without a header to be found first.
  if (bytes.empty()) return 0;
  Frame frame{static_cast<std::uint8_t>(bytes[0] % 30), {}};
  for (const std::uint8_t byte : bytes.subspan(1)) {
    if (!frame.parameters.full()) frame.parameters.push_back(byte);
  }
  meanings_have_one_spelling(frame);
  return 0;
}
