#include "sinew/devices/arm_link/arm_link_driver_channel.h"

#include <algorithm>

#include "sinew/core/assert.h"

namespace sinew::arm_link {

void Channel::reset() {
  abandon();
  answered_.reset();
  output_.clear();
  decoder_ = {};
  silent_ = false;
  session_ = 0;
}

void Channel::send(Request request, Instant now) {
  SINEW_ASSERT(!busy());
  // A hello begins anew, with numbers that no request of before has.
  if (request.kind == Kind::kHello) sequence_ = static_cast<std::uint16_t>(sequence_ + 1000);
  request.session = session_;
  request.sequence =
      static_cast<std::uint16_t>(mcu::arm_link::is_numbered(request.kind) ? sequence_ + 1 : 0);
  request_ = request;
  sent_.clear();
  silent_ = false;
  ++requests;
  put(now);
}

void Channel::abandon() {
  request_.reset();
  due_.reset();
}

void Channel::put(Instant now) {
  request_->tag = ++tag_;
  sent_.push_back({tag_, now});
  std::uint8_t frame[mcu::arm_link::kRequestMax];
  const std::size_t size = mcu::arm_link::encode(*request_, frame);
  output_.clear();
  const bool hello = request_->kind == Kind::kHello;
  // A board that has heard no good frame yet may be in the middle of a request of its old wires.
  if (hello) output_ = {0, 0};
  for (const std::uint8_t byte : cobs::encode(std::span(frame, size))) output_.push_back(byte);
  due_ = now + (hello ? timing_.hello : timing_.reply);
}

/// When the frame with that tag was sent, where its reply counts.
std::optional<Instant> Channel::sent_with(std::uint8_t tag) const {
  if (request_->kind == Kind::kHello && tag != tag_) return std::nullopt;
  const auto* const found = std::ranges::find(sent_, tag, &Sent::tag);
  return found != sent_.end() ? std::optional(found->at) : std::nullopt;
}

void Channel::receive(std::span<const std::uint8_t> bytes, Instant /*now*/) {
  for (const std::uint8_t byte : bytes) {
    const auto frame = decoder_.push(byte);
    if (!frame) continue;
    Reply reply{};
    const bool good =
        mcu::arm_link::decode(frame->data(), static_cast<std::uint8_t>(frame->size()), reply) &&
        request_ && reply.kind == request_->kind;
    const auto asked = good ? sent_with(reply.tag) : std::nullopt;
    if (!asked) {
      ++unexpected;
      continue;
    }
    if (request_->kind == Kind::kHello) session_ = reply.session;
    if (reply.session == session_) sequence_ = reply.sequence;
    answered_ = Answered{*request_, reply, *asked};
    abandon();
  }
}

void Channel::poll(Instant now) {
  if (!due_ || now < *due_) return;
  ++timeouts;
  const bool hello = request_->kind == Kind::kHello;
  const int tries = std::min(timing_.tries, static_cast<int>(kTriesMax));
  if (!hello && static_cast<int>(sent_.size()) >= tries) {
    abandon();
    silent_ = true;
    return;
  }
  if (sent_.full()) sent_.clear();
  ++retries;
  put(now);
}

}  // namespace sinew::arm_link
