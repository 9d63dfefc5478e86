#include "sinew/devices/encoder/encoder_device_reader.h"

#include <utility>

namespace sinew {

using encoder_link::Register;

Magnet magnet_in(std::uint16_t status) {
  namespace bits = encoder_link::status;
  if ((status & bits::kBusError) != 0) return Magnet::kNoReply;
  return magnet_from((status & bits::kMagnet) != 0, (status & bits::kTooWeak) != 0,
                     (status & bits::kTooStrong) != 0);
}

void EncoderReader::note(const Expected<encoder_link::Reply>& reply) {
  if (!reply) {
    if (++unanswered_ >= kSilentAfter) magnet_ = Magnet::kNoReply;
    // A silent POSITION may be a missing magnet, which STATUS says. A node that knows only the
    // document's registers does not answer STATUS.
    if (!asks_status_ && unanswered_ >= kStatusAfterSilent) until_status_ = 0;
    return;
  }
  unanswered_ = 0;
  if (reply->name == Register::kStatus) magnet_ = magnet_in(reply->value);
  if (reply->name != Register::kPosition) return;
  position_ = Position{reply->value, asked_at_};
  // A position is there again: so is its magnet.
  if (magnet_ != Magnet::kMissing && magnet_ != Magnet::kNoReply) return;
  magnet_ = Magnet::kUnknown;
  until_status_ = 0;
}

void EncoderReader::receive(std::span<const std::uint8_t> bytes, Instant now) {
  for (const std::uint8_t byte : bytes) {
    if (const auto reply = link_.receive(byte, now)) note(*reply);
  }
}

std::optional<encoder_link::RequestBytes> EncoderReader::poll(Instant now) {
  if (const auto silence = link_.poll(now)) note(*silence);
  if (!link_.ready(now)) {
    if (now - asked_at_ > kBabble) magnet_ = Magnet::kNoReply;
    return std::nullopt;
  }
  asked_at_ = now;
  asks_status_ = until_status_ == 0;
  until_status_ = asks_status_ ? kStatusEach : until_status_ - 1;
  return link_.ask(asks_status_ ? Register::kStatus : Register::kPosition, now);
}

std::optional<EncoderReader::Position> EncoderReader::take_position() {
  return std::exchange(position_, std::nullopt);
}

}  // namespace sinew
