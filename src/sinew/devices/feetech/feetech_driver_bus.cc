#include "sinew/devices/feetech/feetech_driver_bus.h"

#include <algorithm>

#include "sinew/core/assert.h"

namespace sinew {

using namespace feetech;

namespace {

constexpr double kBitsPerByte = 10;
constexpr std::size_t kFrame = 6;  // bytes of a packet beside its parameters
/// Between bytes that a port was given and their last bit on the wire.
constexpr Duration kPortDelay = std::chrono::milliseconds(1);
constexpr Duration kReplyTimeoutMost = std::chrono::milliseconds(320);

}  // namespace

void FeetechBus::reset(Instant now) {
  decoder_.reset();
  waiting_.clear();
  output_.clear();
  wire_free_ = late_until_ = now;
}

Duration FeetechBus::bytes_time(std::size_t bytes) const {
  return from_seconds(static_cast<double>(bytes) * kBitsPerByte / timing_.baud);
}

Duration FeetechBus::ask_time(std::size_t servos, std::size_t count) const {
  return bytes_time(kFrame + 2 + servos + servos * (kFrame + count)) +
         static_cast<int>(servos) * timing_.turn_round + kPortDelay;
}

Duration FeetechBus::write_time(std::size_t servos, std::size_t count) const {
  return bytes_time(kFrame + 2 + servos * (1 + count));
}

void FeetechBus::write(const Request& request, Instant now) {
  const Bytes bytes = encode(request);
  SINEW_ASSERT(output_.size() + bytes.size() <= output_.capacity());
  for (const std::uint8_t byte : bytes) output_.push_back(byte);
  wire_free_ = std::max(now, wire_free_) + bytes_time(bytes.size());
}

void FeetechBus::ask(const Read& read, Instant now) {
  SINEW_ASSERT(!asking());
  write(read, now);
  wait_for({read.id}, read.count, now);
}

void FeetechBus::ask(const SyncRead& read, Instant now) {
  SINEW_ASSERT(!asking());
  write(read, now);
  wait_for(read.ids, read.count, now);
}

void FeetechBus::wait_for(const Ids& ids, std::uint8_t count, Instant now) {
  waiting_ = ids;
  count_ = count;
  asked_at_ = now;
  wire_free_ += ask_time(ids.size(), count);
  due_ = wire_free_ + timing_.reply_timeout;
}

std::optional<Reply> FeetechBus::receive(std::uint8_t byte, Instant now, DriverHealth& health) {
  const PacketDecoder::Result result = decoder_.push(byte);
  if (result == PacketDecoder::Result::kMore) return std::nullopt;
  const bool packet = result == PacketDecoder::Result::kPacket;
  // What is for all is one of ours: an adapter without a direction of its own hears them.
  if (packet && decoder_.packet().id == kBroadcast) return std::nullopt;
  const auto reply = packet ? decode_reply(decoder_.packet()) : std::nullopt;
  const bool fits = reply && reply->data.size() == count_;
  // This adapter, or the network before it, takes longer.
  if (fits && !asking() && now < late_until_) {
    timing_.reply_timeout = std::min(2 * timing_.reply_timeout, kReplyTimeoutMost);
  }
  const auto whose = fits ? std::ranges::find(waiting_, reply->id) : waiting_.end();
  if (whose == waiting_.end()) {
    ++health.unexpected;
    return std::nullopt;
  }
  *whose = waiting_.back();
  waiting_.pop_back();
  if (waiting_.empty()) wire_free_ = std::min(wire_free_, now);
  return reply;
}

Ids FeetechBus::give_up(Instant now) {
  if (!asking() || now < due_) return {};
  const Ids missing = waiting_;
  waiting_.clear();
  decoder_.reset();
  late_until_ = now + timing_.reply_timeout;
  return missing;
}

}  // namespace sinew
