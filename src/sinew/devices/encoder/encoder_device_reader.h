#pragma once

#include <cstdint>
#include <optional>
#include <span>

#include "sinew/core/instant.h"
#include "sinew/devices/encoder/encoder_wire.h"
#include "sinew/devices/encoder/encoder_wire_magnet.h"

namespace sinew {

/// An axis board's side of the encoder link: it reads POSITION over and over, and now and then
/// STATUS for the magnet. At 115200 baud a request and its reply take 0.7 ms. @rt
class EncoderReader {
 public:
  /// A value of POSITION, and when it was asked for.
  struct Position {
    std::uint16_t ticks = 0;  ///< 0..4095
    Instant asked_at;
  };

  /// Bytes that arrived since the last call, oldest first.
  void receive(std::span<const std::uint8_t> bytes, Instant now);
  /// Once a control cycle, behind receive(). @return  the request to send, if one is due
  std::optional<encoder_link::RequestBytes> poll(Instant now);
  /// The newest position, once.
  std::optional<Position> take_position();
  Magnet magnet() const { return magnet_; }

 private:
  /// Of positions; each 0.1 s at a control cycle of 4 ms.
  static constexpr int kStatusEach = 25;
  static constexpr int kStatusAfterSilent = 2;  ///< positions without a reply
  static constexpr int kSilentAfter = 4;        ///< requests without a reply
  /// A line that is never quiet.
  static constexpr Duration kBabble = std::chrono::milliseconds(100);

  void note(const Expected<encoder_link::Reply>& reply);

  encoder_link::Conversation link_{
      {.reply_timeout = std::chrono::milliseconds(6), .quiet_time = std::chrono::milliseconds(2)}};
  std::optional<Position> position_;
  Instant asked_at_;
  bool asks_status_ = false;
  int until_status_ = 1;  ///< positions to ask for before
  int unanswered_ = 0;
  Magnet magnet_ = Magnet::kUnknown;
};

/// Of the STATUS register.
Magnet magnet_in(std::uint16_t status);

}  // namespace sinew
