#include "sinew/devices/icp/icp_wire.h"

#include <algorithm>
#include <bit>

#include "sinew/core/assert.h"

namespace sinew::icp {
namespace {

constexpr std::size_t kBytesOfStatus1 = 6;
constexpr unsigned kMotorBits = 7;

template <class... Cases>
struct Overload : Cases... {
  using Cases::operator()...;
};

bool is_motor(unsigned motor) {
  return motor >= 1 && motor <= kMotors;
}

}  // namespace

std::uint8_t encode_step(const Step& step) {
  SINEW_ASSERT(is_motor(step.motor));
  const unsigned low = step.motor | (step.direction ? 8U : 0U);
  const unsigned bits = low | static_cast<unsigned>(std::popcount(low)) << 4U;
  return static_cast<std::uint8_t>(bits | (static_cast<unsigned>(std::popcount(bits)) & 1U) << 7U);
}

std::expected<Step, Refusal> decode_step(std::uint8_t byte) {
  const unsigned low = byte & 15U;
  if (static_cast<unsigned>(std::popcount(low)) != (byte >> 4U & 7U)) {
    return std::unexpected(Refusal::kOnes);
  }
  if (std::popcount(static_cast<unsigned>(byte)) % 2 != 0) return std::unexpected(Refusal::kParity);
  const unsigned motor = low & kMotorBits;
  if (!is_motor(motor)) return std::unexpected(Refusal::kNoMotor);
  return Step{static_cast<std::uint8_t>(motor), (low & 8U) != 0};
}

std::uint8_t encode_request(const Request& request) {
  return std::visit(Overload{[](const Init&) { return kInit; }, [](const Sync&) { return kSync; },
                             [](const Wake&) { return kWake; }, [](const Kill&) { return kKill; },
                             [](const StatusRequest&) { return kRequest; },
                             [](const Step& step) { return encode_step(step); },
                             [](const Select& select) {
                               SINEW_ASSERT(is_motor(select.motor));
                               return select.motor;
                             }},
                    request);
}

std::optional<std::expected<Request, Refusal>> RequestDecoder::push(std::uint8_t byte) {
  switch (state_) {
    case State::kLoop:
      if (byte != kInit) return std::nullopt;
      state_ = State::kCommand;
      return Request{Init{}};
    case State::kCommand:
      return read_command(byte);
    case State::kSelector:
      return read_selector(byte);
    case State::kDead:
      break;
  }
  return std::nullopt;
}

std::expected<Request, Refusal> RequestDecoder::read_command(std::uint8_t byte) {
  state_ = State::kLoop;
  if (byte == kSync) return Sync{};
  if (byte == kKill) {
    state_ = State::kDead;
    return Kill{};
  }
  if (byte == kRequest) {
    state_ = State::kSelector;
    return StatusRequest{};
  }
  if (byte == kWake && dialect_.knows_wake) return Wake{};
  const auto step = decode_step(byte);
  if (!step) return std::unexpected(step.error());
  return *step;
}

std::expected<Request, Refusal> RequestDecoder::read_selector(std::uint8_t byte) {
  state_ = State::kLoop;
  if (byte == kSync) return Sync{};
  if (dialect_.checks_selector) {
    const auto step = decode_step(byte);
    if (!step) return std::unexpected(step.error());
    return Select{step->motor};
  }
  const auto motor = static_cast<std::uint8_t>(byte & kMotorBits);
  if (!is_motor(motor)) return std::unexpected(Refusal::kNoMotor);
  return Select{motor};
}

StatusBytes encode_status(const Status& status) {
  const tmc222::Answer one = tmc222::encode_status1(status.one);
  const tmc222::Answer two = tmc222::encode_status2(status.two);
  StatusBytes out{};
  const auto second = std::copy_n(one.begin(), kBytesOfStatus1, out.begin());
  std::copy_n(two.begin() + 1, kStatusSize - kBytesOfStatus1, second);
  return out;
}

std::expected<Status, tmc222::Refusal> decode_status(
    std::span<const std::uint8_t, kStatusSize> bytes) {
  tmc222::Answer one{};
  tmc222::Answer two{};
  one.fill(0xFF);
  two.fill(0xFF);
  std::copy_n(bytes.begin(), kBytesOfStatus1, one.begin());
  two[0] = bytes[0];
  std::copy_n(bytes.begin() + kBytesOfStatus1, kStatusSize - kBytesOfStatus1, two.begin() + 1);
  const auto first = tmc222::decode_status1(one);
  if (!first) return std::unexpected(first.error());
  const auto second = tmc222::decode_status2(two);
  if (!second) return std::unexpected(second.error());
  Status status{*first, *second};
  status.one.parameters.secure_position = second->secure_position;
  return status;
}

ReplyBytes encode_reply(const Reply& reply) {
  ReplyBytes out;
  std::visit(Overload{[&](const Ack&) { out.push_back(kAck); },
                      [&](const Refused& refused) {
                        out.push_back(refused.why == Refusal::kParity ? kErrorParity : kErrorOnes);
                      },
                      [&](const Status& status) {
                        out.push_back(kAck);
                        for (const std::uint8_t byte : encode_status(status)) out.push_back(byte);
                      }},
             reply);
  return out;
}

void ReplyDecoder::expect(Due due) {
  due_ = due;
  bytes_.clear();
}

std::optional<std::expected<Reply, Garbage>> ReplyDecoder::push(std::uint8_t byte) {
  const auto garbage = [&] {
    expect(Due::kNothing);
    return std::unexpected(Garbage{byte});
  };
  if (due_ == Due::kNothing) return garbage();
  if (bytes_.empty()) {
    const bool refused = byte == kErrorOnes || byte == kErrorParity;
    if (!refused && byte != kAck) return garbage();
    if (refused || due_ == Due::kByte) {
      expect(Due::kNothing);
      if (byte == kAck) return Ack{};
      return Refused{byte == kErrorOnes ? Refusal::kOnes : Refusal::kParity};
    }
  }
  bytes_.push_back(byte);
  if (!bytes_.full()) return std::nullopt;
  StatusBytes block{};
  std::copy_n(bytes_.begin() + 1, kStatusSize, block.begin());
  const auto status = decode_status(block);
  if (!status) return garbage();
  expect(Due::kNothing);
  return *status;
}

}  // namespace sinew::icp
