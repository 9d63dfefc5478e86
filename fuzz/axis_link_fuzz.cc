#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "sinew/core/assert.h"
#include "sinew/devices/axis_link/axis_link_wire.h"
#include "sinew/wire/cobs.h"
#include "sinew/wire/crc32c.h"

// The axis link from both sides. For any bytes: a stream decoder that was cut off and goes on in a
// copy says the same as one that ran through, and what it gives is spelled one way; twelve bytes
// that are sealed with their checksum and accepted are written as the very bytes they came from;
// and one flipped bit of them is never accepted.

namespace {

using namespace sinew;
using namespace sinew::axis_link;
using Frames = std::vector<std::vector<std::uint8_t>>;

void push(cobs::Decoder& decoder, std::span<const std::uint8_t> bytes, Frames& frames) {
  for (const std::uint8_t byte : bytes) {
    const auto frame = decoder.push(byte);
    if (!frame) continue;
    SINEW_ASSERT(!frame->empty() && frame->size() <= cobs::kFrameMax);
    frames.emplace_back(frame->begin(), frame->end());
  }
}

void same_when_cut(std::span<const std::uint8_t> bytes) {
  cobs::Decoder whole;
  Frames expected;
  push(whole, bytes, expected);
  const std::size_t cut = bytes.empty() ? 0 : bytes[0] % (bytes.size() + 1);
  cobs::Decoder first;
  Frames frames;
  push(first, bytes.first(cut), frames);
  cobs::Decoder second = first;
  push(second, bytes.subspan(cut), frames);
  SINEW_ASSERT(frames == expected);
  SINEW_ASSERT(second.dropped() == whole.dropped());
}

void frames_have_one_spelling(std::span<const std::uint8_t> bytes) {
  cobs::Decoder decoder;
  Frames frames;
  push(decoder, bytes, frames);
  for (const auto& frame : frames) {
    const cobs::Stream stream = cobs::encode(frame);
    SINEW_ASSERT(std::count(stream.begin() + 1, stream.end() - 1, cobs::kDelimiter) == 0);
    // The same bytes stood in the input, with a delimiter behind them.
    const auto body = std::span<const std::uint8_t>(stream).subspan(1);
    SINEW_ASSERT(std::ranges::search(bytes, body).begin() != bytes.end());
    cobs::Decoder again;
    Frames decoded;
    push(again, stream, decoded);
    SINEW_ASSERT(decoded.size() == 1 && decoded[0] == frame);
  }
}

void check_frame(const Frame& frame) {
  const auto request = decode_request(frame);
  const auto reply = decode_reply(frame);
  SINEW_ASSERT(!(request && reply));
  if (request) SINEW_ASSERT(encode(*request) == frame);
  if (reply) SINEW_ASSERT(encode(*reply) == frame);
  if (!request && !reply) return;
  for (std::size_t bit = 0; bit < 8 * kFrameSize; ++bit) {
    Frame hit = frame;
    hit[bit / 8] = static_cast<std::uint8_t>(hit[bit / 8] ^ 1U << (bit % 8));
    SINEW_ASSERT(!decode_request(hit) && !decode_reply(hit));
  }
}

/// The first bytes of the input as a frame: as they are, and with the checksum that they need.
void frames_are_their_bytes(std::span<const std::uint8_t> bytes) {
  Frame frame{};
  std::copy_n(bytes.begin(), std::min(bytes.size(), frame.size()), frame.begin());
  check_frame(frame);
  const std::uint32_t crc = crc32c(std::span(frame).first<12>());
  for (unsigned k = 0; k < 4; ++k) frame[12 + k] = static_cast<std::uint8_t>(crc >> (8 * k));
  check_frame(frame);
  frame[0] = static_cast<std::uint8_t>((frame[0] & 0x1F) | kVersion << 5);
  const std::uint32_t again = crc32c(std::span(frame).first<12>());
  for (unsigned k = 0; k < 4; ++k) frame[12 + k] = static_cast<std::uint8_t>(again >> (8 * k));
  check_frame(frame);
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::span bytes(data, size);
  same_when_cut(bytes);
  frames_have_one_spelling(bytes);
  frames_are_their_bytes(bytes);
  return 0;
}
