#include "sinew/devices/encoder/encoder_wire.h"

#include <algorithm>
#include <cmath>

#include "sinew/core/assert.h"
#include "sinew/core/error_code.h"

namespace sinew::encoder_link {
RequestBytes encode(const Request& request) {
  return {kStart, static_cast<std::uint8_t>(request.name), kEnd};
}

ReplyBytes encode(const Reply& reply) {
  return {kStart, static_cast<std::uint8_t>(reply.name),
          static_cast<std::uint8_t>(reply.value & 0xFF),
          static_cast<std::uint8_t>(reply.value >> 8), kEnd};
}

std::optional<std::expected<Reply, ReplyFault>> ReplyDecoder::push(std::uint8_t byte) {
  SINEW_ASSERT(size_ < kReplySize);
  bytes_[size_++] = byte;
  if (size_ < kReplySize) return std::nullopt;
  size_ = 0;
  return reply();
}

std::expected<Reply, ReplyFault> ReplyDecoder::reply() const {
  if (bytes_[0] != kStart) return std::unexpected(ReplyFault::kWrongStart);
  if (bytes_[1] != static_cast<std::uint8_t>(asked_)) {
    return std::unexpected(ReplyFault::kWrongRegister);
  }
  if (bytes_[4] != kEnd) return std::unexpected(ReplyFault::kWrongEnd);
  const auto value = static_cast<std::uint16_t>(bytes_[2] | bytes_[3] << 8);
  if (asked_ == Register::kPosition && value >= kTurn) {
    return std::unexpected(ReplyFault::kOutOfRange);
  }
  return Reply{asked_, value};
}

double Unwrap::reach(Instant now) const {
  return speed_max_ * to_seconds(now - read_at_) + kNoise;
}

std::optional<std::int64_t> Unwrap::update(std::uint16_t position, Instant now) {
  SINEW_ASSERT(position < kTurn);
  const auto way_from = [&](std::int64_t from) {  // -2048..2047
    return ((position - from + kTurn / 2) % kTurn + kTurn) % kTurn - kTurn / 2;
  };
  if (!started_) {
    started_ = true;
    ticks_ = position;
    read_at_ = now;
    return ticks_;
  }
  const std::int64_t way = way_from(ticks_);
  const double reachable = reach(now);
  if (reachable >= kTurn / 2.0) certain_ = false;
  if (std::abs(static_cast<double>(way)) > reachable) {
    // A flipped bit, or a shaft that did what it cannot do; two that agree are no flipped bit.
    const bool agrees = doubted_ && std::abs(static_cast<double>(way_from(*doubted_))) <= reachable;
    if (!agrees) {
      doubted_ = position;
      return std::nullopt;
    }
    // The reading before may have been the flipped one, by as much as the shaft could have moved;
    // then this is the way back.
    const double explained = 3 * reachable;
    if (std::abs(static_cast<double>(way)) > explained || explained >= kTurn / 2.0) {
      certain_ = false;
    }
  }
  doubted_.reset();
  ticks_ += way;
  read_at_ = now;
  return ticks_;
}

bool Conversation::ready(Instant now) {
  if (state_ == State::kQuiet && now - since_ >= timing_.quiet_time) state_ = State::kIdle;
  return state_ == State::kIdle;
}

RequestBytes Conversation::ask(Register name, Instant now) {
  SINEW_ASSERT(ready(now));
  state_ = State::kWaiting;
  decoder_ = ReplyDecoder(name);
  since_ = now;
  return encode(Request{name});
}

std::optional<Expected<Reply>> Conversation::receive(std::uint8_t byte, Instant now) {
  if (state_ != State::kWaiting) {
    ++stray_bytes_;
    state_ = State::kQuiet;
    since_ = now;
    return std::nullopt;
  }
  const auto result = decoder_.push(byte);
  if (!result) return std::nullopt;
  if (*result) {
    state_ = State::kIdle;
    return Expected<Reply>(**result);
  }
  state_ = State::kQuiet;
  since_ = now;
  return Expected<Reply>(std::unexpected(Error{ErrorCode::kUnexpectedReply}));
}

std::optional<Expected<Reply>> Conversation::poll(Instant now) {
  if (state_ != State::kWaiting || now - since_ < timing_.reply_timeout) return std::nullopt;
  const double waited = to_seconds(now - since_);
  state_ = State::kQuiet;
  since_ = now;
  return Expected<Reply>(std::unexpected(
      Error{ErrorCode::kDeviceSilent, -1, waited, to_seconds(timing_.reply_timeout)}));
}

}  // namespace sinew::encoder_link
