#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "decoders.h"
#include "sinew/core/assert.h"
#include "sinew/devices/encoder/encoder_wire.h"
#include "sinew/mcu/encoder_node.h"

// The encoder link from both sides. For any bytes: a decoder that was cut off and goes on in a copy
// says the same as one that ran through; what was accepted is spelled as the very bytes it came
// from; every message comes back; and whatever answers arrive, when, and in which order, an
// unwrapped position never goes farther than the shaft can.

namespace {

using namespace sinew;
using fuzz::decode_all;
using fuzz::same_when_cut;
using namespace sinew::encoder_link;

/// A node that has a value in each register.
EncoderNode settled_node() {
  EncoderNode node;
  encoder_node_start(&node);
  constexpr std::uint8_t kChip[] = {0x20, 0x0A, 0x55};
  for (int i = 0; i < 200; ++i) encoder_node_sample(&node, kChip, 1);
  return node;
}

void node_answers_requests_and_nothing_else(std::span<const std::uint8_t> bytes) {
  EncoderNode node = settled_node();
  for (std::size_t end = 1; end <= bytes.size(); ++end) {
    ReplyBytes reply{};
    const bool answered = encoder_node_receive(&node, bytes[end - 1], reply.data());
    const bool there = end >= kRequestSize && bytes[end - 3] == kStart && bytes[end - 2] >= 1 &&
                       bytes[end - 2] <= 4 && bytes[end - 1] == kEnd;
    SINEW_ASSERT(answered == there);
    SINEW_ASSERT(!answered || (reply[0] == kStart && reply[1] == bytes[end - 2]));
  }
}

/// Each byte is a reading: good, without magnet, or none, with times between them.
void node_survives_any_readings(std::span<const std::uint8_t> bytes) {
  EncoderNode node;
  encoder_node_start(&node);
  for (std::size_t i = 0; i + 3 < bytes.size(); i += 4) {
    encoder_node_sample(&node, bytes[i] % 4 == 0 ? nullptr : &bytes[i + 1], bytes[i]);
    SINEW_ASSERT(node.position < kTurn);
    for (const Register name : {Register::kPosition, Register::kVelocity, Register::kStatus}) {
      for (const std::uint8_t byte : encode(Request{name})) {
        ReplyBytes reply{};
        static_cast<void>(encoder_node_receive(&node, byte, reply.data()));
      }
    }
  }
}

void replies_are_their_bytes(Register asked, std::span<const std::uint8_t> bytes) {
  ReplyDecoder decoder(asked);
  for (std::size_t end = 1; end <= bytes.size(); ++end) {
    const auto result = decoder.push(bytes[end - 1]);
    SINEW_ASSERT(result.has_value() == (end % kReplySize == 0));
    if (!result || !*result) continue;
    const auto spelled = encode(**result);
    SINEW_ASSERT(std::equal(spelled.begin(), spelled.end(), &bytes[end - kReplySize]));
  }
}

void every_message_comes_back(std::span<const std::uint8_t> bytes) {
  for (std::size_t i = 0; i + 1 < bytes.size(); ++i) {
    const auto name = static_cast<Register>(1 + bytes[i] % 4);
    auto value = static_cast<std::uint16_t>(bytes[i] | bytes[i + 1] << 8);
    if (name == Register::kPosition) value %= kTurn;
    ReplyDecoder replies(name);
    const auto answered = decode_all(replies, encode(Reply{name, value}));
    SINEW_ASSERT(answered.size() == 1 && answered[0] == Reply({name, value}));
  }
}

/// Each byte is a thing that happens: a byte on the line, or time.
void conversation_stays_sane(std::span<const std::uint8_t> bytes) {
  constexpr double kSpeed = 20'000;  // ticks/s
  Conversation link{Conversation::Timing{}};
  Unwrap unwrap(kSpeed);
  Instant now{};
  Instant accepted_at{};
  std::int64_t ticks = 0;
  bool started = false;
  for (const std::uint8_t byte : bytes) {
    now += std::chrono::microseconds(byte % 8 * 500);
    link.poll(now);
    if (link.ready(now)) link.ask(Register::kPosition, now);
    const auto result = link.receive(byte, now);
    if (!result || !*result) continue;
    const auto position = unwrap.update((*result)->value, now);
    if (!position) continue;
    SINEW_ASSERT(((*position - (*result)->value) % kTurn) == 0);
    const auto way = static_cast<double>(std::abs(*position - ticks));
    const double reach = kSpeed * to_seconds(now - accepted_at) + 4;
    SINEW_ASSERT(!started || way <= kTurn / 2.0);
    SINEW_ASSERT(!started || !unwrap.certain() || way <= 3 * reach);
    started = true;
    ticks = *position;
    accepted_at = now;
  }
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::span bytes(data, size);
  for (const Register name : {Register::kPosition, Register::kVelocity, Register::kStatus}) {
    same_when_cut(ReplyDecoder{name}, bytes);
    replies_are_their_bytes(name, bytes);
  }
  node_answers_requests_and_nothing_else(bytes);
  node_survives_any_readings(bytes);
  every_message_comes_back(bytes);
  conversation_stays_sane(bytes);
  return 0;
}
